//! Whether a method can work with what is described and measured.

use super::super::estimate::{Columns, Method};
use super::super::mode::needs;
use super::super::settings::Settings;
use super::super::settings_error::SettingsError;

/// The velocity alone tells the inertia by its decay, b/J: without damping by nothing [N m s/rad].
const LEAST_DAMPING: f64 = 1e-3;

/// Whether a method can work with these columns, of a machine that is described so.
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
