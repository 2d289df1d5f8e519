//! First look at a row: is its time usable, when was it measured, and which of its values count? The torque's calibrated gain and
//! offset are taken out here, so that all behind it see the true torque.

use crate::excavator::estimate::Sample;
use crate::excavator::frozen::Repetition;
use crate::excavator::grid::LONG_GAP;
use crate::excavator::jump::Jump;
use crate::excavator::settings::Sensors;
use crate::time_base::{Tick, TimeBase};

/// No machine works on a steeper slope [rad].
const INCLINATION_LIMIT: f64 = 0.8;
/// Beyond this a pressure is no measurement [Pa]: five times that of mobile hydraulics (40 MPa).
const PRESSURE_LIMIT: f64 = 2e8;

/// A row that counts.
#[derive(Debug, Clone, Copy)]
pub(in crate::excavator) struct Accepted {
    /// The row, impossible values taken out.
    pub(in crate::excavator) sample: Sample,
    /// Time since the row before [s].
    pub(in crate::excavator) period: f64,
    /// The clock went back: what is remembered belongs to another time.
    pub(in crate::excavator) set_back: bool,
}

/// Refuses rows whose time does not increase and takes impossible values for missing.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Screen {
    clock: TimeBase,
    first_period: f64,
    velocity_limit: f64,
    angle_limit: f64,
    torque_gain: f64,
    torque_offset: f64,
    refused: u64,
    /// Velocity, torque, boom, arm, bucket.
    repetitions: [Repetition; 5],
    /// Head and rod pressure of the boom.
    pressures: [Repetition; 2],
    jumps: [Jump; 3],
}

impl Screen {
    pub(in crate::excavator) fn new(sensors: &Sensors) -> Self {
        Self {
            clock: TimeBase::default(),
            first_period: 1.0 / sensors.rate,
            velocity_limit: sensors.swing_velocity_limit,
            angle_limit: sensors.angle_limit,
            torque_gain: sensors.swing_torque_gain,
            torque_offset: sensors.swing_torque_offset,
            refused: 0,
            repetitions: [Repetition::default(); 5],
            pressures: [Repetition::default(); 2],
            jumps: [Jump::default(); 3],
        }
    }

    /// The cleaned row; `None` if it is refused.
    pub(in crate::excavator) fn accept(&mut self, sample: &Sample) -> Option<Accepted> {
        let last = self.clock.last();
        let period = match self.clock.tick(sample.time, LONG_GAP) {
            Tick::First | Tick::SetBack => self.first_period,
            Tick::Later(period) => period,
            Tick::Refused => {
                self.refused += 1;
                return None;
            }
        };
        let measured = Sample {
            time: self.clock.time(),
            ..*sample
        };
        Some(Accepted {
            sample: self.clean(&measured, period),
            period,
            set_back: last.is_some_and(|last| sample.time < last),
        })
    }

    /// Rows refused so far.
    pub(in crate::excavator) fn refused(&self) -> u64 {
        self.refused
    }

    /// Whether a sensor repeats one value against its own noise.
    pub(in crate::excavator) fn is_frozen(&self) -> bool {
        let mut all = self.repetitions.iter().chain(&self.pressures);
        all.any(Repetition::is_frozen)
    }

    /// Whether a joint angle has jumped further than a joint moves.
    pub(in crate::excavator) fn has_jumped(&self) -> bool {
        self.jumps.iter().any(Jump::has_jumped)
    }

    fn clean(&mut self, sample: &Sample, period: f64) -> Sample {
        // A sensor at the end of its range says only "at least this much": missing.
        let within = |value: Option<f64>, limit: f64| value.filter(|v| v.abs() < limit);
        let [velocity, torque, joints @ ..] = &mut self.repetitions;
        let mut posture = sample.posture;
        for ((joint, repetition), jump) in posture.iter_mut().zip(joints).zip(&mut self.jumps) {
            *joint = within(repetition.pass(*joint), self.angle_limit);
            *joint = jump.pass(*joint, period);
        }
        let [head, rod] = &mut self.pressures;
        let sample = Sample {
            boom_head_pressure: head.pass(sample.boom_head_pressure),
            boom_rod_pressure: rod.pass(sample.boom_rod_pressure),
            velocity: velocity.pass(sample.velocity),
            torque: torque.pass(sample.torque),
            ..*sample
        };
        Sample {
            time: sample.time,
            velocity: within(sample.velocity, self.velocity_limit),
            angle: within(sample.angle, f64::MAX),
            torque: within(sample.torque, 1e12)
                .map(|t| (t - self.torque_offset) / self.torque_gain),
            posture,
            inclination: sample.inclination.map(|q| within(q, INCLINATION_LIMIT)),
            boom_head_pressure: within(sample.boom_head_pressure, PRESSURE_LIMIT),
            boom_rod_pressure: within(sample.boom_rod_pressure, PRESSURE_LIMIT),
            arm_head_pressure: within(sample.arm_head_pressure, PRESSURE_LIMIT),
            arm_rod_pressure: within(sample.arm_rod_pressure, PRESSURE_LIMIT),
            truck: within(sample.truck, f64::MAX),
        }
    }
}
