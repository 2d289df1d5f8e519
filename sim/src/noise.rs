//! Seeded noise: xoshiro256++ (Blackman and Vigna 2019) seeded by SplitMix64, normal deviates by Box-Muller.
//!
//! The same seed gives the same numbers in every run and every version of this crate. For this reason the generator is
//! implemented here: a library may change its stream.

use std::f64::consts::TAU;

/// A stream of random numbers that depends on its seed only.
#[derive(Clone, Debug)]
pub struct Noise {
    state: [u64; 4],
    /// The second deviate of a Box-Muller pair, stored for the next call.
    spare: Option<f64>,
}

impl Noise {
    /// The stream of `seed`. Neighbouring seeds give unrelated streams.
    pub fn new(seed: u64) -> Self {
        let mut mixer = seed;
        Self {
            state: std::array::from_fn(|_| split_mix(&mut mixer)),
            spare: None,
        }
    }

    /// The stream of one channel of a run. Channels of the same seed are independent, so a fault or another noise level on one
    /// sensor leaves the samples of all others unchanged.
    pub fn channel(seed: u64, channel: u64) -> Self {
        let mut mixer = channel.wrapping_add(1);
        Self::new(seed ^ split_mix(&mut mixer))
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        let s = &mut self.state;
        let result = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let t = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= t;
        s[3] = s[3].rotate_left(45);
        result
    }

    /// A uniform deviate in [a, b).
    pub fn uniform(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    /// A standard normal deviate: mean 0, standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// True with the given probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// A uniform deviate in [0, 1) with 53 random bits.
    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

/// SplitMix64, which fills the state of xoshiro from a single word without leaving it all zero.
fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: usize = 200_000;

    fn mean(values: &[f64]) -> f64 {
        values.iter().sum::<f64>() / values.len() as f64
    }

    #[test]
    fn the_generator_is_xoshiro256_plus_plus() {
        // First outputs of the authors' C code for the state 1, 2, 3, 4.
        let mut noise = Noise {
            state: [1, 2, 3, 4],
            spare: None,
        };
        assert_eq!(
            [noise.bits(), noise.bits(), noise.bits()],
            [41_943_041, 58_720_359, 3_588_806_011_781_223]
        );
    }

    #[test]
    fn normal_deviates_have_the_moments_of_the_normal_distribution() {
        let mut noise = Noise::new(7);
        let x: Vec<f64> = (0..COUNT).map(|_| noise.normal()).collect();
        let moment = |n: i32| mean(&x.iter().map(|v| v.powi(n)).collect::<Vec<_>>());
        // Five standard errors of each sample moment: sqrt(1, 2, 15, 96) / sqrt(COUNT).
        let error = 5.0 / (COUNT as f64).sqrt();
        assert!(moment(1).abs() < error);
        assert!((moment(2) - 1.0).abs() < 1.5 * error);
        assert!(moment(3).abs() < 3.9 * error);
        assert!((moment(4) - 3.0).abs() < 9.8 * error);
    }

    #[test]
    fn successive_deviates_and_neighbouring_seeds_are_uncorrelated() {
        let (mut a, mut b) = (Noise::new(1), Noise::new(2));
        let x: Vec<f64> = (0..COUNT).map(|_| a.normal()).collect();
        let y: Vec<f64> = (0..COUNT).map(|_| b.normal()).collect();
        let error = 5.0 / (COUNT as f64).sqrt();
        assert!(mean(&x.windows(2).map(|p| p[0] * p[1]).collect::<Vec<_>>()).abs() < error);
        assert!(mean(&x.iter().zip(&y).map(|(p, q)| p * q).collect::<Vec<_>>()).abs() < error);
    }

    #[test]
    fn uniform_deviates_fill_their_interval_and_stay_inside() {
        let mut noise = Noise::new(3);
        let x: Vec<f64> = (0..COUNT).map(|_| noise.uniform(-2.0, 4.0)).collect();
        assert!(x.iter().all(|v| (-2.0..4.0).contains(v)));
        assert!((mean(&x) - 1.0).abs() < 5.0 * 3f64.sqrt() / (COUNT as f64).sqrt());
    }
}
