//! Probability that the measured torque of one axle has a gain error: a gear ratio, a motor's constant, a displacement.
//!
//! A gain error g of one axle looks like a shift of load between the axles. While the axles pull in a constant proportion, motion does not
//! distinguish them. The evidence is kappa, force over acceleration of all driving so far (`doubts::gain`), which is off by g/2, and
//! the difference of the ratio from its prior.
//!
//! ```text
//! H_0:      kappa - 1 ~ N(0, s^2 + P),                  lam - lam_0 ~ N(0, p^2),   s^2 = .02^2 + .01^2 + sigma_T^2/2
//! H_l:      kappa - 1 ~ U(-1/3, 0), a load that nobody reports, prior odds 1 to H_0 where no mass is reported
//! H_f, H_r: kappa - 1 = g/2 + .., lam - lam_0 = -+ lam (1 - lam) g + .., g ~ N(0, c^2): the true torque over the measured one, minus 1
//! ```

use core::f64::consts::TAU;

use crate::Quantity;
use crate::math::{exp, norm, sqrt};
use crate::mixture::spread;

/// Prior probability that an uncalibrated torque is off beyond its stated tolerance: of each axle, one machine in thirteen.
const OFTEN: f64 = 0.077;
/// Standard deviation of g in that case.
const OFF: f64 = 0.2;
/// Standard deviations of kappa by the tolerances of mass and rolling radius; those of the torques are stated.
const MASS_TOLERANCE: f64 = 0.02;
const RADIUS_TOLERANCE: f64 = 0.01;
/// Largest unreported load, as a share of the loaded machine.
const LARGEST_LOAD: f64 = 1.0 / 3.0;
/// Limit of the logarithm of the likelihood ratio, against overflow.
const MAX_LOG_RATIO: f64 = 50.0;

/// Estimated ratio lam, its prior lam_0, and the standard deviation p of their difference.
#[derive(Clone, Copy, Debug)]
pub struct RatioAway {
    pub ratio: f64,
    pub expected: f64,
    pub std: f64,
    /// Tolerance of the torque of an axle, as a share.
    pub torque_std: f64,
    /// No mass with its load is reported.
    pub untold_load: bool,
}

/// Probability that one axle's torque is off, and the standard deviation that this adds to the ratio.
pub fn judge(found: Quantity, away: &RatioAway) -> (f64, f64) {
    let kappa = found.value - 1.0;
    let torques = core::f64::consts::FRAC_1_SQRT_2 * away.torque_std;
    let usual = norm(&[MASS_TOLERANCE, RADIUS_TOLERANCE, torques]);
    let kappa_variance = usual * usual + found.std * found.std;
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
    let load = if away.untold_load {
        odds_of_load(kappa, kappa_variance)
    } else {
        0.0
    };
    let other = (1.0 - 2.0 * OFTEN) * (1.0 + load);
    let probability = often / (other + often);
    (probability, spread(probability, off, std))
}

/// Likelihood ratio of an unreported load to H_0, by kappa - 1 and its variance.
fn odds_of_load(kappa: f64, variance: f64) -> f64 {
    if !(-LARGEST_LOAD..0.0).contains(&kappa) {
        return 0.0;
    }
    let square = kappa * kappa / variance;
    let likelihood = exp((0.5 * square).min(MAX_LOG_RATIO));
    likelihood * sqrt(TAU * variance) / LARGEST_LOAD
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Judgement for this kappa and this difference of the ratio from its prior.
    fn judged(kappa: f64, ratio_away: f64) -> (f64, f64) {
        stated(kappa, ratio_away, 0.005)
    }

    /// The same with torques of this tolerance, of a machine whose mass is reported.
    fn stated(kappa: f64, ratio_away: f64, torque_std: f64) -> (f64, f64) {
        with_load(kappa, ratio_away, torque_std, false)
    }

    fn with_load(kappa: f64, ratio_away: f64, torque_std: f64, untold_load: bool) -> (f64, f64) {
        let found = Quantity {
            value: kappa,
            std: 0.02,
        };
        let away = RatioAway {
            ratio: 0.45 + ratio_away,
            expected: 0.45,
            std: 0.06,
            torque_std,
            untold_load,
        };
        judge(found, &away)
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
    fn a_machine_that_seems_heavier_may_carry_a_load_that_nobody_reports_and_one_that_seems_lighter_not()
     {
        let [heavier, lighter] = [0.85, 1.15].map(|kappa| with_load(kappa, 0.0, 0.005, true).0);
        assert!(heavier < 0.35, "{heavier}");
        assert_eq!(lighter, judged(1.15, 0.0).0);
    }
}
