//! Extended Kalman filter of velocity and payload (mode D): torque and posture are measured.
//!
//! ```text
//! w' = (T + d - T_f tanh(w/0.008) - (b + Jd) w) / J,   J = J_e(q) + m g(q),   Jd = J_e' + m g'
//! m' = h u - kap m + noise,   u' = -u/tu + noise,   d, b constant
//! ```
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | w | `x[0]` | swing velocity | rad/s |
//! | m | `x[1]` | payload | kg |
//! | d | `x[2]` | torque offset: true minus measured | N m |
//! | b | `x[3]` | viscous damping | N m s/rad |
//! | u | `x[4]` | drive of a changing payload | kg/s, kg/rad |
//!
//! The state is predicted by an Euler step, its derivative by the exponential: the gains were set for this pair.
//! While nothing changes the payload, u is 0 with zero variance.

pub(in crate::excavator) mod change;
pub(in crate::excavator) mod changing_payload;
pub(in crate::excavator) mod opening;

use super::consider::Consider;
use super::drive::Drive;
use super::settings::Settings;
use super::standstill::{Phase, released_variance};
use crate::consistency::gated_variance;
use crate::kalman::Innovation;
use crate::math::{exp, sqrt, tanh};
use nalgebra::{SMatrix, SVector};

type State = SVector<f64, 5>;
type Covariance = SMatrix<f64, 5, 5>;

/// Model of a changing payload during one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Change {
    /// Weight of the drive u (h).
    pub(super) weight: f64,
    /// Decay rate of the payload (kap) [1/s].
    pub(super) decay: f64,
    /// Standard deviation of u (us).
    pub(super) std: f64,
    /// Correlation time of u (tu) [s].
    pub(super) time: f64,
}

/// Constants of the filter.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Model {
    friction: f64,
    friction_width: f64,
    torque_variance: f64,
    gate: f64,
    payload_variance_rate: f64,
    payload: [f64; 2],
    inertia_min: f64,
    gain_std: f64,
    start: State,
    start_variance: State,
}

impl Model {
    /// `known`: damping and torque are calibrated.
    pub(super) fn new(settings: &Settings, known: bool) -> Self {
        let (e, p) = (&settings.estimator, &settings.prior);
        let (offset_std, damping_std) = if known {
            (p.known_torque_offset_std, 0.0)
        } else {
            (p.torque_offset_std, p.damping_std)
        };
        let torque_std = settings.sensors.swing_torque_std / e.torque_noise_divisor;
        let kilogram = settings.geometry.payload_scale();
        let stds = State::new(1e-3, p.payload_std, offset_std, damping_std, 0.0);
        Self {
            friction: settings.coulomb_friction,
            friction_width: e.friction_width,
            torque_variance: torque_std * torque_std,
            gate: e.gate,
            payload_variance_rate: e.q_m * kilogram * kilogram,
            payload: settings.payload_range(),
            inertia_min: settings.inertia_min,
            gain_std: settings.sensors.swing_torque_gain_std,
            start: State::new(0.0, p.payload, 0.0, settings.nominal_damping, 0.0),
            start_variance: stds.component_mul(&stds),
        }
    }
}

/// State and covariance.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct PayloadFilter {
    pub(super) x: State,
    pub(super) p: Covariance,
    /// Errors of the states due to the gain of the torque.
    pub(super) doubt: Consider<5>,
}

/// Result of a step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Outcome {
    /// Innovation before the gate; its variance is 0 without a measurement.
    pub(super) innovation: Innovation,
    /// Acceleration of the model over the step [rad/s^2].
    pub(super) acceleration: f64,
}

impl PayloadFilter {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            x: model.start,
            p: Covariance::from_diagonal(&model.start_variance),
            doubt: Consider::input(model.gain_std),
        }
    }

    /// Predicts over one step, and corrects with its velocity.
    pub(super) fn step(&mut self, model: &Model, drive: &Drive, change: Change) -> Outcome {
        let acceleration = self.predict(model, drive, change);
        let mut outcome = self.correct(model, drive);
        outcome.acceleration = acceleration;
        outcome
    }

    #[expect(non_snake_case, reason = "the symbols of the model")]
    fn predict(&mut self, model: &Model, drive: &Drive, change: Change) -> f64 {
        let dt = drive.period;
        let [w, m, d, b, u] = [self.x[0], self.x[1], self.x[2], self.x[3], self.x[4]];
        let inertia = drive.mean.with_payload(m).max(model.inertia_min);
        let rate = drive.rate.with_payload(m);
        let th = tanh(w / model.friction_width);
        let friction_slope = model.friction * (1.0 - th * th) / model.friction_width;
        let torque = drive.torque + d - model.friction * th;
        let f = (torque - (b + rate) * w) / inertia;

        let mut F = Covariance::identity();
        F[(0, 0)] = exp(-dt * (b + rate + friction_slope) / inertia);
        F[(0, 1)] = dt * (-drive.rate.per_payload * w - f * drive.mean.per_payload) / inertia;
        F[(0, 2)] = dt / inertia;
        F[(0, 3)] = -dt * w / inertia;
        self.x[0] += dt * f;
        if change.weight > 0.0 {
            let decay = exp(-dt / change.time);
            F[(1, 1)] = 1.0 - change.decay * dt;
            F[(1, 4)] = change.weight * dt;
            F[(4, 4)] = decay;
            self.x[1] += dt * (change.weight * u - change.decay * m);
            self.x[4] *= decay;
        }
        self.p = F * self.p * F.transpose();
        self.doubt
            .predict(&F, model.gain_std * drive.torque * dt / inertia);
        let torque_step = dt / inertia;
        let torque_variance = model.torque_variance * drive.share + drive.stale_torque;
        self.p[(0, 0)] += torque_variance * torque_step * torque_step;
        self.p[(1, 1)] += model.payload_variance_rate * dt;
        if change.weight > 0.0 {
            let remaining = F[(4, 4)] * F[(4, 4)];
            self.p[(4, 4)] += change.std * change.std * (1.0 - remaining);
        }
        f
    }

    fn correct(&mut self, model: &Model, drive: &Drive) -> Outcome {
        let variance = self.p[(0, 0)] + drive.variance;
        let Some(y) = drive.velocity else {
            self.limit(model);
            return Outcome::default();
        };
        let value = y - self.x[0];
        let gated = gated_variance(value, variance, model.gate);
        let gain = self.p.column(0) / gated;
        self.x += gain * value;
        self.p -= gain * self.p.row(0);
        self.doubt.correct(&gain, &State::ith(0, 1.0));
        self.p = (self.p + self.p.transpose()) * 0.5;
        self.limit(model);
        Outcome {
            innovation: Innovation { value, variance },
            acceleration: 0.0,
        }
    }

    /// Limits the payload to its range.
    pub(super) fn limit(&mut self, model: &Model) {
        self.x[1] = self.x[1].clamp(model.payload[0], model.payload[1]);
    }

    /// Whether the payload is at the end of its range.
    pub(super) fn at_limit(&self, model: &Model) -> bool {
        let [least, most] = model.payload;
        self.x[1] <= least || self.x[1] >= most
    }

    /// Standstill or its end: the velocity is known, the other states are retained.
    pub(super) fn rest(&mut self, model: &Model, drive: &Drive, phase: Phase) {
        self.clear(0);
        self.doubt.set(0, 0.0);
        match phase {
            Phase::Released(velocity) => {
                self.x[0] = velocity;
                self.p[(0, 0)] = released_variance(drive.variance);
            }
            _ => {
                self.x[0] = 0.0;
                self.p[(0, 0)] = 1e-6;
                self.p[(1, 1)] += 0.1 * model.payload_variance_rate * drive.period;
            }
        }
    }

    /// Resets the variance of the payload to at least the prior's, since it may have changed during a long stand.
    pub(super) fn reopen(&mut self, model: &Model) {
        let start = model.start_variance[1];
        if self.p[(1, 1)] < start {
            self.clear(1);
            self.p[(1, 1)] = start;
            self.doubt.set(1, 0.0);
        }
    }

    /// Resets the drive of the payload to 0, with this variance.
    pub(super) fn restart_drive(&mut self, variance: f64) {
        self.x[4] = 0.0;
        self.doubt.set(4, 0.0);
        self.clear(4);
        self.p[(4, 4)] = variance;
    }

    /// Payload and its variance.
    pub(super) fn payload(&self) -> (f64, f64) {
        (self.x[1], self.p[(1, 1)])
    }

    /// Whether all numbers are finite, and no variance is negative.
    pub(super) fn is_sound(&self) -> bool {
        self.x.iter().all(|v| v.is_finite())
            && self.p.iter().all(|v| v.is_finite())
            && self.p.diagonal().iter().all(|&v| v >= 0.0)
    }

    fn clear(&mut self, i: usize) {
        self.p.row_mut(i).fill(0.0);
        self.p.column_mut(i).fill(0.0);
    }
}

/// Estimate of a filter, in the form common to all variants.
pub(in crate::excavator) fn reading(
    model: &Model,
    filter: &PayloadFilter,
    drive: &Drive,
    outcome: &Outcome,
    payload_variance: f64,
    changing: bool,
) -> super::state::State {
    let g = drive.now.per_payload;
    let doubt = filter.doubt.of(1);
    let payload_std = sqrt(payload_variance.max(0.0) + doubt * doubt);
    super::state::State {
        inertia: drive.now.with_payload(filter.x[1]),
        inertia_std: g * payload_std,
        payload: Some((filter.x[1], payload_std)),
        damping: Some((filter.x[3], sqrt(filter.p[(3, 3)].max(0.0)))),
        offset: Some((filter.x[2], sqrt(filter.p[(2, 2)].max(0.0)))),
        velocity: filter.x[0],
        acceleration: outcome.acceleration,
        nis: outcome.innovation.nis(),
        unsettled: filter.at_limit(model),
        changing,
        ..super::state::State::default()
    }
}
