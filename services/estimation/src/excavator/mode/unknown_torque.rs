//! Filter of velocity and unknown total torque u = T - T_f sgn(w), for one inertia.
//!
//! ```text
//! w' = (u - (b + Jd) w) / J,   u a slow random walk, a fast one while a change is flagged
//! ```

use crate::excavator::standstill::{Phase, released_variance};
use crate::kalman::Innovation;
use crate::math::exp;

/// Standard deviation of the total torque at the start and after a standstill, on the reference machine [N m].
const TORQUE_STD: f64 = 3000.0;

/// The filter's state; p: variance of the velocity, covariance, variance of the torque.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct UnknownTorque {
    pub(in crate::excavator) velocity: f64,
    pub(in crate::excavator) torque: f64,
    pub(in crate::excavator) p: [f64; 3],
    /// Errors of velocity and torque due to the damping (consider covariance).
    pub(in crate::excavator) doubt: [f64; 2],
}

/// Inertia, its rate, damping and noises of one step.
#[derive(Debug, Clone, Copy)]
pub(in crate::excavator) struct Physics {
    /// J [kg m^2].
    pub(in crate::excavator) inertia: f64,
    /// Jd [kg m^2/s].
    pub(in crate::excavator) rate: f64,
    /// b and its standard deviation [N m s/rad].
    pub(in crate::excavator) damping: f64,
    pub(in crate::excavator) damping_std: f64,
    /// Torque noise that enters the velocity directly [N m].
    pub(in crate::excavator) torque_noise: f64,
    /// Random walk of the total torque [N m/sqrt(s)].
    pub(in crate::excavator) torque_drift: f64,
}

impl UnknownTorque {
    /// At rest; `scale`: torques of the machine over those of the reference machine.
    pub(in crate::excavator) fn start(scale: f64) -> Self {
        let torque_std = scale * TORQUE_STD;
        Self {
            velocity: 0.0,
            torque: 0.0,
            p: [1e-6, 0.0, torque_std * torque_std],
            doubt: [0.0; 2],
        }
    }

    /// Acceleration over the next step [rad/s^2].
    pub(in crate::excavator) fn acceleration(&self, physics: &Physics) -> f64 {
        let damping = physics.damping + physics.rate;
        (self.torque - damping * self.velocity) / physics.inertia
    }

    /// Predicts over a step of `dt`, and corrects with the velocity after it, if there is one; `variance`: of that velocity.
    pub(in crate::excavator) fn step(
        &mut self,
        physics: &Physics,
        dt: f64,
        velocity: Option<f64>,
        variance: f64,
    ) -> Innovation {
        let beta = dt / physics.inertia;
        let damping = physics.damping + physics.rate;
        let alpha = exp(-beta * damping);
        let [doubted, torque] = self.doubt;
        let driven = torque - physics.damping_std * self.velocity;
        self.doubt[0] = alpha * doubted + beta * driven;
        self.velocity += dt * self.acceleration(physics);
        let [p00, p01, p11] = self.p;
        let direct = physics.torque_noise * beta;
        let p00 =
            alpha * alpha * p00 + 2.0 * alpha * beta * p01 + beta * beta * p11 + direct * direct;
        let p01 = alpha * p01 + beta * p11;
        let p11 = p11 + physics.torque_drift * physics.torque_drift * dt;
        self.p = [p00, p01, p11];
        let Some(y) = velocity else {
            return Innovation::default();
        };
        let variance = p00 + variance;
        let value = y - self.velocity;
        let (k0, k1) = (p00 / variance, p01 / variance);
        self.velocity += k0 * value;
        self.torque += k1 * value;
        let predicted = self.doubt[0];
        self.doubt = [(1.0 - k0) * predicted, torque - k1 * predicted];
        self.p = [p00 - k0 * p00, p01 - k0 * p01, p11 - k1 * p01];
        Innovation { value, variance }
    }

    /// Resets the filter at standstill, or the velocity at its end; `variance`: of a single velocity.
    pub(in crate::excavator) fn rest(&mut self, variance: f64, phase: Phase, scale: f64) {
        if let Phase::Released(velocity) = phase {
            self.velocity = velocity;
            self.p[0] = released_variance(variance);
            self.p[1] = 0.0;
            self.doubt[0] = 0.0;
        } else {
            *self = Self::start(scale);
        }
    }
}
