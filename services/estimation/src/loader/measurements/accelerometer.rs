//! Noise of the accelerometer at its mounting place: pitching and heaving move it, which no data sheet states.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | e | `residual` | specific force that the torques do not explain | m/s^2 |
//! | t1, t2 | `SHORT`, `LONG` | time constants of 5 Hz and 1 Hz | s |
//! | sigma | `std` | white noise with the same density between 1 and 5 Hz | m/s^2 |
//!
//! A body pitches at 2 to 3 Hz. An accelerometer half a metre off its centre of gravity shows a tenth of m/s^2 of that. It is in
//! phase with the axle loads that make the slips fluctuate. A filter that treats it as small white noise derives slips from it that
//! are ten percent off. In that band the torques determine the acceleration better, so the residual there is noise of the sensor:
//! ```text
//! e_b = e smoothed over t1, less e smoothed over t2
//! E e_b^2 = sigma^2 dt [1/(2 t1) + 1/(2 t2) - 2/(t1 + t2)]
//! ```
//! The stated noise is the lower bound. The initial noise is large, and counts like two seconds of driving.

use crate::math::sqrt;

/// Time constants of 5 Hz and of 1 Hz [s].
const SHORT: f64 = 0.032;
const LONG: f64 = 0.16;
/// Integral of h^2 over the kernel h of the band [1/s].
const BAND: f64 = 0.5 / SHORT + 0.5 / LONG - 2.0 / (SHORT + LONG);
/// Averaging time [s].
const MEMORY: f64 = 20.0;
/// Initial noise [m/s^2], and the time that it counts for [s].
const EXPECTED: f64 = 0.15;
const EXPECTED_TIME: f64 = 2.0;
/// Limit of a residual, beyond which a force acts [m/s^2].
const MOST: f64 = 1.0;
/// Ratio of found to stated noise up to which the stated one is used: chance and the noise of the torques explain the rest.
const SAME: f64 = 2.0;

/// Band-pass of the residuals and its variance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Shaking {
    short: f64,
    long: f64,
    /// Mean sigma^2, and the time that it counts for.
    square: f64,
    time: f64,
}

impl Default for Shaking {
    fn default() -> Self {
        Self {
            short: 0.0,
            long: 0.0,
            square: EXPECTED * EXPECTED,
            time: EXPECTED_TIME,
        }
    }
}

impl Shaking {
    /// Updates with the unexplained specific force of a row [m/s^2]; `counts` where torques and nothing else move the machine.
    pub fn see(&mut self, residual: f64, counts: bool, dt: f64) {
        let residual = residual.clamp(-MOST, MOST);
        self.short += (dt / SHORT).min(1.0) * (residual - self.short);
        self.long += (dt / LONG).min(1.0) * (residual - self.long);
        if counts {
            let band = self.short - self.long;
            self.time = (self.time + dt).min(MEMORY);
            let weight = (dt / self.time).min(1.0);
            self.square += weight * (band * band / (BAND * dt) - self.square);
        }
    }

    /// Standard deviation of the specific force, with `described` the stated one [m/s^2].
    pub fn std(&self, described: f64) -> f64 {
        let found = sqrt(self.square.max(0.0));
        if found > SAME * described {
            found
        } else {
            described
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard deviation after a minute of residuals at 100 Hz.
    fn found(residual: impl Fn(u32) -> f64) -> f64 {
        let mut shaking = Shaking::default();
        for k in 0..6000 {
            shaking.see(residual(k), true, 0.01);
        }
        shaking.std(0.05)
    }

    #[test]
    fn a_pitching_sensor_is_noisier_than_described_and_a_steady_one_is_not() {
        let pitching = found(|k| 0.12 * f64::sin(core::f64::consts::TAU * 0.025 * f64::from(k)));
        assert!((0.2..0.6).contains(&pitching), "{pitching}");
        // White: +-0.05 by a shift register.
        let white = found(|k| {
            if k.wrapping_mul(2_654_435_761) >> 31 == 0 {
                0.05
            } else {
                -0.05
            }
        });
        assert_eq!(white, 0.05);
        // A constant error of the slope is no pitching.
        assert_eq!(found(|_| 0.3), 0.05);
    }
}
