//! Errors of settings with which no estimator can work.

use crate::excavator::settings::Settings;

/// An error of the settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SettingsError {
    /// A value is not finite, or outside its range.
    OutOfRange {
        /// Key of the description.
        key: &'static str,
        /// The value.
        value: f64,
    },
    /// The stated correlations are impossible for three quantities.
    Correlations,
    /// The method needs a column that the source does not have.
    MissingColumn {
        /// The method.
        method: &'static str,
        /// The column.
        column: &'static str,
    },
    /// Another service runs the method.
    WrongStage {
        /// The method.
        method: &'static str,
    },
}

impl core::fmt::Display for SettingsError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::OutOfRange { key, value } => write!(f, "{key} = {value} is out of range"),
            Self::Correlations => f.write_str(
                "machine.links_gain_correlation, upper_gain_correlation and upper_links_correlation contradict each other: take all three of one calibration",
            ),
            Self::MissingColumn { method, column } => {
                write!(f, "the method {method} needs the column {column}")
            }
            Self::WrongStage { method } => {
                write!(f, "the method {method} does not run in this service")
            }
        }
    }
}

impl core::error::Error for SettingsError {}

impl Settings {
    /// Returns an error for values with which no estimator can work.
    pub fn check(&self) -> Result<(), SettingsError> {
        let (s, p, e) = (&self.sensors, &self.prior, &self.estimator);
        let positive = [
            ("machine.inertia_min", self.inertia_min),
            ("machine.inertia_max", self.inertia_max - self.inertia_min),
            ("sensors.rate", s.rate),
            ("sensors.swing_velocity_std", s.swing_velocity_std),
            ("sensors.swing_angle_std", s.swing_angle_std),
            ("sensors.swing_torque_std", s.swing_torque_std),
            ("sensors.swing_velocity_limit", s.swing_velocity_limit),
            ("sensors.swing_torque_gain", s.swing_torque_gain),
            ("prior.inertia", p.inertia),
            ("prior.inertia_std", p.inertia_std),
            ("prior.payload_std", p.payload_std),
            ("prior.carry_back_std", p.carry_back_std),
            ("estimator.filter_frequency", e.filter_frequency),
            ("estimator.filter_damping", e.filter_damping),
            ("estimator.q_c", e.q_c),
            ("estimator.friction_width", e.friction_width),
            ("estimator.svf_friction_width", e.svf_friction_width),
            ("estimator.svf_covariance", e.svf_covariance),
            ("estimator.torque_noise_divisor", e.torque_noise_divisor),
            ("estimator.gate", e.gate),
            ("estimator.payload_max", e.payload_max - e.payload_min),
            (
                "estimator.paper.lambda_normal",
                least(&self.paper.lambda_normal),
            ),
            (
                "estimator.paper.lambda_window",
                least(&self.paper.lambda_window),
            ),
            ("estimator.paper.covariance", least(&self.paper.covariance)),
            (
                "estimator.forgetting",
                e.forgetting.iter().copied().fold(1.0, f64::min),
            ),
        ];
        let not_negative = [
            ("machine.nominal_damping", self.nominal_damping),
            ("machine.coulomb_friction", self.coulomb_friction),
            ("sensors.swing_torque_gain_std", s.swing_torque_gain_std),
            ("prior.carry_back", p.carry_back),
            ("prior.damping_std", p.damping_std),
            ("prior.torque_offset_std", p.torque_offset_std),
            ("prior.known_torque_offset_std", p.known_torque_offset_std),
            ("prior.friction_std", p.friction_std),
            ("estimator.q_m", e.q_m),
            ("estimator.q_l", e.q_l),
        ];
        let bad = positive
            .iter()
            .find(|(_, value)| !(value.is_finite() && *value > 0.0))
            .or(not_negative
                .iter()
                .find(|(_, value)| !(value.is_finite() && *value >= 0.0)));
        match bad {
            Some(&(key, value)) => Err(SettingsError::OutOfRange { key, value }),
            None if self.contradicts() => Err(SettingsError::Correlations),
            None => Ok(()),
        }
    }
}

impl Settings {
    fn contradicts(&self) -> bool {
        let found = self.doubts.and_then(|doubts| doubts.found);
        found.is_some_and(|correlations| !correlations.are_possible())
    }
}

fn least(values: &[f64; 3]) -> f64 {
    values[0].min(values[1]).min(values[2])
}
