//! Checks whether a method can work with the description and the measured columns.

use super::super::estimate::{Columns, Method};
use super::super::mode::needs;
use super::super::settings::Settings;
use super::super::settings_error::SettingsError;

/// Least damping of the method `velocity` [N m s/rad]: only the decay b/J shows the inertia.
const LEAST_DAMPING: f64 = 1e-3;

/// Returns an error if a method cannot work with these settings and columns.
pub(super) fn check_method(
    settings: &Settings,
    method: Method,
    columns: Columns,
) -> Result<(), SettingsError> {
    check_columns(method, columns)?;
    if settings.nominal_damping < LEAST_DAMPING && method == Method::Velocity {
        let (key, value) = ("machine.nominal_damping", settings.nominal_damping);
        return Err(SettingsError::OutOfRange { key, value });
    }
    Ok(())
}

fn check_columns(method: Method, columns: Columns) -> Result<(), SettingsError> {
    if method.is_regression() {
        return Err(SettingsError::WrongStage {
            method: method.name(),
        });
    }
    let (torque, posture) = needs(method);
    let missing = if !(columns.velocity || columns.angle) {
        Some("swing_velocity")
    } else if torque && !columns.torque {
        Some("swing_torque")
    } else if posture && !columns.posture {
        Some("boom_angle, arm_angle, bucket_angle")
    } else {
        None
    };
    missing.map_or(Ok(()), |column| {
        Err(SettingsError::MissingColumn {
            method: method.name(),
            column,
        })
    })
}
