//! Mode A: velocity and nominal damping only.
//!
//! ```text
//! beta = b/J,  alpha = T_t/J:   w' = alpha - beta w
//! ```
//!
//! A changing inertia cannot be distinguished from the damping, so the interval is wide and the verdict is never
//! `identifiable`. With an inertia declared constant, the verdict is possible after about a second and a half of
//! steady torque. A filter with the states (w, ln J, T) must not be used here: it drifts by 90 %.

use crate::excavator::consider::Doubt;
use crate::excavator::delay::{DelayLine, Entry};
use crate::excavator::settings::Settings;
use crate::excavator::standstill::{Phase, released_variance};
use crate::excavator::state::State;
use crate::kalman::Innovation;
use crate::math::sqrt;
use nalgebra::{Matrix3, Vector3};

/// Variance of alpha at the start and after a standstill [(rad/s^2)^2].
const ALPHA_VARIANCE: f64 = 0.25;
/// Random walk of the torque while a change is flagged [N m/sqrt(s)].
const TORQUE_DRIFT_FLAGGED: f64 = 15_000.0;

/// Random walk of the velocity itself, by what neither torque nor damping explains [(rad/s)^2/s].
const VELOCITY_WALK: f64 = 1e-7;

/// Mode A.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct VelocityMode {
    x: Vector3<f64>,
    p: Matrix3<f64>,
    line: DelayLine,
    late: State,
    unflagged_for: f64,
    held: bool,
}

impl VelocityMode {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        let mut mode = Self {
            x: Vector3::new(0.0, settings.nominal_damping / settings.prior.inertia, 0.0),
            p: Matrix3::from_diagonal(&Vector3::new(1e-6, 0.0, ALPHA_VARIANCE)),
            line: DelayLine::new(),
            late: State::default(),
            unflagged_for: 0.0,
            held: true,
        };
        mode.p[(1, 1)] = prior_variance(settings);
        mode.read(settings, 0.0, 0.0, false);
        mode
    }

    /// Takes one tick. The reading is that of the tick 0.15 s ago.
    pub(in crate::excavator) fn step(
        &mut self,
        settings: &Settings,
        entry: Entry,
        event: bool,
    ) -> State {
        if let Some(late) = self.line.push(entry, event) {
            self.advance(settings, &late);
        }
        self.late
    }

    /// Whether the machine stood at the tick of the reading.
    pub(in crate::excavator) fn held(&self) -> bool {
        self.held
    }

    /// Unflagged motion since the last rest [s].
    pub(in crate::excavator) fn unflagged_for(&self) -> f64 {
        self.unflagged_for
    }

    fn advance(&mut self, settings: &Settings, late: &Entry) {
        self.held = late.phase == Phase::Held;
        if late.reopen {
            self.p[(1, 1)] = self.p[(1, 1)].max(prior_variance(settings));
        }
        let mut nis = 0.0;
        let mut acceleration = 0.0;
        if late.phase == Phase::Moving {
            acceleration = self.predict(settings, late);
            nis = self.correct(settings, late).nis();
            self.unflagged_for += if late.flagged { 0.0 } else { late.period };
        } else {
            self.rest(late);
            self.unflagged_for = 0.0;
        }
        self.read(settings, nis, acceleration, late.flagged);
    }

    #[expect(non_snake_case, reason = "the symbols of the model")]
    fn predict(&mut self, settings: &Settings, late: &Entry) -> f64 {
        let e = &settings.estimator;
        let (relative, drift) = if e.constant_inertia {
            (e.velocity_drift_constant, e.velocity_torque_drift_constant)
        } else {
            (e.velocity_drift, e.velocity_torque_drift)
        };
        let drift = if late.flagged {
            TORQUE_DRIFT_FLAGGED
        } else {
            drift
        };
        let dt = late.period;
        let [w, beta, alpha] = [self.x[0], self.x[1], self.x[2]];
        let c = alpha / beta;
        let f = alpha - beta * w;
        let mut F = Matrix3::identity();
        F[(0, 0)] = 1.0 - dt * beta;
        F[(0, 1)] = -dt * w;
        F[(0, 2)] = dt;
        self.x[0] += dt * f;
        self.p = F * self.p * F.transpose();
        // A drift of J changes alpha = T/J and beta = b/J together.
        let qb = relative * relative * beta * beta * dt;
        self.p[(1, 1)] += qb;
        self.p[(1, 2)] += c * qb;
        self.p[(2, 1)] += c * qb;
        self.p[(2, 2)] += c * c * qb;
        let torque = drift * beta / settings.nominal_damping;
        self.p[(2, 2)] += torque * torque * dt;
        self.p[(0, 0)] += VELOCITY_WALK * dt;
        f
    }

    fn correct(&mut self, s: &Settings, late: &Entry) -> Innovation {
        let Some(y) = late.velocity else {
            return Innovation::default();
        };
        let innovation = Innovation {
            value: y - self.x[0],
            variance: self.p[(0, 0)] + late.variance,
        };
        let gain = self.p.column(0) / innovation.variance;
        self.x += gain * innovation.value;
        self.p -= gain * self.p.row(0);
        self.p = (self.p + self.p.transpose()) * 0.5;
        self.x[1] = self.x[1].clamp(
            s.nominal_damping / s.inertia_max,
            s.nominal_damping / s.inertia_min,
        );
        innovation
    }

    fn rest(&mut self, late: &Entry) {
        self.clear(0);
        if let Phase::Released(velocity) = late.phase {
            self.x[0] = velocity;
            self.p[(0, 0)] = released_variance(late.variance);
        } else {
            self.clear(2);
            self.x[0] = 0.0;
            self.x[2] = 0.0;
            self.p[(0, 0)] = 1e-6;
            self.p[(2, 2)] = ALPHA_VARIANCE;
        }
    }

    fn clear(&mut self, i: usize) {
        self.p.row_mut(i).fill(0.0);
        self.p.column_mut(i).fill(0.0);
    }

    fn read(&mut self, s: &Settings, nis: f64, acceleration: f64, flagged: bool) {
        let [w, beta, alpha] = [self.x[0], self.x[1], self.x[2]];
        let inertia = (s.nominal_damping / beta).clamp(s.inertia_min, s.inertia_max);
        // J = b/beta has the relative error of the nominal damping; with a changing J, the drift of beta includes it.
        let doubt = if s.estimator.constant_inertia {
            Doubt::new(s).damping / s.nominal_damping
        } else {
            0.0
        };
        let own = self.p[(1, 1)].max(0.0) / (beta * beta);
        let relative = sqrt(own + doubt * doubt);
        let torque = alpha * inertia;
        let torque_std = inertia * sqrt(self.p[(2, 2)].max(0.0)) + torque.abs() * relative;
        self.late = State {
            inertia,
            inertia_std: inertia * relative,
            total_torque: Some((torque, torque_std)),
            velocity: w,
            acceleration,
            nis,
            flagged,
            unsettled: inertia <= s.inertia_min || inertia >= s.inertia_max,
            ..State::default()
        };
    }

    pub(in crate::excavator) fn is_sound(&self) -> bool {
        self.x.iter().chain(self.p.iter()).all(|v| v.is_finite())
            && self.p.diagonal().iter().all(|&v| v >= 0.0)
    }
}

/// Variance of beta by the relative uncertainty of the inertia's prior.
fn prior_variance(settings: &Settings) -> f64 {
    let p = &settings.prior;
    let std = p.inertia_std / p.inertia * settings.nominal_damping / p.inertia;
    std * std
}
