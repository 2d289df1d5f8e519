//! The lift arm: position of bucket and load, and readings of its cylinders' pressure sensors.
//!
//! ```text
//! M = m_a (x_a g' - z_a a') + (m_b + m_p) (x_b g' - z_b a') + M_ground            about the arm's pivot
//! g' = g cos(slope + pitch) + z'' + x_i's own rise,  a' = dv/dt + g sin(slope + pitch) + x_i's own surge
//! ```
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | th, beta | [`Stance`] | angle of the arm, of the bucket (pin to load), to the body's horizontal | rad |
//! | x, z | | centre of mass from the pivot, forward and up, of arm a, of bucket and load b | m |

use super::payload::Payload;
use super::plant::{GRAVITY, Machine};
use crate::cylinder::{Cylinder, Gauges, Piston};
use crate::noise::Noise;

/// Noise of lift and tilt angle, and the standard deviation of their zeros [rad].
const ANGLE_NOISE: f64 = 0.001;
const ANGLE_ZERO: f64 = 0.009;
/// Share of the moment that the ground carries while the bucket digs: mean and spread; correlation time below [s].
const CARRIED: [f64; 2] = [0.4, 0.35];
const LASTS: f64 = 0.4;
/// Spread of the seals' friction about the described one.
const SEALS: f64 = 0.35;
/// Time between the stances for the difference quotient of accelerations [s].
const NEAR: f64 = 2e-3;
/// Streams of [`Noise::channel`]: pressures, angles, ground, seals.
const STREAMS: [u64; 4] = [20, 21, 22, 23];

/// Angles of arm and bucket at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// Arm to the horizontal, up positive (th) \[rad\].
    pub lift: f64,
    /// Bucket, pin to load, to the horizontal, up positive (beta) \[rad\].
    pub bucket: f64,
}

/// A lift arm with its bucket and its cylinders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftArm {
    /// Pivot to the bucket's pin \[m\].
    pub length: f64,
    /// Pivot ahead of the front axle \[m\].
    pub pivot_x: f64,
    /// Pivot above the ground \[m\].
    pub pivot_z: f64,
    /// Mass of the arm \[kg\].
    pub mass: f64,
    /// Pivot to its centre of mass \[m\].
    pub mass_distance: f64,
    /// Mass of the bucket \[kg\].
    pub bucket_mass: f64,
    /// Bucket's pin to the centre of bucket and load \[m\].
    pub payload_distance: f64,
    /// The lift cylinders.
    pub cylinder: Cylinder,
    /// The stance for which the machine's centre of gravity is stated.
    pub reference: Stance,
}

impl LiftArm {
    /// The arm of the 4.7 t machine; its cylinders have bores of 80 mm and rods of 45 mm.
    const SMALL: Self = Self {
        length: 2.0,
        pivot_x: -0.35,
        pivot_z: 1.75,
        mass: 330.0,
        mass_distance: 1.05,
        bucket_mass: 380.0,
        payload_distance: 0.5,
        cylinder: Cylinder {
            count: 2.0,
            head_area: 0.005_03,
            rod_area: 0.003_44,
            base_distance: 0.55,
            rod_distance: 1.05,
            angle: 1.75,
            friction: 0.015,
        },
        reference: Stance {
            lift: 0.0,
            bucket: 0.0,
        },
    };

    /// The arm of a machine, scaled with its wheelbase and mass.
    #[must_use]
    pub fn of(machine: &Machine) -> Self {
        let small = Self::SMALL;
        let long = machine.wheelbase / Machine::NOMINAL.wheelbase;
        let heavy = machine.mass / Machine::NOMINAL.mass;
        let mut arm = Self {
            length: long * small.length,
            pivot_x: long * small.pivot_x,
            pivot_z: long * small.pivot_z,
            mass: heavy * small.mass,
            mass_distance: long * small.mass_distance,
            bucket_mass: heavy * small.bucket_mass,
            payload_distance: long * small.payload_distance,
            cylinder: small.cylinder.scaled(long, heavy),
            ..small
        };
        arm.reference = arm.stance(&Payload::CARRIED);
        arm
    }

    /// Position of the load for a stance: ahead of the front axle, above the ground \[m\].
    #[must_use]
    pub fn place(&self, at: &Stance) -> [f64; 2] {
        let [x, z] = self.load(at);
        [self.pivot_x + x, self.pivot_z + z]
    }

    /// Position of the load from the pivot [m].
    fn load(&self, at: &Stance) -> [f64; 2] {
        let (lift, bucket) = (at.lift.sin_cos(), at.bucket.sin_cos());
        [
            self.length * lift.1 + self.payload_distance * bucket.1,
            self.length * lift.0 + self.payload_distance * bucket.0,
        ]
    }

    /// Position of the arm's centre of mass from the pivot [m].
    fn own(&self, at: &Stance) -> [f64; 2] {
        let (sin, cos) = at.lift.sin_cos();
        [self.mass_distance * cos, self.mass_distance * sin]
    }

    /// The stance that puts the load at the payload's position, with the bucket's pin below the line from pivot to load.
    #[must_use]
    pub fn stance(&self, payload: &Payload) -> Stance {
        let (x, z) = (payload.reach - self.pivot_x, payload.height - self.pivot_z);
        let away = (x * x + z * z).sqrt();
        let (l, d) = (self.length, self.payload_distance);
        let corner = |a: f64, b: f64, opposite: f64| {
            let cos = (a * a + b * b - opposite * opposite) / (2.0 * a * b);
            cos.clamp(-1.0, 1.0).acos()
        };
        let lift = z.atan2(x) - corner(l, away, d);
        Stance {
            lift,
            bucket: lift + std::f64::consts::PI - corner(l, d, away),
        }
    }

    /// The stance that puts the load at a height \[m\], with the bucket angle of the low carrying position.
    #[must_use]
    pub fn raised(&self, height: f64) -> Stance {
        let bucket = self.reference.bucket;
        let rise = height - self.pivot_z - self.payload_distance * bucket.sin();
        Stance {
            lift: (rise / self.length).clamp(-1.0, 1.0).asin(),
            bucket,
        }
    }

    /// Change of the machine's first moments by arm and bucket relative to their reference, forward and up [kg m].
    #[must_use]
    pub fn shift(&self, at: &Stance) -> [f64; 2] {
        let arm = [self.own(at), self.own(&self.reference)];
        let bucket = [self.load(at), self.load(&self.reference)];
        std::array::from_fn(|i| {
            self.mass * (arm[0][i] - arm[1][i]) + self.bucket_mass * (bucket[0][i] - bucket[1][i])
        })
    }
}

/// Motion and load of the arm at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shaken {
    /// Time [s].
    pub time: f64,
    /// Slope and pitch of the body, nose up [rad].
    pub tilt: f64,
    /// Acceleration along the body and upwards [m/s^2].
    pub surge: f64,
    pub heave: f64,
    /// Mass in the bucket [kg].
    pub payload: f64,
    /// Share of the bucket in the ground, 0 to 1.
    pub contact: f64,
    /// Horizontal force of the ground on the bucket's edge, backward positive [N].
    pub push: f64,
}

/// Readings of the arm's sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Angle of the arm to the body's horizontal \[rad\].
    pub lift_angle: f64,
    /// Angle of the bucket relative to the arm \[rad\].
    pub tilt_angle: f64,
    /// Pressure of the head side \[Pa\].
    pub head_pressure: f64,
    /// Pressure of the rod side \[Pa\].
    pub rod_pressure: f64,
}

/// The sensors of an arm in operation.
#[derive(Clone, Debug)]
pub(super) struct ArmSensors {
    arm: LiftArm,
    piston: Piston,
    angles: Noise,
    zeros: [f64; 2],
    ground: Noise,
    resistance: f64,
    time: Option<f64>,
}

impl ArmSensors {
    pub(super) fn new(arm: LiftArm, gauges: Gauges, seed: u64) -> Self {
        let [pressures, mut angles, ground, mut seals] =
            STREAMS.map(|stream| Noise::channel(seed, stream));
        let mut cylinder = arm.cylinder;
        cylinder.friction *= (1.0 + SEALS * seals.normal()).max(0.2);
        Self {
            arm,
            piston: Piston::new(cylinder, gauges, pressures),
            zeros: std::array::from_fn(|_| ANGLE_ZERO * angles.normal()),
            angles,
            ground,
            resistance: 0.0,
            time: None,
        }
    }

    /// Readings of the sensors; `stance` returns the stance at a time.
    pub(super) fn show(&mut self, by: &Shaken, stance: impl Fn(f64) -> Stance) -> Seen {
        let elapsed = by.time - self.time.replace(by.time).unwrap_or(by.time);
        let [before, now, after] = [-NEAR, 0.0, NEAR].map(|step| stance(by.time + step));
        let moment = self.moment(by, [&before, &now, &after], elapsed);
        let [head_pressure, rod_pressure] = self.piston.show(moment, now.lift, elapsed);
        let true_angles = [now.lift, now.bucket - now.lift];
        let [lift_angle, tilt_angle] = std::array::from_fn(|i| {
            true_angles[i] + self.zeros[i] + ANGLE_NOISE * self.angles.normal()
        });
        Seen {
            lift_angle,
            tilt_angle,
            head_pressure,
            rod_pressure,
        }
    }

    /// Moment of the cylinders about the pivot [N m].
    fn moment(&mut self, by: &Shaken, stances: [&Stance; 3], elapsed: f64) -> f64 {
        let arm = self.arm;
        let [down, back] = [
            GRAVITY * by.tilt.cos() + by.heave,
            GRAVITY * by.tilt.sin() + by.surge,
        ];
        let carried = |mass: f64, place: &dyn Fn(&Stance) -> [f64; 2]| {
            let [before, now, after] = stances.map(place);
            let own: [f64; 2] =
                std::array::from_fn(|i| (before[i] - 2.0 * now[i] + after[i]) / (NEAR * NEAR));
            mass * (now[0] * (down + own[1]) - now[1] * (back + own[0]))
        };
        let free = carried(arm.mass, &|s| arm.own(s))
            + carried(arm.bucket_mass + by.payload, &|s| arm.load(s));
        if by.contact <= 0.0 {
            return free;
        }
        let correlation = (-elapsed / LASTS).exp();
        self.resistance = correlation * self.resistance
            + (1.0 - correlation * correlation).sqrt() * self.ground.normal();
        let share = by.contact * (CARRIED[0] + CARRIED[1] * self.resistance);
        // The ground pushes the edge back, below the pivot.
        free * (1.0 - share) + by.contact * by.push * arm.pivot_z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stance_has_the_load_where_it_is_asked_for() {
        let arm = LiftArm::of(&Machine::NOMINAL);
        for (reach, height) in [(1.35, 0.6), (1.35, 1.5), (1.6, 2.4)] {
            let payload = Payload {
                mass: 1.0,
                height,
                reach,
            };
            let [x, z] = arm.place(&arm.stance(&payload));
            assert!(
                (x - reach).abs() < 1e-12 && (z - height).abs() < 1e-12,
                "{x} {z}"
            );
        }
        // Low, with the bucket rolled back, as in carrying.
        assert!(
            (arm.reference.lift + 0.84).abs() < 0.02 && (arm.reference.bucket - 0.75).abs() < 0.02
        );
    }

    #[test]
    fn at_rest_the_cylinders_carry_the_derivative_of_the_potential() {
        let arm = LiftArm::of(&Machine::NOMINAL);
        let mut sensors = ArmSensors::new(arm, Gauges::default(), 1);
        let by = Shaken {
            time: 0.0,
            tilt: 0.0,
            surge: 0.0,
            heave: 0.0,
            payload: 1200.0,
            contact: 0.0,
            push: 0.0,
        };
        let at = Stance {
            lift: -0.3,
            bucket: 0.6,
        };
        let reported = sensors.moment(&by, [&at; 3], 0.01);
        // The bucket turns with the arm.
        let potential = |turn: f64| {
            let s = Stance {
                lift: at.lift + turn,
                bucket: at.bucket + turn,
            };
            GRAVITY * (arm.mass * arm.own(&s)[1] + (arm.bucket_mass + 1200.0) * arm.load(&s)[1])
        };
        let expected = (potential(1e-5) - potential(-1e-5)) / 2e-5;
        assert!(
            (reported / expected - 1.0).abs() < 1e-6,
            "{reported} {expected}"
        );
    }

    #[test]
    fn raising_arm_and_bucket_raises_the_machine_and_its_reference_does_not() {
        let arm = LiftArm::of(&Machine::NOMINAL);
        assert_eq!(arm.shift(&arm.reference), [0.0, 0.0]);
        let up = Stance {
            lift: 0.4,
            ..arm.reference
        };
        let [_, z] = arm.shift(&up);
        let by_hand = (330.0 * 1.05 + 380.0 * 2.0) * (0.4f64.sin() - arm.reference.lift.sin());
        assert!((z - by_hand).abs() < 1e-9, "{z} {by_hand}");
    }
}
