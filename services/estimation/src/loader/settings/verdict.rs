//! Floors of the reported intervals and limits of the verdict.

use super::{SettingsError, not_negative, positive};

/// What the report adds to the filter's standard deviations, and the limits of the verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Verdict {
    /// Error of the height that cannot be learnt on line [m].
    pub cg_height_floor: f64,
    /// Relative error of the ratio that remains with everything calibrated.
    pub cg_ratio_floor: f64,
    /// Least error of the load sensitivity of the rolling radius that counts, whatever is stated: tyres warm up and wear.
    pub load_sensitivity_floor: f64,
    /// Variation of the total torque that excites the ratio [N m].
    pub excited_torque: f64,
    /// Variation of the acceleration that excites the height [m/s^2].
    pub excited_acceleration: f64,
    /// Age of the last accepted speed and wheel speeds that is still fresh [s].
    pub fresh: f64,
    /// Running mean of the normalised innovation squared that is still consistent.
    pub consistent_nis: f64,
    /// Reported relative standard deviation at which the ratio has converged.
    pub converged_ratio: f64,
    /// Reported standard deviation at which the height has converged [m].
    pub converged_height: f64,
}

impl Default for Verdict {
    fn default() -> Self {
        Self {
            cg_height_floor: 0.04,
            cg_ratio_floor: 0.011,
            load_sensitivity_floor: 0.002,
            excited_torque: 300.0,
            excited_acceleration: 0.3,
            fresh: 0.25,
            consistent_nis: 2.0,
            converged_ratio: 0.05,
            converged_height: 0.08,
        }
    }
}

impl Verdict {
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        not_negative("estimator.cg_height_floor", self.cg_height_floor)?;
        not_negative("estimator.cg_ratio_floor", self.cg_ratio_floor)?;
        not_negative(
            "estimator.load_sensitivity_floor",
            self.load_sensitivity_floor,
        )?;
        not_negative("estimator.excited_torque", self.excited_torque)?;
        not_negative("estimator.excited_acceleration", self.excited_acceleration)?;
        positive("estimator.fresh", self.fresh)?;
        positive("estimator.consistent_nis", self.consistent_nis)?;
        positive("estimator.converged_ratio", self.converged_ratio)?;
        positive("estimator.converged_height", self.converged_height)
    }
}
