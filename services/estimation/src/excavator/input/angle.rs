//! Removes from a joint angle the noise that would appear as motion.
//!
//! The swing's equation contains the rate of the inertia, and the rate of the bucket shows its opening. Noise of an angle over the
//! period of the rows disturbs both. So the angles of a noisy sensor pass an alpha-beta filter: the steady state of a Kalman filter
//! over angle and rate (Kalata, "The tracking index", 1984). It does not lag behind a steady motion:
//! ```text
//! l = s_a T^2/s,  r = (4 + l - sqrt(8 l + l^2))/4,  alpha = 1 - r^2,  beta = 2 (2 - alpha) - 4 sqrt(1 - alpha)
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | s | noise beyond what the estimators tolerate, described or measured, whichever is larger | rad |
//! | s_a | acceleration that a joint may have from row to row | rad/s^2 |
//! | T | period | s |
//!
//! Second differences b measure the noise: E b_k b_(k-1) = -4 s^2 for noise alone, and motion only raises that product. A sensor
//! with tolerated noise passes unchanged.

use crate::math::sqrt;

/// Noise that the estimators tolerate [rad].
const BORNE: f64 = 0.0015;
/// Acceleration of a joint from row to row [rad/s^2].
const ACCELERATION: f64 = 4.0;
/// Weight of one product in the mean; about 1 s at 100 Hz.
const MEMORY: f64 = 0.01;
/// Second difference beyond which it is a jump, not noise [rad].
const JUMP: f64 = 0.3;

/// Filter of one angle.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Angle {
    /// Described noise [rad].
    stated: f64,
    last: Option<f64>,
    step: f64,
    bend: f64,
    /// Mean of the products of neighbouring second differences [rad^2].
    product: f64,
    /// Angle and rate of the filter; `None` before the first angle.
    state: Option<(f64, f64)>,
    /// Time since the last angle [s].
    gap: f64,
}

impl Angle {
    /// From the described noise [rad].
    pub(in crate::excavator) fn new(stated: f64) -> Self {
        Self {
            stated,
            ..Self::default()
        }
    }

    /// The filtered angle; missing where the measured one is missing.
    pub(in crate::excavator) fn pass(&mut self, angle: Option<f64>, period: f64) -> Option<f64> {
        self.gap += period;
        let angle = angle?;
        let gap = core::mem::take(&mut self.gap);
        self.look(angle);
        let variance = self.variance() - BORNE * BORNE;
        let known = self.state.filter(|_| variance > 0.0 && gap > 0.0);
        let (value, rate) = match known {
            None => (angle, 0.0),
            Some((before, rate)) => {
                let (alpha, beta) = gains(ACCELERATION * gap * gap / sqrt(variance));
                let expected = before + rate * gap;
                let error = angle - expected;
                (expected + alpha * error, rate + beta * error / gap)
            }
        };
        self.state = Some((value, rate));
        Some(value)
    }

    /// Variance of the angle's noise [rad^2].
    pub(in crate::excavator) fn variance(&self) -> f64 {
        (self.stated * self.stated).max(-0.25 * self.product)
    }

    fn look(&mut self, angle: f64) {
        let step = angle - self.last.replace(angle).unwrap_or(angle);
        let bend = step - core::mem::replace(&mut self.step, step);
        let before = core::mem::replace(&mut self.bend, bend);
        if bend.abs() < JUMP && before.abs() < JUMP {
            self.product += MEMORY * (bend * before - self.product);
        }
    }
}

/// Gains of the filter for a tracking index.
fn gains(index: f64) -> (f64, f64) {
    let root = 0.25 * (4.0 + index - sqrt(index * (8.0 + index)));
    let pole = root.clamp(0.0, 1.0);
    let alpha = 1.0 - pole * pole;
    (alpha, 2.0 * (2.0 - alpha) - 4.0 * pole)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(k: u32) -> f64 {
        // Uniform white noise of standard deviation 1.
        let mixed = k
            .wrapping_mul(2_654_435_761)
            .rotate_left(13)
            .wrapping_mul(2_246_822_519);
        (f64::from(mixed >> 8) / f64::from(1u32 << 24) - 0.5) * sqrt(12.0)
    }

    /// Rms errors of angle and rate of a moving joint [rad, rad/s]; `size`: noise of the sensor [rad].
    fn error(stated: f64, size: f64) -> (f64, f64) {
        let mut sensor = Angle::new(stated);
        let truth =
            |k: u32| 0.3 * f64::from(k) * 0.01 + 0.2 * crate::math::sin_cos(0.02 * f64::from(k)).0;
        let (mut angles, mut rates, mut before) = (0.0, 0.0, None);
        for k in 0..2000 {
            let angle = sensor
                .pass(Some(truth(k) + size * noise(k)), 0.01)
                .unwrap_or(0.0);
            let wrong = angle - truth(k);
            if k >= 500 {
                angles += wrong * wrong / 1500.0;
                let rate = (wrong - before.unwrap_or(wrong)) / 0.01;
                rates += rate * rate / 1500.0;
            }
            before = Some(wrong);
        }
        (sqrt(angles), sqrt(rates))
    }

    #[test]
    fn noise_is_found_and_taken_out_of_angle_and_rate() {
        let size = 0.007;
        let (angle, rate) = error(0.001, size);
        assert!(angle < 0.65 * size, "{angle}");
        assert!(rate < 0.3 * sqrt(2.0) * size / 0.01, "{rate}");
        let (stated, _) = error(0.007, size);
        assert!((stated - angle).abs() < 0.2 * angle, "{stated} {angle}");
    }

    #[test]
    fn a_quiet_sensor_passes_bit_by_bit() {
        let mut sensor = Angle::new(0.001);
        for k in 0..1000 {
            let angle = crate::math::sin_cos(0.01 * f64::from(k)).0 + 0.001 * noise(k);
            assert_eq!(sensor.pass(Some(angle), 0.01), Some(angle));
        }
        assert_eq!(sensor.pass(None, 0.01), None);
    }
}
