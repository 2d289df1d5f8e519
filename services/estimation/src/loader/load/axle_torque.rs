//! Probability that the measured torque of one axle has a gain error: a gear ratio, a motor's constant, a displacement.
//!
//! A gain error g of one axle looks like a shift of load between the axles. While the axles pull in a constant proportion, motion does not
//! distinguish them. The evidence is kappa, force over acceleration ([`super::inertia`]), which is off by g/2, and the difference of the
//! ratio from its prior. The gain is constant, so kappa is estimated here from all rows, not from the last ten seconds.
//!
//! ```text
//! H_0:      kappa - 1 ~ N(0, s^2 + P),                  lam - lam_0 ~ N(0, p^2),   s^2 = .02^2 + .01^2 + sigma_T^2/2
//! H_f, H_r: kappa - 1 = g/2 + .., lam - lam_0 = -+ lam (1 - lam) g + .., g ~ N(0, c^2): the true torque over the measured one, minus 1
//! ```

use super::inertia::Force;
use crate::math::{exp, norm, sqrt};
use crate::mixture::spread;

/// Prior probability that an uncalibrated torque is off beyond its stated tolerance: of each axle, one machine in thirteen.
const OFTEN: f64 = 0.077;
/// Standard deviation of g in that case.
const OFF: f64 = 0.2;
/// Standard deviations of kappa by the tolerances of mass and rolling radius; those of the torques are stated.
const MASS_TOLERANCE: f64 = 0.02;
const RADIUS_TOLERANCE: f64 = 0.01;
/// Random walk of kappa [1/sqrt(s)], of the resistance and of the accelerometer's zero [m/s^2/sqrt(s)]: kappa, a property of gears, motors
/// and the empty machine, walks 3 % in a quarter of an hour.
const WALK: [f64; 3] = [0.001, 0.01, 0.01];
/// Limit of the logarithm of the likelihood ratio, against overflow.
const MAX_LOG_RATIO: f64 = 50.0;

/// Estimate of kappa from all driving so far.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AxleTorque {
    force: Force,
}

impl Default for AxleTorque {
    fn default() -> Self {
        let mut force = Force::default();
        force.open_zero();
        Self { force }
    }
}

/// Estimated ratio lam, its prior lam_0, and the standard deviation p of their difference.
#[derive(Clone, Copy, Debug)]
pub struct RatioAway {
    pub ratio: f64,
    pub expected: f64,
    pub std: f64,
    /// Tolerance of the torque of an axle, as a share.
    pub torque_std: f64,
}

impl AxleTorque {
    /// Updates with smoothed acceleration, force over mass and direction of a row in which the torques drive, `dt` after the last.
    pub fn see(&mut self, signals: [f64; 3], dt: f64) {
        self.force.walk(&WALK, dt);
        self.force.see(signals, dt);
    }

    /// Widens kappa: the mass has changed by a load that was not reported.
    pub fn load_stepped(&mut self) {
        self.force.open_gain();
    }

    /// Probability that one axle's torque is off, and the standard deviation that this adds to the ratio.
    pub fn judge(&self, away: &RatioAway) -> (f64, f64) {
        let kappa = self.force.state[0] - 1.0;
        let torques = core::f64::consts::FRAC_1_SQRT_2 * away.torque_std;
        let usual = norm(&[MASS_TOLERANCE, RADIUS_TOLERANCE, torques]);
        let kappa_variance = usual * usual + self.force.covariance[0][0];
        let by_axle = away.ratio * (1.0 - away.ratio);
        let weights = [0.5 / kappa_variance, by_axle / (away.std * away.std)];
        let information = weights[0] * 0.5 + weights[1] * by_axle;
        let left = 1.0 / (1.0 / (OFF * OFF) + information);
        let by_gain = weights[0] * kappa;
        let by_ratio = weights[1] * (away.ratio - away.expected);
        let (mut total, mut squares) = (0.0, 0.0);
        for shown in [by_gain - by_ratio, by_gain + by_ratio] {
            let square = left * shown * shown;
            let odds = exp((0.5 * square).min(MAX_LOG_RATIO));
            total += odds;
            squares += odds * square;
        }
        let std = by_axle * sqrt(left);
        let off = std * sqrt(squares / total);
        let often = OFTEN * total * sqrt(left) / OFF;
        let probability = often / (1.0 - 2.0 * OFTEN + often);
        (probability, spread(probability, off, std))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Judgement for this kappa and this difference of the ratio from its prior.
    fn judged(kappa: f64, ratio_away: f64) -> (f64, f64) {
        stated(kappa, ratio_away, 0.005)
    }

    /// The same with torques of this tolerance.
    fn stated(kappa: f64, ratio_away: f64, torque_std: f64) -> (f64, f64) {
        let mut axles = AxleTorque::default();
        axles.force.state[0] = kappa;
        axles.force.covariance[0][0] = 4e-4;
        axles.judge(&RatioAway {
            ratio: 0.45 + ratio_away,
            expected: 0.45,
            std: 0.06,
            torque_std,
        })
    }

    #[test]
    fn a_torque_of_one_axle_is_likelier_the_further_force_and_acceleration_are_apart() {
        let [sound, off, far] = [1.01, 1.08, 1.15].map(|kappa| judged(kappa, 0.0));
        assert!(sound.0 < 0.1 && sound.1 < 0.005, "{sound:?}");
        assert!(off.0 > 0.2 && off.1 > 0.02, "{off:?}");
        assert!(far.0 > 0.8 && far.1 > off.1, "{far:?}");
        assert!(judged(0.85, 0.0).0 > 0.8);
    }

    #[test]
    fn a_ratio_that_is_off_with_it_makes_it_likelier_whichever_axle_it_is() {
        let alone = judged(1.07, 0.0).0;
        for away in [-0.1, 0.1] {
            assert!(judged(1.07, away).0 > 1.2 * alone, "{away}");
        }
    }

    #[test]
    fn a_kappa_that_the_stated_tolerances_of_both_torques_explain_is_no_torque_of_one_axle() {
        assert!(judged(1.07, 0.0).0 > 2.0 * stated(1.07, 0.0, 0.06).0);
    }

    #[test]
    fn driving_identifies_kappa_and_an_unreported_load_widens_it() {
        let mut axles = AxleTorque::default();
        for k in 0..6000 {
            let t = f64::from(k) * 0.01;
            let pull = f64::sin(0.8 * t) + 0.2;
            axles.see([1.1 * pull - 0.2, pull, 1.0], 0.01);
        }
        let variance = |axles: &AxleTorque| axles.force.covariance[0][0];
        assert!((axles.force.state[0] - 1.1).abs() < 0.01);
        assert!(variance(&axles) < 0.03 * 0.03, "{}", variance(&axles));
        axles.load_stepped();
        assert!(variance(&axles) >= 0.1 * 0.1);
    }
}
