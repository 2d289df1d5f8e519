//! Sample of an excavator's sensor message.

use config::Excavator as Description;
use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};
use messages::{ExcavatorSensors, ExcavatorSensors as SensorsMessage, excavator_bits as bits};

use super::method;
use crate::Error;
use crate::rows::sample_of_message;

sheet::excavator_signals!(sample_of_message);

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

/// Checks that a method can use a source with the columns of this message.
///
/// # Errors
/// The method is unknown, or a column is missing; the error names it.
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
