//! Checks of the settings.

use core::fmt;

use super::Settings;
use crate::keys::{Range, Table};

/// A setting that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettingsError {
    /// The key, as in the description file.
    pub key: &'static str,
    /// Its value.
    pub value: f64,
    /// The requirement.
    pub must_be: MustBe,
}

/// Requirement on a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MustBe {
    /// Within the range of its key.
    Within(Range),
    /// Below another setting.
    Below(&'static str),
    /// Method `full-ekf`: a build without the feature `every-method` has no other.
    FullEkf,
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}, it must be ", self.key, self.value)?;
        match self.must_be {
            MustBe::Within(Range { low, high }) => write!(f, "within {low} .. {high}"),
            MustBe::Below(other) => write!(f, "below {other}"),
            MustBe::FullEkf => f.write_str("full-ekf, the only one of this build"),
        }
    }
}

impl core::error::Error for SettingsError {}

impl Settings {
    pub(in crate::loader) fn check(&self) -> Result<(), SettingsError> {
        let tables: [&dyn Table; 6] = [
            &self.machine,
            &self.lift_arm,
            &self.lift_cylinder,
            &self.sensors,
            &self.prior,
            &self.estimator,
        ];
        let outside = tables.into_iter().find_map(|table| table.outside());
        if let Some((key, value, range)) = outside {
            return Err(SettingsError {
                key,
                value,
                must_be: MustBe::Within(range),
            });
        }
        let e = &self.estimator;
        let ordered = [
            ("estimator.gate", e.gate, "estimator.reject", e.reject),
            (
                "estimator.slip_stiffness_min",
                e.slip_stiffness_min,
                "estimator.slip_stiffness_max",
                e.slip_stiffness_max,
            ),
            (
                "estimator.cg_height_min",
                e.cg_height_min,
                "estimator.cg_height_max",
                e.cg_height_max,
            ),
            (
                "estimator.cg_ratio_min",
                e.cg_ratio_min,
                "estimator.cg_ratio_max",
                e.cg_ratio_max,
            ),
        ];
        for (key, value, other, limit) in ordered {
            if value >= limit {
                return Err(SettingsError {
                    key,
                    value,
                    must_be: MustBe::Below(other),
                });
            }
        }
        Ok(())
    }
}
