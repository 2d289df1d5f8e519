//! Inertia of the upper body about the swing axis as a function of posture, attachment and payload.
//!
//! With the angles of the links to the horizontal `a1 = q_boom, a2 = a1 + q_arm, a3 = a2 + q_bucket`:
//! ```text
//! r1 = x0 + c1 cos a1;  rA = x0 + L1 cos a1;  r2 = rA + c2 cos a2;  rB = rA + L2 cos a2
//! r3 = rB + c3 cos a3;  rp = rB + cp cos a3
//! J  = J_u + sum m_i r_i^2 + I_i cos^2 a_i + R_i sin^2 a_i  +  m (rp^2 + kp^2)
//! ```

use super::path::Posture;

/// A body of the front: boom, arm, or the attachment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Mass m \[kg\].
    pub mass: f64,
    /// Distance c of its centre of mass from its pin, along the link \[m\].
    pub centre: f64,
    /// Inertia I about the vertical through its centre of mass when the link lies flat [kg m^2].
    pub flat_inertia: f64,
    /// The same inertia R when the link stands upright [kg m^2].
    pub upright_inertia: f64,
}

/// What the arm carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attachment {
    /// The body.
    pub link: Link,
    /// Distance cp of the payload's centre from the attachment's pin \[m\].
    pub payload_centre: f64,
    /// Radius of gyration kp of the payload \[m\].
    pub payload_gyration: f64,
}

impl Attachment {
    /// The standard bucket of 0.18 m^3; 288 and 423 kg fill it at 1600 and 2350 kg/m^3.
    pub fn bucket() -> Self {
        let link = Link {
            mass: 165.0,
            centre: 0.42,
            flat_inertia: 14.0,
            upright_inertia: 9.0,
        };
        Self {
            link,
            payload_centre: 0.48,
            payload_gyration: 0.25,
        }
    }

    /// A concrete crusher.
    pub fn crusher() -> Self {
        let link = Link {
            mass: 520.0,
            centre: 0.62,
            flat_inertia: 48.0,
            upright_inertia: 22.0,
        };
        Self {
            link,
            payload_centre: 0.95,
            payload_gyration: 0.25,
        }
    }
}

/// Dimensions and masses of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Distance x0 of the boom pin from the swing axis \[m\].
    pub boom_pin: f64,
    /// Length L1 of the boom \[m\].
    pub boom_length: f64,
    /// Length L2 of the arm \[m\].
    pub arm_length: f64,
    /// The boom.
    pub boom: Link,
    /// The arm.
    pub arm: Link,
    /// Bucket or tool.
    pub attachment: Attachment,
    /// Inertia J_u of the upper body without its front [kg m^2].
    pub upper_inertia: f64,
}

/// Inertia at one posture: `base + factor m` for a payload of mass m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// Inertia J_e of the empty machine [kg m^2].
    pub base: f64,
    /// Payload factor g = rp^2 + kp^2 [m^2].
    pub factor: f64,
    /// Rate of `base` [kg m^2/s].
    pub base_rate: f64,
    /// Rate of `factor` [m^2/s].
    pub factor_rate: f64,
}

impl Inertia {
    /// Total inertia J with a payload [kg m^2].
    pub fn total(&self, payload: f64) -> f64 {
        self.base + payload * self.factor
    }

    /// Its rate due to posture alone, the payload frozen [kg m^2/s].
    pub fn posture_rate(&self, payload: f64) -> f64 {
        self.base_rate + payload * self.factor_rate
    }
}

impl Geometry {
    /// The 5.5 t machine with an attachment.
    pub fn with(attachment: Attachment) -> Self {
        Self {
            boom_pin: 0.6317,
            boom_length: 3.00,
            arm_length: 1.60,
            boom: Link {
                mass: 430.0,
                centre: 1.38,
                flat_inertia: 330.0,
                upright_inertia: 9.0,
            },
            arm: Link {
                mass: 210.0,
                centre: 0.67,
                flat_inertia: 46.0,
                upright_inertia: 4.0,
            },
            attachment,
            upper_inertia: 1698.0,
        }
    }

    /// Inertia and its rate at a posture \[rad\] that moves at `rate` [rad/s].
    pub fn inertia(&self, posture: Posture, rate: Posture) -> Inertia {
        let [boom, arm, tool] = absolute(posture, rate).map(Direction::new);
        let arm_pin = self.boom_pin + self.boom_length * boom.cos;
        let arm_pin_rate = self.boom_length * boom.cos_rate;
        let tool_pin = arm_pin + self.arm_length * arm.cos;
        let tool_pin_rate = arm_pin_rate + self.arm_length * arm.cos_rate;

        let mut inertia = Inertia {
            base: self.upper_inertia,
            ..Inertia::default()
        };
        inertia.add(&self.boom, &boom, self.boom_pin, 0.0);
        inertia.add(&self.arm, &arm, arm_pin, arm_pin_rate);
        inertia.add(&self.attachment.link, &tool, tool_pin, tool_pin_rate);

        let reach = tool_pin + self.attachment.payload_centre * tool.cos;
        let reach_rate = tool_pin_rate + self.attachment.payload_centre * tool.cos_rate;
        inertia.factor = reach * reach + self.attachment.payload_gyration.powi(2);
        inertia.factor_rate = 2.0 * reach * reach_rate;
        inertia
    }
}

impl Inertia {
    /// Adds a link whose pin is `pin` from the swing axis and moves away from it at `pin_rate`.
    fn add(&mut self, link: &Link, direction: &Direction, pin: f64, pin_rate: f64) {
        let Direction {
            cos,
            sin,
            cos_rate,
            sin_rate,
        } = *direction;
        let radius = pin + link.centre * cos;
        let radius_rate = pin_rate + link.centre * cos_rate;
        self.base += link.mass * radius * radius
            + link.flat_inertia * cos * cos
            + link.upright_inertia * sin * sin;
        self.base_rate += 2.0 * link.mass * radius * radius_rate
            + 2.0 * link.flat_inertia * cos * cos_rate
            + 2.0 * link.upright_inertia * sin * sin_rate;
    }
}

/// Angles of the links to the horizontal and their rates, from the relative joint angles.
fn absolute(posture: Posture, rate: Posture) -> [(f64, f64); 3] {
    let arm = (posture[0] + posture[1], rate[0] + rate[1]);
    [
        (posture[0], rate[0]),
        arm,
        (arm.0 + posture[2], arm.1 + rate[2]),
    ]
}

struct Direction {
    cos: f64,
    sin: f64,
    cos_rate: f64,
    sin_rate: f64,
}

impl Direction {
    fn new((angle, rate): (f64, f64)) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self {
            cos,
            sin,
            cos_rate: -sin * rate,
            sin_rate: cos * rate,
        }
    }
}
