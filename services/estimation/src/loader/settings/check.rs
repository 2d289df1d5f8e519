//! Which tunings can be used.

use super::tuning::{Inflation, ProcessNoise, Tuning};
use super::{SettingsError, not_negative, positive, require};

impl Tuning {
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        let substeps = f64::from(self.substeps);
        require(
            "estimator.substeps",
            "1 .. 1000",
            substeps,
            (1..=1000).contains(&self.substeps),
        )?;
        require(
            "estimator.alpha",
            "within 1e-4 .. 10",
            self.spread,
            (1e-4..=10.0).contains(&self.spread),
        )?;
        require("estimator.beta", "finite", self.beta, self.beta.is_finite())?;
        // alpha^2 (n + kappa) must be positive for the smallest n, 6.
        let kappa = self.kappa;
        require(
            "estimator.kappa",
            "within -5 .. 100",
            kappa,
            (-5.0..=100.0).contains(&kappa),
        )?;
        positive("estimator.v_min", self.minimum_speed)?;
        self.noise.check()?;
        self.inflation.check()?;
        not_negative("estimator.v_freeze", self.freeze_speed)?;
        require("estimator.gap", "positive", self.gap, self.gap > 0.0)?;
        self.check_rules()
    }

    fn check_rules(&self) -> Result<(), SettingsError> {
        if let Some(gates) = self.gates {
            positive("estimator.gate", gates.soft)?;
            require(
                "estimator.reject",
                "above estimator.gate",
                gates.hard,
                gates.hard > gates.soft,
            )?;
        }
        if let Some(clamps) = self.clamps {
            for (key, (low, high)) in [
                ("estimator.slip_stiffness_min", clamps.slip_stiffness),
                ("estimator.cg_height_min", clamps.cg_height),
                ("estimator.cg_ratio_min", clamps.cg_ratio),
            ] {
                require(key, "below its maximum", low, low < high)?;
            }
        }
        if let Some(digging) = self.digging {
            positive("estimator.dig_force", digging.force)?;
            not_negative("estimator.dig_hold", digging.hold)?;
            not_negative("estimator.reopen", digging.reopen)?;
            not_negative("estimator.boom_gain", digging.boom_gain)?;
        }
        if let Some(rule) = self.relearning {
            positive("tuning.relearning.known", rule.known)?;
            not_negative("estimator.relearn", rule.gain)?;
        }
        if let Some(reset) = self.reset {
            positive("estimator.reset_nis", reset.level)?;
            positive("tuning.reset.time_constant", reset.time_constant)?;
            not_negative("tuning.reset.hold_off", reset.hold_off)?;
        }
        Ok(())
    }
}

impl ProcessNoise {
    fn check(&self) -> Result<(), SettingsError> {
        not_negative("estimator.q_speed", self.speed)?;
        not_negative("estimator.q_wheel_speed", self.wheel_speed)?;
        not_negative("estimator.q_slip_stiffness", self.slip_stiffness)?;
        not_negative("estimator.q_cg_height", self.cg_height)?;
        not_negative("estimator.q_cg_ratio", self.cg_ratio)?;
        not_negative("estimator.q_spade_force", self.spade_force_x)?;
        not_negative("estimator.q_radius", self.radius)?;
        not_negative("estimator.q_slope_bias", self.slope_bias)
    }
}

impl Inflation {
    fn check(&self) -> Result<(), SettingsError> {
        not_negative("estimator.c_b", self.load_ripple)?;
        not_negative("estimator.c_rho", self.radius_ripple)?;
        not_negative("estimator.c_t", self.torque_lag)?;
        not_negative(
            "tuning.inflation.frozen_wheel_speed_std",
            self.frozen_wheel_speed_std,
        )
    }
}
