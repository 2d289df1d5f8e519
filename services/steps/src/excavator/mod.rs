//! The excavator's filter stage as a step, and the translation of its messages and description.

mod estimate;
mod settings;

use config::Excavator as Description;
use estimation::excavator::{Columns, Motion, MotionFilter, Sample, Settings, SettingsError};
use messages::{ExcavatorSensors, Stamp, SwingMotion, excavator_bits as bits};
use runtime::Step;

pub use estimate::{ExcavatorError, message as estimate_message};
pub use settings::settings;

/// Kalman filter and equal filters: sensors in, swing motion out.
#[derive(Clone, Debug)]
pub struct Excavator {
    settings: Settings,
    filter: MotionFilter,
    source: SourceWatch,
}

impl Excavator {
    /// A filter that waits for its first sample, which tells whether there is a velocity or an
    /// encoder's angle.
    ///
    /// # Errors
    /// The description has a value that the filter cannot use.
    pub fn new(description: &Description) -> Result<Self, SettingsError> {
        let settings = settings(description);
        Ok(Self {
            settings,
            filter: MotionFilter::new(&settings, VELOCITY)?,
            source: SourceWatch::default(),
        })
    }
}

/// What a source without a word about its columns is taken to have.
const VELOCITY: Columns = Columns {
    velocity: true,
    angle: false,
    torque: false,
    posture: false,
};

impl Step for Excavator {
    type Input = ExcavatorSensors;
    type Output = SwingMotion;

    fn step(&mut self, input: &ExcavatorSensors) -> SwingMotion {
        // The settings have been checked; without velocity and angle the old filter goes on and
        // says that nothing is measured.
        if self.source.is_new(&input.stamp)
            && let Ok(filter) = MotionFilter::new(&self.settings, columns(input))
        {
            self.filter = filter;
        }
        message(&self.filter.step(&sample(input)), input.valid)
    }
}

/// Notices the first sample of a source, and of one that was restarted with its clock set back:
/// a state from before would refuse its rows for ever.
#[derive(Clone, Copy, Debug, Default)]
pub struct SourceWatch {
    last: Option<(u32, f64)>,
}

impl SourceWatch {
    /// Whether the estimator must begin anew with this sample.
    pub fn is_new(&mut self, stamp: &Stamp) -> bool {
        let new = self
            .last
            .is_none_or(|(epoch, time)| stamp.epoch != epoch && stamp.time <= time);
        self.last = Some((stamp.epoch, stamp.time));
        new
    }
}

/// The sample in a message; a signal without its bit is missing.
pub fn sample(m: &ExcavatorSensors) -> Sample {
    let valid = |bit: u32, value: f64| (m.valid & bit != 0).then_some(value);
    Sample {
        time: m.stamp.time,
        velocity: valid(bits::SWING_VELOCITY, m.swing_velocity),
        angle: valid(bits::SWING_ANGLE, m.swing_angle),
        torque: valid(bits::SWING_TORQUE, m.swing_torque),
        posture: [
            valid(bits::BOOM_ANGLE, m.boom_angle),
            valid(bits::ARM_ANGLE, m.arm_angle),
            valid(bits::BUCKET_ANGLE, m.bucket_angle),
        ],
    }
}

/// The columns that the source of a message has.
pub fn columns(m: &ExcavatorSensors) -> Columns {
    let posture = bits::BOOM_ANGLE | bits::ARM_ANGLE | bits::BUCKET_ANGLE;
    Columns {
        velocity: m.columns & bits::SWING_VELOCITY != 0,
        angle: m.columns & bits::SWING_ANGLE != 0,
        torque: m.columns & bits::SWING_TORQUE != 0,
        posture: m.columns & posture == posture,
    }
}

/// The message of a motion.
fn message(m: &Motion, valid: u32) -> SwingMotion {
    // A signal that the gate dropped is not valid any more.
    let signals = bits::SWING_VELOCITY | bits::SWING_ANGLE;
    let accepted = if m.measured { valid } else { valid & !signals };
    let flags = [
        (bits::MANOEUVRE, m.manoeuvre),
        (bits::STANDSTILL, m.standstill),
        (bits::REFUSED, m.refused),
    ];
    SwingMotion {
        velocity: m.velocity,
        velocity_std: m.velocity_std,
        acceleration: m.acceleration,
        acceleration_std: m.acceleration_std,
        innovation: m.innovation,
        innovation_std: m.innovation_std,
        filtered_velocity: m.filtered_velocity,
        filtered_acceleration: m.filtered_acceleration,
        filtered_torque: m.filtered_torque,
        filtered_direction: m.filtered_direction,
        filtered_one: m.filtered_one,
        convergence_delay: m.convergence_delay,
        period: m.period,
        age: m.age,
        valid: accepted,
        flags: set_bits(&flags),
        ..SwingMotion::default()
    }
}

/// The bits whose condition holds.
fn set_bits(bits: &[(u32, bool)]) -> u32 {
    bits.iter()
        .filter(|(_, set)| *set)
        .fold(0, |all, (bit, _)| all | bit)
}
