//! Variance of a quantised velocity. Noise larger than the quantum dithers the velocity; then no variance is added.

use crate::quantum::Quantum;

/// Number of changes after which the least one counts as the quantum.
const ENOUGH: u32 = 20;

/// Quantum of the velocity, and the number of changes from which it was estimated.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Quantisation {
    quantum: Quantum,
    changes: u32,
}

impl Quantisation {
    /// Takes the velocity of a row [rad/s].
    pub(in crate::excavator) fn push(&mut self, velocity: Option<f64>) {
        if velocity.is_some_and(|velocity| self.quantum.see(velocity)) {
            self.changes = self.changes.saturating_add(1);
        }
    }

    /// Variance that the quantisation adds to sensor noise of standard deviation `std` [rad/s] [(rad/s)^2].
    pub(in crate::excavator) fn variance(&self, std: f64) -> f64 {
        let least = self.quantum.least().filter(|_| self.changes >= ENOUGH);
        least.filter(|q| *q > std).map_or(0.0, |q| q * q / 12.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_noticed_and_noise_is_not_taken_for_steps() {
        let (mut coarse, mut fine) = (Quantisation::default(), Quantisation::default());
        for k in 0..1000 {
            let smooth = crate::math::sin_cos(0.01 * f64::from(k)).0;
            coarse.push(Some((smooth / 0.015).round() * 0.015));
            fine.push(Some(smooth + 0.003 * f64::from(k * 7919 % 1013) / 1013.0));
        }
        assert!((coarse.variance(0.003) - 0.015 * 0.015 / 12.0).abs() < 1e-12);
        assert_eq!(coarse.variance(0.02), 0.0);
        assert_eq!(fine.variance(0.003), 0.0);
        assert_eq!(Quantisation::default().variance(0.0), 0.0);
    }
}
