//! What the excavator's sensors measured, as a sample.

use config::Excavator as Description;
use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};
use messages::{ExcavatorSensors, excavator_bits as bits};

use super::method;
use crate::Error;

/// The sample in a message; a signal without its bit is missing.
#[must_use]
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
        inclination: [valid(bits::PITCH, m.pitch), valid(bits::ROLL, m.roll)],
        boom_head_pressure: valid(bits::BOOM_HEAD_PRESSURE, m.boom_head_pressure),
        boom_rod_pressure: valid(bits::BOOM_ROD_PRESSURE, m.boom_rod_pressure),
        arm_head_pressure: valid(bits::ARM_HEAD_PRESSURE, m.arm_head_pressure),
        arm_rod_pressure: valid(bits::ARM_ROD_PRESSURE, m.arm_rod_pressure),
        truck: valid(bits::TRUCK, m.truck),
    }
}

/// The columns that the source of a message has.
#[must_use]
pub fn columns(m: &ExcavatorSensors) -> Columns {
    let posture = bits::BOOM_ANGLE | bits::ARM_ANGLE | bits::BUCKET_ANGLE;
    Columns {
        velocity: m.columns & bits::SWING_VELOCITY != 0,
        angle: m.columns & bits::SWING_ANGLE != 0,
        torque: m.columns & bits::SWING_TORQUE != 0,
        posture: m.columns & posture == posture,
    }
}

/// Whether a method can work with a source that has the columns of this message.
///
/// # Errors
/// The method is unknown, or names the column that is missing.
pub fn check_columns(d: &Description, name: &str, first: &ExcavatorSensors) -> Result<(), Error> {
    let missing = |column| {
        Err(Error::MissingColumn {
            method: name.to_owned(),
            column,
        })
    };
    let columns = columns(first);
    if !(columns.velocity || columns.angle) {
        return missing("swing_velocity or swing_angle");
    }
    match method(name)? {
        Method::SvfRls if !columns.torque => missing("swing_torque"),
        m if m.is_regression() => Ok(()),
        m => SwingEstimator::new(&Settings::of(d), m, columns)
            .map(drop)
            .map_err(Error::settings),
    }
}
