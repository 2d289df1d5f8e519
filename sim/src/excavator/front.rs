//! Boom and arm cylinders: the moments that they carry, and the readings of their pressure sensors.
//!
//! ```text
//! M = sum_i m_i [x_i (g cos(pitch) cos(roll) + z_i'') - z_i (x_i'' + g sin(pitch) - w^2 (x_0 + x_i))]
//!     + sum_i [I_i alpha_i'' + w^2 (I_i - R_i) sin(alpha_i) cos(alpha_i)] - (x_g F_z - z_g F_x)
//! ```
//! about the boom foot over boom, arm, bucket and payload; about the arm pin, with x, z from there in the first two brackets,
//! without the boom. F: force of the ground on the bucket's edge at x_g, z_g, while it digs.

use super::geometry::{Geometry, Link};
use super::path::Posture;
use crate::cylinder::{Cylinder, Gauges, Piston};
use crate::noise::Noise;

/// Standard gravity [m/s^2].
const GRAVITY: f64 = 9.806_65;
/// Bucket pin to edge, in distances of the payload's centre.
const EDGE: f64 = 1.9;
/// Ground forces while the bucket digs, mean and spread: the vertical one, as a share of the force that lifts the bucket off, and
/// the horizontal one, which pushes the bucket away from the machine.
const CARRIED: [f64; 2] = [0.35, 0.3];
const PUSHED: [f64; 2] = [0.5, 0.3];
/// Correlation time of the resistance of the ground [s].
const LASTS: f64 = 0.4;
/// Noise streams: of the sensors, of the ground.
const STREAMS: [u64; 3] = [200, 201, 202];

/// Boom and arm cylinders of the 5.5 t machine: bores of 115 and 95 mm, rods of 65 and 55 mm.
const BOOM: Cylinder = Cylinder {
    count: 1.0,
    head_area: 0.010_39,
    rod_area: 0.007_07,
    base_distance: 0.62,
    rod_distance: 1.35,
    angle: 1.3,
    friction: 0.01,
};
const ARM: Cylinder = Cylinder {
    count: 1.0,
    head_area: 0.007_09,
    rod_area: 0.004_71,
    base_distance: 1.35,
    rod_distance: 0.40,
    angle: -0.1,
    friction: 0.01,
};

/// The cylinders of boom and arm of a machine.
#[must_use]
pub fn cylinders(geometry: &Geometry) -> [Cylinder; 2] {
    let small = Geometry::with(super::geometry::Attachment::bucket());
    let long = geometry.boom_length / small.boom_length;
    let mass = |g: &Geometry| g.boom.mass + g.arm.mass + g.attachment.link.mass;
    let heavy = mass(geometry) / mass(&small);
    [BOOM, ARM].map(|cylinder| cylinder.scaled(long, heavy))
}

/// Motion and load of boom, arm and bucket at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    /// Joint angles [rad], their rates [rad/s] and accelerations [rad/s^2].
    pub angles: Posture,
    pub rates: Posture,
    pub accelerations: Posture,
    /// Swing velocity [rad/s].
    pub spin: f64,
    /// Pitch (nose up) and roll of the upper body [rad].
    pub inclination: [f64; 2],
    /// Mass in the bucket [kg].
    pub payload: f64,
    /// Share of the bucket in the ground, 0 to 1.
    pub contact: f64,
}

/// A point of a link: position from the boom foot [m] and acceleration [m/s^2].
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    x: f64,
    z: f64,
    ax: f64,
    az: f64,
}

/// A link's direction: angle to the horizontal, its rate and acceleration.
#[derive(Clone, Copy, Debug)]
struct Turn {
    sin: f64,
    cos: f64,
    rate: f64,
    acceleration: f64,
}

impl Turn {
    /// The point `distance` further along the link.
    fn along(&self, from: Point, distance: f64) -> Point {
        let (square, bend) = (self.rate * self.rate, self.acceleration);
        Point {
            x: from.x + distance * self.cos,
            z: from.z + distance * self.sin,
            ax: from.ax - distance * (bend * self.sin + square * self.cos),
            az: from.az + distance * (bend * self.cos - square * self.sin),
        }
    }
}

/// Moments about boom foot and arm pin [N m], without the ground; and the position of the bucket's edge from each [m].
fn moments(g: &Geometry, pose: &Pose) -> ([f64; 2], [[f64; 2]; 2]) {
    let sum = |of: Posture, upto: usize| of[..=upto].iter().sum::<f64>();
    let turns: [Turn; 3] = std::array::from_fn(|i| {
        let (sin, cos) = sum(pose.angles, i).sin_cos();
        Turn {
            sin,
            cos,
            rate: sum(pose.rates, i),
            acceleration: sum(pose.accelerations, i),
        }
    });
    let [boom, arm, tool] = turns;
    let arm_pin = boom.along(Point::default(), g.boom_length);
    let tool_pin = arm.along(arm_pin, g.arm_length);
    let tool_link = g.attachment.link;
    let load = Link {
        mass: pose.payload,
        flat_inertia: pose.payload * g.attachment.payload_gyration.powi(2),
        upright_inertia: pose.payload * g.attachment.payload_gyration.powi(2),
        centre: g.attachment.payload_centre,
    };
    let bodies = [
        (g.boom, boom, boom.along(Point::default(), g.boom.centre)),
        (g.arm, arm, arm.along(arm_pin, g.arm.centre)),
        (tool_link, tool, tool.along(tool_pin, tool_link.centre)),
        (load, tool, tool.along(tool_pin, load.centre)),
    ];
    let [pitch, roll] = pose.inclination;
    let [down, back] = [GRAVITY * pitch.cos() * roll.cos(), GRAVITY * pitch.sin()];
    let square = pose.spin * pose.spin;
    let mut moments = [0.0; 2];
    for (i, (link, turn, at)) in bodies.into_iter().enumerate() {
        let upward = down + at.az;
        let forward = at.ax + back - square * (g.boom_pin + at.x);
        let own = link.flat_inertia * turn.acceleration
            + square * (link.flat_inertia - link.upright_inertia) * turn.sin * turn.cos;
        moments[0] += link.mass * (at.x * upward - at.z * forward) + own;
        if i > 0 {
            let [x, z] = [at.x - arm_pin.x, at.z - arm_pin.z];
            moments[1] += link.mass * (x * upward - z * forward) + own;
        }
    }
    let edge = tool.along(tool_pin, EDGE * g.attachment.payload_centre);
    let from_arm = [edge.x - arm_pin.x, edge.z - arm_pin.z];
    (moments, [[edge.x, edge.z], from_arm])
}

/// Boom and arm cylinders under load.
#[derive(Clone, Debug)]
pub(super) struct Front {
    geometry: Geometry,
    pistons: [Piston; 2],
    ground: Noise,
    /// Deviations of the ground's forces from their means, in standard deviations.
    resistance: [f64; 2],
    time: Option<f64>,
}

impl Front {
    /// The cylinders of a machine with these sensors; a seed determines the errors of seals and sensors.
    pub(super) fn new(
        geometry: Geometry,
        cylinders: [Cylinder; 2],
        gauges: Gauges,
        seed: u64,
    ) -> Self {
        let [boom, arm] = cylinders;
        let stream = |i: usize| Noise::channel(seed, STREAMS[i]);
        Self {
            geometry,
            pistons: [
                Piston::new(boom, gauges, stream(0)),
                Piston::new(arm, gauges, stream(1)),
            ],
            ground: stream(2),
            resistance: [0.0; 2],
            time: None,
        }
    }

    /// Readings of the four sensors: head and rod side of the boom, of the arm [Pa].
    pub(super) fn show(&mut self, time: f64, pose: &Pose) -> [f64; 4] {
        let elapsed = time - self.time.replace(time).unwrap_or(time);
        let (mut carried, edges) = moments(&self.geometry, pose);
        if pose.contact > 0.0 {
            let [up, away] = self.push(elapsed).map(|share| share * pose.contact);
            let weight = carried[0].max(0.0) / edges[0][0].max(0.3 * self.geometry.boom_length);
            for (moment, [x, z]) in carried.iter_mut().zip(edges) {
                *moment -= weight * (x * up - z * away);
            }
        }
        let joints = [pose.angles[0], pose.angles[1]];
        let mut shown = [0.0; 4];
        for (i, piston) in self.pistons.iter_mut().enumerate() {
            let pair = piston.show(carried[i], joints[i], elapsed);
            shown[2 * i..2 * i + 2].copy_from_slice(&pair);
        }
        shown
    }

    /// Vertical and horizontal force of the ground, in weights of the front.
    fn push(&mut self, elapsed: f64) -> [f64; 2] {
        let correlation = (-elapsed / LASTS).exp();
        let fresh = (1.0 - correlation * correlation).sqrt();
        for deviation in &mut self.resistance {
            *deviation = correlation * *deviation + fresh * self.ground.normal();
        }
        let [a, b] = self.resistance;
        [CARRIED[0] + CARRIED[1] * a, PUSHED[0] + PUSHED[1] * b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::Attachment;

    const STILL: Pose = Pose {
        angles: [0.9, -1.9, -1.2],
        rates: [0.0; 3],
        accelerations: [0.0; 3],
        spin: 0.0,
        inclination: [0.0; 2],
        payload: 300.0,
        contact: 0.0,
    };

    fn geometry() -> Geometry {
        Geometry::with(Attachment::bucket())
    }

    /// Potential energy of the front [J].
    fn potential(g: &Geometry, q: Posture, payload: f64) -> f64 {
        let s = [q[0].sin(), (q[0] + q[1]).sin(), (q[0] + q[1] + q[2]).sin()];
        let boom = g.boom_length * s[0];
        let tool = boom + g.arm_length * s[1];
        let a = &g.attachment;
        let heights = g.boom.mass * g.boom.centre * s[0]
            + g.arm.mass * (boom + g.arm.centre * s[1])
            + a.link.mass * (tool + a.link.centre * s[2])
            + payload * (tool + a.payload_centre * s[2]);
        GRAVITY * heights
    }

    #[test]
    fn at_rest_the_moments_are_the_derivatives_of_the_potential() {
        let g = geometry();
        let (calculated, _) = moments(&g, &STILL);
        for joint in 0..2 {
            let mut q = [STILL.angles; 2];
            (q[0][joint], q[1][joint]) = (q[0][joint] - 1e-5, q[1][joint] + 1e-5);
            let [below, above] = q.map(|q| potential(&g, q, STILL.payload));
            let expected = (above - below) / 2e-5;
            assert!(
                (calculated[joint] - expected).abs() < 1e-3,
                "{joint} {calculated:?} {expected}"
            );
        }
    }

    #[test]
    fn the_power_of_the_cylinders_is_the_rate_of_the_energy() {
        // Boom and arm turn, the bucket stays in line: E = V + sum m v^2/2 + I w^2/2, by differences.
        let g = geometry();
        let at = |t: f64| Pose {
            angles: [
                0.7 + 0.3 * t + 0.2 * t * t,
                -1.9 - 0.4 * t + 0.1 * t * t,
                -1.2,
            ],
            rates: [0.3 + 0.4 * t, -0.4 + 0.2 * t, 0.0],
            accelerations: [0.4, 0.2, 0.0],
            ..STILL
        };
        let places = |t: f64| {
            let p = at(t).angles;
            let (a, b, c) = (p[0], p[0] + p[1], p[0] + p[1] + p[2]);
            let arm_pin = [g.boom_length * a.cos(), g.boom_length * a.sin()];
            let tool = [
                arm_pin[0] + g.arm_length * b.cos(),
                arm_pin[1] + g.arm_length * b.sin(),
            ];
            let out = |from: [f64; 2], distance: f64, angle: f64| {
                [
                    from[0] + distance * angle.cos(),
                    from[1] + distance * angle.sin(),
                ]
            };
            [
                (g.boom.mass, out([0.0; 2], g.boom.centre, a)),
                (g.arm.mass, out(arm_pin, g.arm.centre, b)),
                (
                    g.attachment.link.mass,
                    out(tool, g.attachment.link.centre, c),
                ),
                (300.0, out(tool, g.attachment.payload_centre, c)),
            ]
        };
        let energy = |t: f64| {
            let h = 1e-4;
            let speeds: f64 = places(t - h)
                .iter()
                .zip(places(t + h))
                .map(|((m, p), (_, q))| {
                    0.5 * m * ((q[0] - p[0]).powi(2) + (q[1] - p[1]).powi(2)) / (4.0 * h * h)
                })
                .sum();
            let r = at(t).rates;
            let kp = g.attachment.payload_gyration;
            let tool = g.attachment.link.flat_inertia + 300.0 * kp * kp;
            let turning = 0.5
                * (g.boom.flat_inertia * r[0] * r[0]
                    + (g.arm.flat_inertia + tool) * (r[0] + r[1]).powi(2));
            speeds + turning + potential(&g, at(t).angles, 300.0)
        };
        let power = (energy(0.501) - energy(0.499)) / 2e-3;
        let pose = at(0.5);
        let (m, _) = moments(&g, &pose);
        let calculated = m[0] * pose.rates[0] + m[1] * pose.rates[1];
        assert!(
            (calculated / power - 1.0).abs() < 1e-3,
            "{calculated} {power}"
        );
    }

    #[test]
    fn the_ground_carries_a_part_and_the_boom_less() {
        let gauges = Gauges {
            noise: 0.0,
            zero: 0.0,
            span: 0.0,
            quantum: 0.0,
        };
        let g = geometry();
        let mean = |contact: f64| {
            let mut front = Front::new(g, cylinders(&g), gauges, 3);
            let pose = Pose { contact, ..STILL };
            (0..5000)
                .map(|k| front.show(0.01 * f64::from(k), &pose)[0])
                .sum::<f64>()
                / 5000.0
        };
        assert!(mean(1.0) < 0.9 * mean(0.0), "{} {}", mean(1.0), mean(0.0));
    }
}
