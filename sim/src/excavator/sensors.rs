//! The sensors: noise and faults.

use super::course::Exact;
use super::row::Row;
use crate::fault::{Fault, Injector, InvalidFault};
use crate::noise::Noise;

/// The sensors, by the names in faults; the order is that of the noise streams.
pub const CHANNELS: [&str; 10] = [
    "swing_velocity",
    "swing_angle",
    "swing_torque",
    "boom_angle",
    "arm_angle",
    "bucket_angle",
    "boom_head_pressure",
    "boom_rod_pressure",
    "arm_head_pressure",
    "arm_rod_pressure",
];
/// Number of sensors of the plant itself; the pressures have their own noise.
const OWN: usize = 6;

/// Standard deviations of the white noise per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    /// Of the swing velocity [rad/s].
    pub swing_velocity: f64,
    /// Of the swing angle, an encoder's \[rad\].
    pub swing_angle: f64,
    /// Of the swing torque [N m].
    pub swing_torque: f64,
    /// Of the joint angles \[rad\].
    pub joint_angle: f64,
}

impl Default for Sensors {
    fn default() -> Self {
        Self {
            swing_velocity: 0.005,
            swing_angle: 2e-4,
            swing_torque: 100.0,
            joint_angle: 0.0,
        }
    }
}

impl Sensors {
    /// Sensors without noise.
    pub const EXACT: Self = Self {
        swing_velocity: 0.0,
        swing_angle: 0.0,
        swing_torque: 0.0,
        joint_angle: 0.0,
    };
}

/// The sensors of a run. They allocate nothing after their construction.
#[derive(Clone, Debug)]
pub struct Instruments {
    noise: [Noise; 6],
    deviation: [f64; 6],
    injector: Injector,
}

impl Instruments {
    /// Sensors with a noise, faults and a seed.
    ///
    /// # Errors
    /// A fault names an unknown channel.
    pub fn new(noise: Sensors, faults: &[Fault], seed: u64) -> Result<Self, InvalidFault> {
        let Sensors {
            swing_velocity,
            swing_angle,
            swing_torque,
            joint_angle,
        } = noise;
        Ok(Self {
            noise: std::array::from_fn(|channel| Noise::channel(seed, channel as u64)),
            deviation: [
                swing_velocity,
                swing_angle,
                swing_torque,
                joint_angle,
                joint_angle,
                joint_angle,
            ],
            injector: Injector::new(faults, &CHANNELS, seed)?,
        })
    }

    /// The sample from the exact one and the pressure readings; `None` if it is lost as a whole.
    pub fn measure(&mut self, exact: &Exact, pressures: Option<[f64; 4]>) -> Option<Row> {
        let lost = self.injector.loses_row(exact.time);
        let mut seen = [None; 6];
        for (channel, value) in exact.values.into_iter().enumerate() {
            let noisy = value + self.deviation[channel] * self.noise[channel].normal();
            seen[channel] = self.injector.apply(channel, exact.time, Some(noisy));
        }
        let mut felt = [None; 4];
        for (i, value) in pressures.into_iter().flatten().enumerate() {
            felt[i] = self.injector.apply(OWN + i, exact.time, Some(value));
        }
        let row = Row {
            time: exact.time,
            swing_velocity: seen[0],
            swing_angle: seen[1],
            swing_torque: seen[2],
            posture: [seen[3], seen[4], seen[5]],
            inclination: [None; 2],
            pressures: felt,
            truth: exact.truth,
        };
        (!lost).then_some(row)
    }
}
