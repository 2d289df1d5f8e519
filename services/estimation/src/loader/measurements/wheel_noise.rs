//! Noise of the wheel speeds: axle-load ripple, tyre relaxation, fluctuating slips.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | vm | `speed` | magnitude of the predicted speed |
//! | vs | - | max(vm, v_min) |
//! | den | - | r K 0.5 m g: torque per unit slip of one axle |
//! | Tlag | `lagged_torque` | axle torque through the relaxation length |
//!
//! The disturbances are correlated over some 10 ms and more. Faster sampling adds no information about them, so at higher rates
//! their standard deviation grows with the root of the rate.

use super::slip_fluctuation::{SlipFluctuation, Wavering};
use crate::loader::physics::wheel_dynamics::{Inputs, WheelDynamics};
use crate::loader::settings::Estimator;
use crate::math::sqrt;

/// Sampling period for which noises are stated [s].
pub const REFERENCE_STEP: f64 = 0.01;

/// Relaxation length of a tyre in the noise model [m].
const RELAXATION_LENGTH: f64 = 0.3;

/// Least rolling speed at which the tyre relaxes [m/s].
const LEAST_ROLLING_SPEED: f64 = 0.3;

/// Least standard deviation of the wheel speeds while slow or digging [rad/s].
const WEAK_WHEEL_STD: f64 = 0.3;

/// Least load sensitivity in the radius ripple [-].
const LEAST_SENSITIVITY: f64 = 0.002;

/// Correlation time of slips that fluctuate more than usual [s]: a wave of a few hertz.
const TOGETHER: f64 = 0.4;

/// Standard deviations of a row beyond which a wheel hops, and its noise grows in proportion.
const FAR: f64 = 3.0;

/// Lagged torques and fluctuation of the slips.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WheelNoise {
    /// Axle torques through the relaxation length [N m].
    lagged_torque: [f64; 2],
    slip_fluctuation: SlipFluctuation,
    /// Slip speed and variance of each wheel in the present row.
    wavering: [Wavering; 2],
}

/// Inputs of the wheel-speed noise.
#[derive(Clone, Copy)]
pub struct WheelStep<'a> {
    pub machine: &'a WheelDynamics,
    pub inputs: &'a Inputs,
    /// Standard deviations of the sensors, quantisation included [rad/s].
    pub sensor_std: [f64; 2],
    /// Slow or digging.
    pub weak: bool,
    /// The fluctuation of the slips is identified from the innovations.
    pub learns_ripple: bool,
    pub dt: f64,
}

impl WheelNoise {
    /// Returns the standard deviations of the two wheel speeds under these conditions [rad/s].
    ///
    /// `speed` and `slip_stiffness` are the predicted ones.
    pub fn std(
        &mut self,
        keys: &Estimator,
        step: &WheelStep,
        speed: f64,
        slip_stiffness: f64,
    ) -> [f64; 2] {
        let speed = speed.abs();
        let radius = step.machine.wheel_radius;
        let torque_per_slip =
            radius * slip_stiffness * 0.5 * step.machine.mass * step.machine.gravity;
        let per_torque = speed.max(step.machine.minimum_speed) / (torque_per_slip * radius);
        let sensitivity = step
            .machine
            .radius_load_sensitivity
            .abs()
            .max(LEAST_SENSITIVITY);
        let radius_ripple = keys.c_rho * sensitivity * speed / radius;
        let rate = sqrt((REFERENCE_STEP / step.dt).max(1.0));
        let settle = (step.dt * speed.max(LEAST_ROLLING_SPEED) / RELAXATION_LENGTH).min(1.0);
        let usual = keys.c_b * keys.c_b;
        let square = if step.learns_ripple {
            self.slip_fluctuation.square(usual)
        } else {
            usual
        };
        let together = (TOGETHER / step.dt.max(REFERENCE_STEP)).max(1.0);
        let weight = usual + together * (square - usual);
        core::array::from_fn(|i| {
            let torque = [step.inputs.front_torque, step.inputs.rear_torque][i];
            self.lagged_torque[i] += settle * (torque - self.lagged_torque[i]);
            let by_slip = rate * torque * per_torque;
            let lag = keys.c_t * (torque - self.lagged_torque[i]) * per_torque;
            let extra = radius_ripple * radius_ripple + lag * lag;
            let sensor = step.sensor_std[i];
            let variance = sensor * sensor + rate * rate * extra;
            self.wavering[i] = Wavering { by_slip, variance };
            let std = sqrt(variance + weight * by_slip * by_slip);
            if step.weak {
                std.max(rate * WEAK_WHEEL_STD)
            } else {
                std
            }
        })
    }

    /// Factor by which an innovation of a wheel exceeds `FAR` standard deviations of a row, at least 1. Rows that fluctuate
    /// together count less each, but one with a large deviation is a hopping wheel. `more` is the variance of the prediction and of
    /// disturbances.
    pub fn far(&self, keys: &Estimator, wheel: usize, innovation: f64, more: f64) -> f64 {
        let variance = self.row_variance(keys)[wheel] + more;
        (innovation.abs() / (FAR * sqrt(variance))).max(1.0)
    }

    /// Variance of both wheel speeds in this row alone, without the weight for rows that fluctuate together [rad^2/s^2].
    pub fn row_variance(&self, keys: &Estimator) -> [f64; 2] {
        let square = self.slip_fluctuation.square(keys.c_b * keys.c_b);
        self.wavering
            .map(|row| row.variance + square * row.by_slip * row.by_slip)
    }

    /// Share by which fluctuation beyond the usual increases the mean slip.
    pub fn wavering(&self, keys: &Estimator) -> f64 {
        let usual = keys.c_b * keys.c_b;
        self.slip_fluctuation.square(usual) - usual
    }

    /// Updates with accepted innovations of both wheels and the standard deviations of their predictions, `dt` after the last
    /// [rad/s].
    pub fn see(&mut self, keys: &Estimator, wheels: [(f64, f64); 2], dt: f64) {
        self.slip_fluctuation.forget(dt);
        for ((innovation, predicted), row) in wheels.into_iter().zip(self.wavering) {
            let row = Wavering {
                variance: row.variance + predicted * predicted,
                ..row
            };
            self.slip_fluctuation.see(innovation, &row, keys.c_b);
        }
    }
}
