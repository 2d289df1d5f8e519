//! Noise of the slips by motions between sensors and wheels, from the Allan variance of what the model leaves of them.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | d | `value` | innovation of a slip speed: of both wheels less the speed, or of front less rear wheel | m/s |
//! | tau | `BLOCK` | averaging time | s |
//! | A | `square` | Allan variance, half the mean square of the difference of successive means over tau | m^2/s^2 |
//! | - | `std` | white noise of a row with the same variance of the mean over tau | m/s |
//!
//! A loader has no suspension. On its tyres it pitches and heaves at 2 to 3 Hz, and its axles move against the place of the speed
//! sensor: .01 to .02 m/s, as much as the slips of a moderate pull. No data sheet states that, and it is no white noise. The mean over
//! half a second shows what is left of it where a filter averages:
//! ```text
//! A = E (d_k+1 - d_k)^2 / 2,   sigma^2 = A tau/dt
//! ```
//! The difference of successive means excludes what is constant, such as an error of a radius. The initial variance is that of a
//! machine that pitches, and counts as one of the means.

use super::blocks::Blocks;
use crate::math::sqrt;

/// Averaging time [s].
const BLOCK: f64 = 0.25;
/// Initial deviation of the means [m/s], and their number.
const EXPECTED: f64 = 0.004;
const EXPECTED_BLOCKS: f64 = 1.0;
/// Number of means in the memory: 20 s of driving.
const MEMORY: f64 = 80.0;
/// Ratio of measured to modelled noise up to which the modelled one is used, as with the accelerometer: chance explains the rest.
const SAME: f64 = 2.0;
/// Deviations to which a difference is limited: an outlier is no noise.
const MOST: f64 = 3.0;

/// Allan variance of a slip speed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SlipNoise {
    blocks: Blocks<1>,
    /// Mean of the block before [m/s].
    last: Option<f64>,
    square: f64,
    /// Number of means that count.
    count: f64,
}

impl Default for SlipNoise {
    fn default() -> Self {
        Self {
            blocks: Blocks::default(),
            last: None,
            square: EXPECTED * EXPECTED,
            count: EXPECTED_BLOCKS,
        }
    }
}

impl SlipNoise {
    /// Ends the present block: the rows are no longer comparable.
    pub fn interrupt(&mut self) {
        (self.blocks, self.last) = (Blocks::default(), None);
    }

    /// Updates with a row.
    pub fn see(&mut self, value: f64, dt: f64) {
        let Some([mean]) = self.blocks.add([value], dt, BLOCK) else {
            return;
        };
        if let Some(last) = self.last.replace(mean) {
            let half = 0.5 * (mean - last) * (mean - last);
            self.count = (self.count + 1.0).min(MEMORY);
            let most = MOST * MOST * self.square;
            self.square += (half.min(most) - self.square) / self.count;
        }
    }

    /// Standard deviation of a mean [m/s].
    pub fn of_a_mean(&self) -> f64 {
        sqrt(self.square)
    }

    /// Noise of a measurement that moves by `per` with the slip speed: the measured one if it exceeds twice the modelled one.
    pub fn or(&self, modelled: f64, per: f64, dt: f64) -> f64 {
        let found = per * self.std(dt);
        if found > SAME * modelled {
            found
        } else {
            modelled
        }
    }

    /// Standard deviation of a row, as white noise [m/s].
    fn std(&self, dt: f64) -> f64 {
        sqrt(self.square * (BLOCK / dt).max(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// Deviation of a row after a minute of these values at 100 Hz.
    fn found(value: impl Fn(u32) -> f64) -> f64 {
        let mut noise = SlipNoise::default();
        (0..6000).for_each(|k| noise.see(value(k), 0.01));
        noise.std(0.01)
    }

    /// +-.01 m/s, of a hashed sign.
    fn white(k: u32) -> f64 {
        let mixed = (k ^ (k >> 7)).wrapping_mul(2_654_435_761);
        let sign = (mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519) >> 31;
        if sign == 0 { 0.01 } else { -0.01 }
    }

    #[test]
    fn white_noise_has_its_own_deviation_and_one_that_lasts_counts_more() {
        let alone = found(white);
        assert!((alone / 0.01 - 1.0).abs() < 0.3, "{alone}");
        let lasting = found(|k| white(k / 10));
        assert!((2.0..4.5).contains(&(lasting / alone)), "{lasting}");
    }

    #[test]
    fn a_constant_is_no_noise_and_a_wave_counts_by_what_its_mean_leaves() {
        let forgotten = found(|_| 0.05);
        assert!(forgotten < 0.002, "{forgotten}");
        let wave = |hertz: f64| move |k: u32| 0.01 * f64::sin(TAU * hertz * 0.01 * f64::from(k));
        // Whole waves in a block have no mean; half a wave has one.
        assert!(found(wave(4.0)) < 0.002);
        assert!(found(wave(2.0)) > 0.02);
    }

    #[test]
    fn a_pitching_machine_is_assumed_at_the_start_and_an_interrupted_block_does_not_count() {
        let mut noise = SlipNoise::default();
        let before = noise.std(0.01);
        assert!((0.01..0.03).contains(&before), "{before}");
        for k in 0..6000 {
            noise.see(white(k), 0.01);
            if k % 20 == 0 {
                noise.interrupt();
            }
        }
        assert_eq!(noise.std(0.01), before);
    }
}
