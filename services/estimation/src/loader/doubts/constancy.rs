//! A ratio that changes while nothing was loaded or dumped.
//!
//! The empty machine's ratio does not change. What the slips tell of it does: a tyre warms up, loses air or wears, a torque drifts. Each
//! is a change of the apparent ratio, and nobody says whether it was right before or is now:
//! ```text
//! lam_m = mean of lam over the driving time of the empty machine, with weights 1/P
//! added to the ratio's variance: (|lam - lam_m| - sqrt P)^2
//! ```

use crate::math::sqrt;

/// The mean looks back over so much driving [s]: a tyre warms up in a quarter of an hour.
const MEMORY: f64 = 900.0;
/// What the slips have told of the empty machine so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constancy {
    mean: f64,
    /// Driving time over variance that the mean holds.
    information: f64,
    /// How far the last ratio lies beside it, beyond chance, one standard deviation of the filter.
    away: f64,
}

impl Constancy {
    /// Takes the ratio of the empty machine, with its variance in the filter, after `dt` of driving.
    pub fn see(&mut self, ratio: f64, variance: f64, dt: f64) {
        let told = dt / variance;
        self.information = (self.information + told).min(MEMORY / variance);
        self.mean += told / self.information * (ratio - self.mean);
        self.away = ((ratio - self.mean).abs() - sqrt(variance)).max(0.0);
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
        (0..100 * time).for_each(|_| constancy.see(ratio, 4e-6, 0.01));
        constancy.std()
    }

    #[test]
    fn a_ratio_that_changes_by_itself_is_as_uncertain_as_it_changed_and_less_with_time() {
        let mut constancy = Constancy::default();
        assert!(driven(&mut constancy, 0.45, 60) < 1e-9);
        let at_once = driven(&mut constancy, 0.5, 1);
        assert!((at_once - 0.047).abs() < 1e-3, "{at_once}");
        let after_a_minute = driven(&mut constancy, 0.5, 59);
        assert!((after_a_minute - 0.023).abs() < 1e-3, "{after_a_minute}");
    }
}
