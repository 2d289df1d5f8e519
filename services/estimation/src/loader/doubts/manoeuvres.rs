//! Birge ratio of independent manoeuvres: each leg of driving or braking gives its own estimate of the load share.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | y | - | innovation of the difference of the rim speeds, r (w_f - w_r) |
//! | G | - | its derivative by the load share of the front axle, -v (s_f/lam' + s_r/(1 - lam')), s the slips |
//! | delta, 1/I | - | estimate of one leg, less that of the filter: sum G y/R over sum G^2/R, and its variance |
//! | z^2 | - | delta^2 over the variance that the filter claims for it, 1/I + P |
//! | B | `ratio` | Birge ratio: root of the mean z^2 of the last manoeuvres, at least 1 |
//!
//! Any error that the model leaves out makes manoeuvres disagree: accelerating with braking, uphill with downhill, slow with fast.
//! Scatter beyond the claimed variance widens the interval. A leg with a large deviation indicates a change, most often of the
//! load.
//!
//! R. T. Birge, "The calculation of errors by the method of least squares", Physical Review 40 (1932), 207.

use crate::math::sqrt;

/// Longest duration of a leg [s].
const LONGEST: f64 = 2.0;
/// Largest standard deviation of the share for which a leg counts.
const KNOWN: f64 = 0.03;
/// Number of manoeuvres in the running mean.
const MEMORY: f64 = 20.0;
/// Deviation z^2 of a leg that indicates a change.
const CHANGED: f64 = 16.0;

/// State of the present leg, and scatter of those before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Manoeuvres {
    /// Sums of G y/R and G^2/R of the present leg; then its time [s], and whether the torques drive.
    sums: [f64; 2],
    time: f64,
    driving: bool,
    /// Mean z^2.
    scatter: f64,
}

/// Contribution of one row to its leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// Innovation of the difference of the rim speeds [m/s].
    pub innovation: f64,
    /// Its variance without that of the share [m^2/s^2].
    pub variance: f64,
    /// Derivative of the difference by the load share of the front axle [m/s].
    pub by_share: f64,
    /// The torques drive.
    pub driving: bool,
}

impl Manoeuvres {
    /// Adds a row that the filter used, `dt` after the one before; `claimed` is the variance of the share in the filter. Returns
    /// true where a leg ends with a large deviation.
    pub fn take(&mut self, slip: &Slip, claimed: f64, dt: f64) -> bool {
        let ends = slip.driving != self.driving || self.time > LONGEST;
        let changed = ends && self.end(claimed);
        self.driving = slip.driving;
        self.sums[0] += slip.by_share * slip.innovation / slip.variance;
        self.sums[1] += slip.by_share * slip.by_share / slip.variance;
        self.time += dt;
        changed
    }

    fn end(&mut self, claimed: f64) -> bool {
        let [score, information] = self.sums;
        (self.sums, self.time) = ([0.0; 2], 0.0);
        if information * KNOWN * KNOWN < 1.0 {
            return false;
        }
        let away = score / information;
        let z_squared = away * away / (1.0 / information + claimed);
        self.scatter += (z_squared.min(2.0 * CHANGED) - self.scatter) / MEMORY;
        z_squared > CHANGED
    }

    /// The Birge ratio.
    pub fn ratio(&self) -> f64 {
        sqrt(self.scatter.max(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Manoeuvres of 1 s, each with an error of its own.
    fn ratio(errors: &[f64]) -> f64 {
        let mut manoeuvres = Manoeuvres::default();
        for (k, error) in errors.iter().enumerate() {
            for _ in 0..100 {
                let slip = Slip {
                    innovation: 0.03 * error,
                    variance: 1e-6,
                    by_share: 0.03,
                    driving: k % 2 == 0,
                };
                manoeuvres.take(&slip, 1e-5, 0.01);
            }
        }
        manoeuvres.ratio()
    }

    #[test]
    fn legs_that_agree_leave_the_interval_and_legs_that_do_not_widen_it() {
        // Standard deviation of the share: sqrt(1e-6/(100 9e-4)) = 0.0033 by a leg, 0.0032 in the filter.
        assert_eq!(ratio(&[0.003, -0.003].repeat(10)), 1.0);
        let wide = ratio(&[0.015, -0.015].repeat(10));
        // 0.015/0.0046 = 3.3 standard deviations each.
        assert!((2.5..3.5).contains(&wide), "{wide}");
    }
}
