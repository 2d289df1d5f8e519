//! `svf-rls` of the inertia alone: one scalar regression on equally filtered signals.

use crate::Quantity;
use crate::excavator::motion::Motion;
use crate::excavator::regression::Fit;
use crate::excavator::settings::Settings;
use crate::math::{exp, ln, sqrt};

/// Forgetting factor per 0.01 s, where none is stated.
const FORGETTING: f64 = 0.9;
/// Memory of the residual's mean square [s].
const RESIDUAL_MEMORY: f64 = 1.0;
/// Least relative standard deviation. With an inertia declared constant it is that of the torque's gain, otherwise the error by the
/// missing posture term, which is not observed here.
const FLOOR_CONSTANT: f64 = 0.02;
const FLOOR_MOVING: f64 = 0.25;

/// Scalar regression of the inertia.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct SingleRegression {
    inertia: f64,
    variance: f64,
    residual_square: f64,
    learned_for: f64,
}

impl SingleRegression {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        Self {
            inertia: settings.prior.inertia,
            variance: settings.estimator.svf_covariance,
            residual_square: 0.0,
            learned_for: 0.0,
        }
    }

    pub(in crate::excavator) fn step(
        &mut self,
        settings: &Settings,
        motion: &Motion,
        torque_age: f64,
        held: bool,
    ) -> Fit {
        let e = &settings.estimator;
        let forgetting = forgetting(settings, motion.period);
        if !held && motion.filtered_acceleration.abs() > e.svf_acceleration_min {
            self.learn(settings, motion, forgetting);
        }
        Fit {
            inertia: Quantity {
                value: self.inertia,
                std: self.std(settings, forgetting),
            },
            torque: torque_age.is_finite().then_some(Quantity {
                value: motion.filtered_torque,
                std: settings.sensors.swing_torque_std,
            }),
            forgetting: [forgetting, 0.0, 0.0],
            identifiable: e.constant_inertia && self.learned_for >= 0.2,
            ..Fit::default()
        }
    }

    /// Applies the forgetting of a duration `missed` [s], at `period` [s] a sample.
    pub(in crate::excavator) fn forget(&mut self, settings: &Settings, missed: f64, period: f64) {
        let factor = exp(ln(forgetting(settings, period)) * missed / period.max(1e-9));
        self.variance = (self.variance / factor.max(1e-12)).min(settings.estimator.svf_covariance);
        self.learned_for *= factor;
    }

    fn learn(&mut self, s: &Settings, motion: &Motion, forgetting: f64) {
        let a = motion.filtered_acceleration;
        let r = motion.filtered_torque
            - s.coulomb_friction * motion.filtered_direction
            - s.nominal_damping * motion.filtered_velocity;
        let residual = r - a * self.inertia;
        let gain = self.variance * a / (forgetting + a * a * self.variance);
        let inertia = self.inertia + gain * residual;
        if !inertia.is_finite() {
            return;
        }
        self.inertia = inertia.clamp(s.inertia_min, s.inertia_max);
        self.variance = ((self.variance - gain * a * self.variance) / forgetting)
            .min(s.estimator.svf_covariance);
        let share = (motion.period / RESIDUAL_MEMORY).min(1.0);
        self.residual_square += share * (residual * residual - self.residual_square);
        self.learned_for += motion.period;
    }

    /// Standard deviation of the inertia [kg m^2]. The memory is shorter than the correlation of the filtered residual, so its samples
    /// count as one.
    fn std(&self, settings: &Settings, forgetting: f64) -> f64 {
        let prior = settings.prior.inertia_std;
        if self.learned_for < 0.1 {
            return prior;
        }
        let floor = if settings.estimator.constant_inertia {
            FLOOR_CONSTANT
        } else {
            FLOOR_MOVING
        } * self.inertia;
        let samples = 1.0 / (1.0 - forgetting).max(1e-6);
        let learned = (self.learned_for / RESIDUAL_MEMORY).min(1.0);
        let noise = self.residual_square / learned * self.variance * samples;
        sqrt(noise + floor * floor)
    }
}

fn forgetting(settings: &Settings, period: f64) -> f64 {
    let given = settings.estimator.forgetting.first().copied();
    given.unwrap_or_else(|| exp(ln(FORGETTING) * period / 0.01))
}
