//! Drift of the apparent ratio of the empty machine, as an addition to its variance.
//!
//! The ratio of the empty machine is constant. The ratio that the slips show is not: a tyre warms up, loses air or wears, or a
//! torque sensor drifts. The data do not show whether the ratio before or after such a change is right:
//! ```text
//! lam_m = mean of lam over the first 30 s of driving, with weights 1/(P + floor^2); then it follows lam within 900 s
//! added to the ratio's variance: (|lam - lam_m| - sqrt P)^2
//! ```

use crate::Quantity;

/// Length of the initial mean, as driving time at the present variance [s].
const LEARNT: f64 = 30.0;
/// Time constant with which lam_m follows lam afterwards [s]: a tyre warms up in a quarter of an hour. A change that has lasted so
/// long is accepted.
const MEMORY: f64 = 900.0;

/// Reference value of the empty machine's apparent ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constancy {
    mean: f64,
    /// Sum of driving time over variance.
    information: f64,
    /// Distance of the last ratio from the mean, beyond one standard deviation of the filter.
    away: f64,
}

impl Constancy {
    /// Updates the mean with the filter's ratio of the empty machine, after `dt` of driving; `floor`: error of the model, as a
    /// share of the ratio.
    pub fn see(&mut self, ratio: Quantity, floor: f64, dt: f64) {
        let floor = floor * ratio.value;
        let variance = ratio.std * ratio.std + floor * floor;
        let weight = dt / variance;
        self.information += weight;
        let gain = if self.information * variance < LEARNT {
            weight / self.information
        } else {
            (dt / MEMORY).min(1.0)
        };
        self.mean += gain * (ratio.value - self.mean);
        self.away = ((ratio.value - self.mean).abs() - ratio.std).max(0.0);
    }

    /// Standard deviation of the ratio from a change.
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
