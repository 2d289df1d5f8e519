//! A hydraulic cylinder about a pin, with the friction of its seals and its two pressure sensors.
//!
//! ```text
//! l^2 = a^2 + c^2 - 2 a c cos(q + delta)        r = dl/dq = a c sin(q + delta)/l
//! M = r [n (A_h p_h - A_r p_r) - F_f]           dF_f = (F_c sgn(dl) - F_f) |dl|/s          (Dahl 1968)
//! ```
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | a, c | `base_distance`, `rod_distance` | cylinder base to pin, pin to rod eye | m |
//! | delta | `angle` | angle between the two at joint angle 0 | rad |
//! | n, A_h, A_r | `count`, `head_area`, `rod_area` | cylinders side by side, areas of head and rod side of one | -, m^2 |
//! | F_c | `friction` | friction of the seals, as a share of n A_h 20 MPa | - |
//! | s | `TRAVEL` | travel within which the friction follows the motion | m |

use crate::noise::Noise;

/// Pressure at which the friction is stated [Pa].
const FULL_PRESSURE: f64 = 20e6;
/// Travel within which the seals' friction follows the motion [m]; some tenths of a millimetre in Dahl's model of rubber seals.
const TRAVEL: f64 = 0.4e-3;
/// Pressure of the unloaded side [Pa].
const RETURN_PRESSURE: f64 = 0.8e6;
/// Increase of the return pressure with the speed of the rod [Pa s/m].
const RETURN_FLOW: f64 = 1.5e6;

/// Cylinders side by side about one pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Number of cylinders (n).
    pub count: f64,
    /// Area of the head side of one (A_h) [m^2].
    pub head_area: f64,
    /// Area of its rod side (A_r) [m^2].
    pub rod_area: f64,
    /// Cylinder base to pin (a) \[m\].
    pub base_distance: f64,
    /// Pin to rod eye (c) \[m\].
    pub rod_distance: f64,
    /// Angle between the two at joint angle 0 (delta) \[rad\].
    pub angle: f64,
    /// Friction of the seals, as a share of n A_h 20 MPa.
    pub friction: f64,
}

impl Cylinder {
    /// The cylinder of a machine with `long` times the length and `heavy` times the mass, at equal pressures.
    #[must_use]
    pub fn scaled(self, long: f64, heavy: f64) -> Self {
        Self {
            head_area: heavy * self.head_area,
            rod_area: heavy * self.rod_area,
            base_distance: long * self.base_distance,
            rod_distance: long * self.rod_distance,
            ..self
        }
    }

    /// Length at a joint angle \[m\].
    #[must_use]
    pub fn length(&self, joint: f64) -> f64 {
        let [a, c] = [self.base_distance, self.rod_distance];
        (a * a + c * c - 2.0 * a * c * (joint + self.angle).cos()).sqrt()
    }

    /// Lever at a joint angle, positive if an extension raises the joint \[m\].
    #[must_use]
    pub fn lever(&self, joint: f64) -> f64 {
        let sin = (joint + self.angle).sin();
        self.base_distance * self.rod_distance * sin / self.length(joint)
    }

    /// Friction of the seals in motion \[N\].
    #[must_use]
    pub fn seal_force(&self) -> f64 {
        self.friction * self.count * self.head_area * FULL_PRESSURE
    }
}

/// Errors of the pressure sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gauges {
    /// Standard deviation of the noise of a sample \[Pa\].
    pub noise: f64,
    /// Standard deviation of the zero of each sensor \[Pa\].
    pub zero: f64,
    /// Standard deviation of its span, as a share.
    pub span: f64,
    /// Quantisation step of the reading \[Pa\]; 0 for none.
    pub quantum: f64,
}

impl Default for Gauges {
    /// Values of data sheets of mobile hydraulics: 0.25 % of 40 MPa, half of it noise.
    fn default() -> Self {
        Self {
            noise: 50e3,
            zero: 100e3,
            span: 0.0025,
            quantum: 0.0,
        }
    }
}

/// A cylinder under load, with its pressure sensors.
#[derive(Clone, Debug)]
pub struct Piston {
    cylinder: Cylinder,
    gauges: Gauges,
    /// Zero [Pa] and gain of head and rod side.
    errors: [(f64, f64); 2],
    noise: Noise,
    /// Friction of the seals in the direction of extension [N], and the last length [m].
    seals: f64,
    length: Option<f64>,
}

impl Piston {
    /// A cylinder with sensor errors and noise from a stream.
    #[must_use]
    pub fn new(cylinder: Cylinder, gauges: Gauges, mut noise: Noise) -> Self {
        let errors = std::array::from_fn(|_| {
            let zero = gauges.zero * noise.normal();
            (zero, 1.0 + gauges.span * noise.normal())
        });
        Self {
            cylinder,
            gauges,
            errors,
            noise,
            seals: 0.0,
            length: None,
        }
    }

    /// Readings of head and rod side \[Pa\] for a moment [N m] at a joint angle \[rad\], `elapsed` after the last call \[s\].
    pub fn show(&mut self, moment: f64, joint: f64, elapsed: f64) -> [f64; 2] {
        let pressures = self.pressures(moment, joint, elapsed);
        let Gauges { noise, quantum, .. } = self.gauges;
        let mut shown = [0.0; 2];
        for ((shown, true_one), (zero, gain)) in shown.iter_mut().zip(pressures).zip(self.errors) {
            let value = gain * true_one + zero + noise * self.noise.normal();
            *shown = if quantum > 0.0 {
                (value / quantum).round() * quantum
            } else {
                value
            };
        }
        shown
    }

    /// The true pressures of head and rod side [Pa].
    fn pressures(&mut self, moment: f64, joint: f64, elapsed: f64) -> [f64; 2] {
        let c = self.cylinder;
        let length = c.length(joint);
        let travel = length - self.length.replace(length).unwrap_or(length);
        // Exact if the motion does not reverse in between.
        let towards = c.seal_force() * travel.signum();
        self.seals = towards + (self.seals - towards) * (-travel.abs() / TRAVEL).exp();
        let force = moment / c.lever(joint) + self.seals;
        let speed = if elapsed > 0.0 {
            travel.abs() / elapsed
        } else {
            0.0
        };
        let back = RETURN_PRESSURE + RETURN_FLOW * speed;
        let [head, rod] = [c.count * c.head_area, c.count * c.rod_area];
        let carried = (force + rod * back) / head;
        if carried >= back {
            [carried, back]
        } else {
            [back, (head * back - force) / rod]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYLINDER: Cylinder = Cylinder {
        count: 2.0,
        head_area: 0.01,
        rod_area: 0.007,
        base_distance: 0.6,
        rod_distance: 1.3,
        angle: 1.3,
        friction: 0.03,
    };

    fn exact(cylinder: Cylinder) -> Piston {
        let gauges = Gauges {
            noise: 0.0,
            zero: 0.0,
            span: 0.0,
            quantum: 0.0,
        };
        Piston::new(cylinder, gauges, Noise::new(1))
    }

    /// Force from the sensor readings [N].
    fn force(c: &Cylinder, [head, rod]: [f64; 2]) -> f64 {
        c.count * (c.head_area * head - c.rod_area * rod)
    }

    #[test]
    fn the_lever_is_the_derivative_of_the_length() {
        for k in -8..14 {
            let q = 0.1 * f64::from(k);
            let slope = (CYLINDER.length(q + 1e-6) - CYLINDER.length(q - 1e-6)) / 2e-6;
            assert!((CYLINDER.lever(q) - slope).abs() < 1e-8, "{q}");
        }
    }

    #[test]
    fn a_moment_of_either_sign_is_in_the_pressures_and_no_pressure_is_below_that_of_the_return() {
        let smooth = Cylinder {
            friction: 0.0,
            ..CYLINDER
        };
        for moment in [-40e3, -1e3, 0.0, 1e3, 90e3] {
            let shown = exact(smooth).show(moment, 0.4, 0.01);
            let reported = smooth.lever(0.4) * force(&smooth, shown);
            assert!((reported - moment).abs() < 1e-6, "{moment} {reported}");
            assert!(
                shown.iter().all(|p| *p >= RETURN_PRESSURE - 1e-6),
                "{shown:?}"
            );
        }
    }

    #[test]
    fn seals_hold_against_the_motion_and_keep_it_at_rest() {
        let mut piston = exact(CYLINDER);
        let at = |piston: &mut Piston, q: f64| {
            force(&CYLINDER, piston.show(30e3, q, 0.01)) - 30e3 / CYLINDER.lever(q)
        };
        for k in 0..200 {
            at(&mut piston, 0.3 + 0.001 * f64::from(k));
        }
        let up = at(&mut piston, 0.5);
        assert!((up / CYLINDER.seal_force() - 1.0).abs() < 1e-6, "{up}");
        assert_eq!(at(&mut piston, 0.5), up);
        for k in 0..200 {
            at(&mut piston, 0.5 - 0.001 * f64::from(k));
        }
        let down = at(&mut piston, 0.3);
        assert!((down / CYLINDER.seal_force() + 1.0).abs() < 1e-6, "{down}");
    }
}
