//! A ratio that changes while nothing was loaded or dumped.
//!
//! The empty machine's ratio does not change. What the slips tell of it does: a tyre warms up, loses air or wears, a torque drifts. Each
//! is a change of the apparent ratio, and nobody says whether it was right before or is now:
//! ```text
//! lam_m = mean of lam over the first 30 s of driving, with weights 1/(P + floor^2); then it follows lam within 900 s
//! added to the ratio's variance: (|lam - lam_m| - sqrt P)^2
//! ```

use crate::Quantity;

/// Driving, at the present variance, after which a ratio is one that may change [s].
const LEARNT: f64 = 30.0;
/// What has lasted for so long is as good as what was before [s]: a tyre warms up in a quarter of an hour.
const MEMORY: f64 = 900.0;

/// What the slips have told of the empty machine so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constancy {
    mean: f64,
    /// Driving time over variance.
    information: f64,
    /// How far the last ratio lies beside it, beyond a standard deviation of the filter.
    away: f64,
}

impl Constancy {
    /// Takes the ratio of the empty machine, as the filter knows it, after `dt` of driving; `floor` is what the model leaves of it, as a share.
    pub fn see(&mut self, ratio: Quantity, floor: f64, dt: f64) {
        let floor = floor * ratio.value;
        let variance = ratio.std * ratio.std + floor * floor;
        let told = dt / variance;
        self.information += told;
        let gain = if self.information * variance < LEARNT {
            told / self.information
        } else {
            (dt / MEMORY).min(1.0)
        };
        self.mean += gain * (ratio.value - self.mean);
        self.away = ((ratio.value - self.mean).abs() - ratio.std).max(0.0);
    }

    /// What a change leaves open, as a standard deviation of the ratio.
    pub fn std(&self) -> f64 {
        self.away
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn driven(constancy: &mut Constancy, ratio: f64, time: u32) -> f64 {
        let ratio = Quantity {
            value: ratio,
            std: 0.002,
        };
        (0..100 * time).for_each(|_| constancy.see(ratio, 0.011, 0.01));
        constancy.std()
    }

    #[test]
    fn a_ratio_that_changes_by_itself_is_as_uncertain_as_it_changed_for_a_quarter_of_an_hour() {
        let mut constancy = Constancy::default();
        assert!(driven(&mut constancy, 0.45, 60) < 1e-9);
        let at_once = driven(&mut constancy, 0.5, 1);
        assert!((at_once - 0.048).abs() < 1e-3, "{at_once}");
        let later = driven(&mut constancy, 0.5, 300);
        assert!((0.03..0.04).contains(&later), "{later}");
        assert!(driven(&mut constancy, 0.5, 3600) < 1e-3);
    }

    #[test]
    fn a_ratio_that_comes_back_was_right() {
        let mut constancy = Constancy::default();
        driven(&mut constancy, 0.45, 60);
        driven(&mut constancy, 0.5, 20);
        assert!(driven(&mut constancy, 0.45, 1) < 1e-3);
    }
}
