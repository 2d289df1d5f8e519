//! Wheel speeds in steps: the smallest change ever seen is taken for the quantum of the sensor.
//!
//! A quantised signal changes by whole quanta, so the smallest change that is not zero is the quantum q, and its error
//! has a standard deviation of q/sqrt(12). A signal with noise soon changes by next to nothing, and nothing is
//! added. A filter that is given the noise of a resolver and gets steps of 0.05 rad/s is sure of a ratio that is 6 % off.

use crate::math::sqrt;

/// Changes below this are rounding [rad/s].
const ROUNDING: f64 = 1e-9;

/// What has been seen of the front and the rear wheel speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Quantisation {
    last: [Option<f64>; 2],
    least: [Option<f64>; 2],
}

impl Quantisation {
    /// Takes both wheel speeds of a row [rad/s]; what is not finite is missing.
    pub fn see(&mut self, wheel_speeds: [f64; 2]) {
        for ((new, last), least) in wheel_speeds
            .into_iter()
            .zip(&mut self.last)
            .zip(&mut self.least)
        {
            if !new.is_finite() {
                continue;
            }
            let change = last.replace(new).map_or(0.0, |last| (new - last).abs());
            if change > ROUNDING {
                *least = Some(least.map_or(change, |least| least.min(change)));
            }
        }
    }

    /// Standard deviations of the sensors with the error of their quanta added [rad/s].
    pub fn widen(&self, std: f64) -> [f64; 2] {
        self.least
            .map(|least| least.map_or(std, |q| sqrt(std * std + q * q / 12.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_noticed_and_noise_is_not_taken_for_steps() {
        let mut quantisation = Quantisation::default();
        for k in 0..1000 {
            let smooth = 5.0 + 0.013 * f64::from(k);
            // Steps of 0.05 rad/s in front; behind, a sawtooth of 2 mrad/s for noise.
            let noise = 0.002 * f64::from(k * 7 % 11) / 11.0;
            let front = f64::from((smooth / 0.05) as i32) * 0.05;
            quantisation.see([front, smooth + noise]);
            quantisation.see([f64::NAN, f64::NAN]);
        }
        let [front, rear] = quantisation.widen(0.002);
        assert!((front - 0.05 / sqrt(12.0)).abs() < 2e-4, "{front}");
        assert!(rear < 0.005, "{rear}");
        // A wheel that has not moved says nothing.
        assert_eq!(Quantisation::default().widen(0.002), [0.002; 2]);
    }
}
