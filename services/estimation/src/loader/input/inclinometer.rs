//! Slope of the road, from an inclinometer that is late and follows the acceleration.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | s, b | `slope`, `bias` | its reading, and its reading on level ground at rest | rad |
//! | tau | `slope_delay` | its time constant | s |
//! | kappa | `slope_acceleration_sensitivity` | share of dv/dt that it shows as a slope of (dv/dt)/g | 1 |
//! | a_x | `acceleration` | the accelerometer's dv/dt + g sin th | m/s^2 |
//!
//! ```text
//! s + tau s' = b + th + kappa (a_x/g - th)                       (1), small th
//! q = (s - b - kappa L[a_x]/g)/(1 - kappa),  tau L' + L = a_x    (2): the slope alone, late
//! th + b = b + q + tau q'                                        (3)
//! ```
//! The fast part of s is the acceleration, which (2) removes without a derivative. The remaining slope changes over metres, so its
//! rate may be smoothed. The error of the smoothing is of second order: tau times [`SMOOTH`] times th''. A pure delay is corrected
//! to first order. Without an accelerometer in the recording only the delay is corrected.

use crate::GRAVITY;
use crate::loader::sample::{SLOPE_LIMIT, Sample};
use crate::loader::settings::Sensors;

/// Smoothing of the slope's rate [s]: less passes the noise, more leaves a part of the delay.
const SMOOTH: f64 = 0.2;

/// First-order low pass of values at uneven times; a ramp comes out late by exactly its time constant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Lag {
    value: Option<f64>,
    /// Time without a value [s].
    since: f64,
}

impl Lag {
    fn take(&mut self, value: Option<f64>, time_constant: f64, dt: f64) -> Option<f64> {
        self.since += dt;
        if let Some(new) = value {
            let since = core::mem::take(&mut self.since);
            let lagging = self.value.get_or_insert(new);
            if since > 0.0 {
                *lagging += since / (time_constant + since) * (new - *lagging);
            }
        }
        self.value
    }
}

/// State of the correction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inclinometer {
    acceleration: Lag,
    slope: Lag,
}

impl Inclinometer {
    /// Returns b + th at a plausible row `dt` after the one before; exactly the reading where the sensor has no such errors.
    pub fn road(&mut self, sensors: &Sensors, bias: f64, sample: &Sample, dt: f64) -> Option<f64> {
        let (delay, sensitivity) = (sensors.slope_delay, sensors.slope_acceleration_sensitivity);
        if delay == 0.0 && sensitivity == 0.0 {
            return sample.slope;
        }
        let felt = self.acceleration.take(sample.acceleration, delay, dt);
        let slope = sample.slope.map(|shown| match felt {
            Some(felt) => {
                bias + (shown - bias - sensitivity * felt / GRAVITY) / (1.0 - sensitivity)
            } // (2)
            None => shown,
        });
        let smooth = self.slope.take(slope, SMOOTH, dt);
        let (slope, smooth) = slope.zip(smooth)?;
        let ahead = slope + delay * (slope - smooth) / SMOOTH; // (3)
        Some(ahead.clamp(-SLOPE_LIMIT, SLOPE_LIMIT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSORS: Sensors = Sensors {
        slope_delay: 0.3,
        slope_acceleration_sensitivity: 0.4,
        ..Sensors::DEFAULT
    };
    const BIAS: f64 = 0.02;

    /// Largest errors from 2 s on, of the reading and of the corrected slope, on waves of 12 m at 3 m/s under accelerations to and
    /// fro. Rows of 10 ms, some `lost`.
    fn errors(sensors: &Sensors, lost: impl Fn(u32) -> bool) -> [f64; 2] {
        let mut inclinometer = Inclinometer::default();
        let (mut shown, mut largest) = (0.0, [0.0_f64; 2]);
        let mut dt = 0.0;
        for k in 0..1000 {
            let t = f64::from(k) * 0.01;
            let slope = 0.05 * f64::sin(1.57 * t);
            let rate = 1.5 * f64::sin(4.0 * t);
            let seen = slope + SENSORS.slope_acceleration_sensitivity * rate / GRAVITY;
            shown += 0.01 / (0.01 + SENSORS.slope_delay) * (seen - shown);
            dt += 0.01;
            if lost(k) {
                continue;
            }
            let sample = Sample {
                slope: Some(shown + BIAS),
                acceleration: Some(rate + GRAVITY * slope),
                ..Sample::default()
            };
            let road = inclinometer.road(sensors, BIAS, &sample, dt);
            dt = 0.0;
            if t > 2.0 {
                for (largest, of) in largest.iter_mut().zip([sample.slope, road]) {
                    let error = of.expect("a slope") - BIAS - slope;
                    *largest = largest.max(error.abs());
                }
            }
        }
        largest
    }

    #[test]
    fn lag_and_acceleration_are_taken_out() {
        // tau SMOOTH th'' = 0.3 * 0.2 * 0.05 * 1.57^2 = 0.0074; steps of 20 ms are coarse for the acceleration.
        for (every, within) in [(u32::MAX, 0.009), (3, 0.01)] {
            let [raw, corrected] = errors(&SENSORS, |k| k % every == 1);
            assert!(raw > 0.03 && corrected < within, "{raw} {corrected}");
        }
    }

    #[test]
    fn a_sensor_without_errors_keeps_its_bits_and_missing_stays_missing() {
        let sample = Sample {
            slope: Some(-0.0),
            acceleration: None,
            ..Sample::default()
        };
        let slope = |sensors: &Sensors, sample: &Sample| {
            Inclinometer::default().road(sensors, BIAS, sample, 0.01)
        };
        let same = slope(&Sensors::DEFAULT, &sample).map(f64::to_bits);
        assert_eq!(same, Some((-0.0_f64).to_bits()));
        assert_eq!(slope(&SENSORS, &sample), Some(0.0));
        assert_eq!(slope(&SENSORS, &Sample::default()), None);
    }
}
