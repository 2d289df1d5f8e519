//! Size of the slope sensor's errors beside a constant bias, identified from the motion.
//!
//! ```text
//! e = (a_x - g sin(slope) - dv/dt)/g
//! ```
//! with dv/dt from the wheels, all smoothed over half a second. An inclinometer that follows the acceleration, lags or shakes shows
//! in e; its bias, which the filter estimates, does not. The size of e becomes the random walk of the bias. A sensor without such
//! errors keeps a constant bias, and its slope then determines the acceleration. The initial size is large.

use crate::math::{sin_cos, sqrt};

use crate::GRAVITY;

/// Smoothing of the signals [s].
const SMOOTH: f64 = 0.5;
/// Averaging time of the mean and the variance of the error [s].
const MEMORY: f64 = 10.0;
/// Initial standard deviation of the error [rad].
const DOUBT: f64 = 0.01;
/// Error by the slip of the wheels alone [rad].
const SLIP: f64 = 0.002;
/// Correlation time of the error [s]: the random walk reaches the size of the error in this time.
const CORRELATION: f64 = 1.0;

/// Running mean and variance of the error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SlopeError {
    started: bool,
    /// Smoothed wheel speed [m/s] and smoothed a_x - g sin(slope) [m/s^2].
    speed: f64,
    free: f64,
    mean: f64,
    variance: f64,
}

impl Default for SlopeError {
    fn default() -> Self {
        Self {
            started: false,
            speed: 0.0,
            free: 0.0,
            mean: 0.0,
            variance: DOUBT * DOUBT,
        }
    }
}

impl SlopeError {
    /// Updates with the mean rim speed of the wheels [m/s], the specific force and the slope of a row.
    pub fn see(&mut self, rim_speed: f64, acceleration: f64, slope: f64, dt: f64) {
        let free = acceleration - GRAVITY * sin_cos(slope).0;
        if !self.started {
            (self.started, self.speed, self.free) = (true, rim_speed, free);
        }
        let weight = (dt / SMOOTH).min(1.0);
        let rate = (rim_speed - self.speed) / SMOOTH;
        self.speed += weight * (rim_speed - self.speed);
        self.free += weight * (free - self.free);
        let error = (self.free - rate) / GRAVITY;
        let weight = (dt / MEMORY).min(1.0);
        let away = error - self.mean;
        self.mean += weight * away;
        self.variance += weight * (away * away - self.variance);
    }

    /// Standard deviation of the errors beside the bias [rad].
    pub fn size(&self) -> f64 {
        sqrt((self.variance - SLIP * SLIP).max(0.0))
    }

    /// Random walk of the bias over a step of `dt`, as a standard deviation [rad].
    pub fn walk(&self, dt: f64) -> f64 {
        self.size() * sqrt(dt / CORRELATION)
    }
}
