//! Adaptive noise of torque and velocity: factors of their variances that make the innovations white.
//!
//! A torque that no state explains shows as innovations that keep their sign for a while. A body that vibrates (a boom that bends
//! sideways, a gear with play) shows as innovations that alternate. Normalised sums over a tenth of a second have variance 1 where the
//! assumed noises are right. So do the normalised sum of four of them, and their scatter. The logarithm of the torque's factor follows
//! the sum, that of the velocity's factor the scatter (gradient of the likelihood).

use crate::math::{exp, ln, sqrt};

/// Ticks of a sum.
const BLOCK: u32 = 10;
/// Number of sums that are compared.
const BLOCKS: usize = 4;
/// Steps of the logarithms of the factors of torque and velocity, per sum and unit of excess, for too much and for too little. A body
/// that has vibrated will do so again with the next change of the torque, so its factor falls slowly.
const RATES: [[f64; 2]; 2] = [[0.1, 0.1], [0.3, 0.03]];
/// Upper limit of the squared sum, and of the scatter.
const LARGEST: f64 = 9.0;
/// Smallest and largest factor of the torque's variance, and of the velocity's.
const RANGES: [[f64; 2]; 2] = [[0.25, 400.0], [0.25, 36.0]];
/// Standard deviation of the velocity of a flexible upper body about that of a rigid one [rad/s]: .003 to .007 where booms bend sideways
/// at 3 Hz.
const VIBRATION: f64 = 0.01;
/// Factor of the torque's variance above which the motion does not follow the model. Even at a limit of 3, no recording of a sound
/// machine loses trust.
const UNEXPLAINED: f64 = 10.0;

/// Factors of the variances of torque and velocity.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Noise {
    logarithms: [f64; 2],
    scales: [f64; 2],
    sum: f64,
    count: u32,
    /// Last sums.
    sums: [f64; BLOCKS],
    /// Number of sums so far.
    filled: usize,
}

impl Noise {
    pub(super) fn new() -> Self {
        Self {
            logarithms: [0.0; 2],
            scales: [1.0; 2],
            sum: 0.0,
            count: 0,
            sums: [0.0; BLOCKS],
            filled: 0,
        }
    }

    /// Adds one normalised innovation.
    pub(super) fn push(&mut self, z: f64) {
        self.sum += z.clamp(-4.0, 4.0);
        self.count += 1;
        if self.count < BLOCK {
            return;
        }
        self.sums.rotate_left(1);
        self.sums[BLOCKS - 1] = self.sum / sqrt(f64::from(BLOCK));
        (self.sum, self.count) = (0.0, 0);
        self.filled += 1;
        if self.filled < BLOCKS {
            return;
        }
        let all: f64 = self.sums.iter().sum();
        let squares: f64 = self.sums.iter().map(|sum| sum * sum).sum();
        let slow = all * all / BLOCKS as f64;
        let fast = (squares - slow) / (BLOCKS - 1) as f64;
        for (i, excess) in [slow, fast].into_iter().enumerate() {
            let [least, most] = RANGES[i];
            let excess = excess.min(LARGEST) - 1.0;
            let step = RATES[i][usize::from(excess < 0.0)] * excess;
            let logarithm = self.logarithms[i] + step;
            let scale = exp(logarithm);
            self.scales[i] = scale.clamp(least, most);
            self.logarithms[i] = if self.scales[i] == scale {
                logarithm
            } else {
                ln(self.scales[i])
            };
        }
    }

    /// Restarts the sums.
    pub(super) fn rest(&mut self) {
        (self.sum, self.count, self.filled) = (0.0, 0, 0);
    }

    /// Factor of the torque's variance.
    pub(super) fn scale(&self) -> f64 {
        self.scales[0]
    }

    /// Returns whether the motion does not follow the model.
    pub(super) fn is_unexplained(&self) -> bool {
        self.scale() > UNEXPLAINED
    }

    /// Variance of the velocity by vibration, beside the noise of its sensor [(rad/s)^2].
    pub(super) fn vibration(&self) -> f64 {
        self.scales[1] * VIBRATION * VIBRATION
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sin_cos;
    use core::f64::consts::TAU;

    /// Factors of torque and vibration after 10 s of innovations, which decrease as the assumed noise grows.
    fn after(innovation: impl Fn(f64, &Noise) -> f64) -> [f64; 2] {
        let mut noise = Noise::new();
        for k in 0..1000 {
            noise.push(innovation(f64::from(k) * 0.01, &noise));
        }
        noise.scales
    }

    #[test]
    fn what_changes_its_sign_is_a_vibration_and_what_keeps_it_a_torque() {
        for frequency in [2.5, 3.1, 4.7] {
            let waver = |t: f64| 3.0 * sin_cos(TAU * frequency * t).0;
            let [torque, velocity] = after(|t, noise| waver(t) / sqrt(noise.scales[1]));
            assert!(
                velocity > 5.0 && torque < 2.0,
                "{frequency} {torque} {velocity}"
            );
        }
        let push = |t: f64| 1.5 * sin_cos(0.8 * t).0.signum();
        let [torque, velocity] = after(|t, noise| push(t) / sqrt(noise.scales[0]));
        assert!(torque > 5.0 && velocity < 1.0, "{torque} {velocity}");
    }
}
