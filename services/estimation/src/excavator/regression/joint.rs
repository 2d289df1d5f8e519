//! `svf-rls` of inertia, damping, friction and offset: ordinary RLS with exponential forgetting and full
//! covariance on equally filtered signals.
//!
//! ```text
//! T_f = J a_f + b w_f + Fc s_f + offset 1_f
//! ```
//!
//! The residual of equally filtered signals is strongly correlated, and includes model errors. The covariance is
//! therefore not sigma^2 P but P M P (Newey and West 1987, with an exponential window). M sums the products of the
//! scores phi e with their own past.

use crate::Quantity;
use crate::excavator::motion::Motion;
use crate::excavator::regression::Fit;
use crate::excavator::settings::Settings;
use crate::math::{exp, ln, sqrt};
use crate::rls::Rls;
use nalgebra::{Matrix4, Vector4};

/// Memory without a stated forgetting factor [s].
const MEMORY: f64 = 20.0;
/// Correlation time of the scores, in units of 1/wn of the filters.
const CORRELATION: f64 = 60.0;
/// Least relative standard deviation, by the gain of the torque measurement.
const FLOOR: f64 = 0.02;
/// Drift of the friction, as a share of its size, within `FRICTION_TIME` [s]. The residual does not show it once the parameters have
/// absorbed it.
const FRICTION_DRIFT: f64 = 0.05;
const FRICTION_TIME: f64 = 0.5;
/// Largest time shift between torque and motion, as a share of the sampling period. A shift of tau appears as
/// damping of J tau a^2/w^2.
const SKEW: f64 = 0.25;
/// Factor by which the prior's standard deviations are widened, so that the data determine what they can.
const DIFFUSE: f64 = 3.0;

/// Joint regression of inertia, damping, friction and offset.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct JointRegression {
    rls: Rls<4>,
    prior: [f64; 4],
    /// Exponentially weighted sum of past scores.
    past: Vector4<f64>,
    meat: Matrix4<f64>,
    residual_square: f64,
    /// Sums of squared acceleration and velocity.
    squares: [f64; 2],
    weight: f64,
    period: f64,
}

impl JointRegression {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        let (e, p) = (&settings.estimator, &settings.prior);
        let on = |estimated: bool, std: f64| if estimated { std } else { 0.0 };
        let prior = [
            p.inertia_std,
            on(e.estimate_damping, p.damping_std),
            on(e.estimate_friction, p.friction_std),
            on(e.estimate_offset, p.torque_offset_std),
        ];
        let start = [
            p.inertia,
            settings.nominal_damping,
            settings.coulomb_friction,
            0.0,
        ];
        let noise = settings.sensors.swing_torque_std;
        let variance = prior.map(|std| (DIFFUSE * std / noise) * (DIFFUSE * std / noise));
        Self {
            rls: Rls::new(start, variance),
            prior,
            past: Vector4::zeros(),
            meat: Matrix4::zeros(),
            residual_square: 0.0,
            squares: [0.0; 2],
            weight: 0.0,
            period: 0.0,
        }
    }

    pub(in crate::excavator) fn step(
        &mut self,
        settings: &Settings,
        motion: &Motion,
        torque_age: f64,
        held: bool,
    ) -> Fit {
        let forgetting = forgetting(settings, motion.period);
        // The filters hold a missing torque or position; long holds carry no information.
        let fresh = motion.age <= settings.estimator.fresh_velocity
            && torque_age <= settings.estimator.fresh_others;
        if !held && fresh {
            self.learn(settings, motion, forgetting);
        }
        self.fit(settings, motion, torque_age, forgetting)
    }

    /// Applies the forgetting of a duration `missed` [s], at `period` [s] a sample.
    pub(in crate::excavator) fn forget(&mut self, settings: &Settings, missed: f64, period: f64) {
        let factor = exp(ln(forgetting(settings, period)) * missed / period.max(1e-9)).max(1e-12);
        self.rls.forget(factor);
        self.meat *= factor * factor;
        self.past *= factor;
        self.residual_square *= factor;
        self.squares = self.squares.map(|sum| factor * sum);
        self.weight *= factor;
    }

    fn learn(&mut self, settings: &Settings, motion: &Motion, forgetting: f64) {
        let regressor = [
            motion.filtered_acceleration,
            motion.filtered_velocity,
            motion.filtered_direction,
            motion.filtered_one,
        ];
        let before = self.rls.clone();
        let residual = self
            .rls
            .update(&regressor, motion.filtered_torque, forgetting);
        if !self.rls.parameters.iter().all(|x| x.is_finite()) {
            self.rls = before;
            return;
        }
        let score = Vector4::from(regressor) * residual;
        let window = CORRELATION / settings.estimator.filter_frequency;
        self.past = self.past * (exp(-motion.period / window) * forgetting) + score;
        let cross = score * self.past.transpose();
        self.meat = self.meat * (forgetting * forgetting) + cross + cross.transpose()
            - score * score.transpose();
        self.residual_square = forgetting * self.residual_square + residual * residual;
        for (sum, signal) in self.squares.iter_mut().zip(regressor) {
            *sum = forgetting * *sum + signal * signal;
        }
        self.weight = forgetting * self.weight + 1.0;
        self.period = motion.period;
    }

    fn fit(&self, s: &Settings, motion: &Motion, torque_age: f64, forgetting: f64) -> Fit {
        let quantity = |i: usize| {
            (self.prior[i] > 0.0).then(|| Quantity {
                value: self.rls.parameters[i],
                std: self.std(s.estimator.filter_frequency, i),
            })
        };
        let inertia = quantity(0).unwrap_or_default();
        let enough = 20.0 / s.estimator.filter_frequency;
        Fit {
            inertia: Quantity {
                value: inertia.value.clamp(s.inertia_min, s.inertia_max),
                std: inertia.std,
            },
            damping: quantity(1),
            torque: torque_age.is_finite().then_some(Quantity {
                value: motion.filtered_torque,
                std: s.sensors.swing_torque_std,
            }),
            friction: quantity(2),
            offset: quantity(3),
            forgetting: [forgetting; 3],
            identifiable: self.weight * self.period > enough && inertia.std < self.prior[0],
            ..Fit::default()
        }
    }

    /// Apparent damping by the time shift between torque and motion.
    fn skew(&self) -> f64 {
        let [acceleration, velocity] = self.squares;
        if velocity <= 0.0 {
            return 0.0;
        }
        SKEW * self.period * self.rls.parameters[0] * acceleration / velocity
    }

    /// Standard deviation of a parameter, limited to the prior's or `FLOOR`; `wn` is the frequency of the filters [rad/s].
    fn std(&self, wn: f64, i: usize) -> f64 {
        let prior = self.prior[i];
        if self.weight * self.period < 2.0 / wn {
            return prior;
        }
        let p = self.rls.covariance();
        let row = p.row(i);
        let sandwich = (row * self.meat * row.transpose())[(0, 0)];
        // At least that of white noise whose samples within 1/wn count as one.
        let samples = (1.0 / (wn * self.period)).max(1.0);
        let plain = self.residual_square / self.weight * p[(i, i)] * samples;
        let floor = FLOOR * self.rls.parameters[i];
        let constant = self.rls.parameters[2].abs() + self.rls.parameters[3].abs();
        let drift = FRICTION_DRIFT * constant;
        let drifting = drift * drift * p[(i, i)] * (FRICTION_TIME / self.period).max(1.0);
        let skew = if i == 1 { self.skew() } else { 0.0 };
        let variance = sandwich.max(plain) + drifting + skew * skew + floor * floor;
        sqrt(variance).min(prior.max(floor.abs()))
    }
}

fn forgetting(settings: &Settings, period: f64) -> f64 {
    let given = settings.estimator.forgetting.first().copied();
    given.unwrap_or_else(|| exp(-period / MEMORY))
}
