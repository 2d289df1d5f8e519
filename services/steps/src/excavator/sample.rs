//! What the excavator's sensors measured, as a sample.

use config::Excavator as Description;
use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};
use messages::{ExcavatorSensors, ExcavatorSensors as SensorsMessage, excavator_bits as bits};

use super::method;
use crate::Error;
use crate::rows::sample_of_message;

mod of_message {
    use super::{Sample, SensorsMessage, sample_of_message};

    sheet::excavator_signals!(sample_of_message);
}

/// The sample in a message; a signal without its bit is missing, and a joint is within half a turn.
#[must_use]
pub fn sample(m: &SensorsMessage) -> Sample {
    let mut sample = of_message::sample(m);
    sample.posture = sample
        .posture
        .map(|angle| angle.map(sheet::excavator::joint));
    sample
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

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// A curled bucket points backwards: the difference of two inclinometers of a turn each jumps by a whole one.
    #[test]
    fn a_joint_is_where_it_is_whichever_turn_a_sensor_counts() {
        let at = |bucket_angle| {
            sample(&ExcavatorSensors {
                bucket_angle,
                valid: bits::BUCKET_ANGLE,
                ..ExcavatorSensors::default()
            })
        };
        let bucket = |angle| at(angle).posture[2].expect("measured");
        assert!((bucket(-1.4 + TAU) + 1.4).abs() < 1e-12);
        assert_eq!(bucket(-1.4), -1.4);
        assert_eq!(bucket(-80.0), -80.0, "degrees stay, to be named");
    }
}
