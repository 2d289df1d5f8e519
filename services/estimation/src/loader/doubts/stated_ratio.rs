//! Combination of the ratio from the slips with the ratio stated beforehand, by Bayes' rule.
//!
//! The slips determine the *apparent* ratio. An axle whose tyres or torque differ by a share x looks like a load, lam (1 - lam) x,
//! and no motion distinguishes them. The filter does not model this error. Within a minute its variance is far below that of
//! the real error, and its prior has no weight. The ratio of the machine is constant, so here the prior enters with its own variance:
//! ```text
//! R = sigma_rep^2 - P,   r = P/sigma_0^2,   S = P + R (1 - r)
//! lam = lam_0 + w (lam_P - lam_0),   sigma^2 = w^2 (1 - r) S + (1 - w (1 - r))^2 sigma_0^2
//! weighed: w = sigma_0^2/(sigma_0^2 + sigma_rep^2),   a guess: w = sigma_0^2/S, at most 1
//! ```
//! | symbol | code | meaning |
//! |---|---|---|
//! | lam_P, P | `slips.value`, `filter_std` | state of the filter and its variance, which include the prior: r is its share |
//! | sigma_rep | `slips.std` | deviation of the apparent ratio from the ratio as reported, with floors and doubts |
//! | lam_0, sigma_0 | `stated` | prior of the empty machine |
//! | S/(1 - r) | - | variance of the slips alone, independent of the prior |
//!
//! The weight of a weighed ratio is exact for r = 0. For r = 1 the state of the filter is the stated ratio, and any weight is right. A
//! filter whose covariance was opened again has r = 1 at another state, and then this weight stays near the weighed ratio.
//!
//! With r = 1 the slips carry no information yet. With r = 0 they are a measurement with variance P + R, independent of the prior.
//!
//! A stated ratio that would be trusted by itself has been weighed, and counts by Bayes' rule. A wider one is a guess of a data
//! sheet. On thirty machines with equal axles, Bayes' rule with a guess would double their error, from .9 to 1.7 %. So a guess
//! counts by the information that it has beyond that of the slips alone, 1/sigma_0^2 - (1 - r)/S. It does not count where it has
//! none. Otherwise it would pull the ratio away by half as soon as the slips became a little less certain than the guess.

use crate::Quantity;
use crate::math::sqrt;

/// Returns the combined ratio; `limit`: the deviation at which a ratio is trusted.
pub fn together(slips: Quantity, filter_std: f64, stated: Quantity, limit: f64) -> Quantity {
    let is_guess = stated.std > limit;
    if is_guess && stated.std > slips.std {
        return slips;
    }
    let (filtered, before) = (filter_std * filter_std, stated.std * stated.std);
    let left = (1.0 - filtered / before).max(0.0);
    let rest = (slips.std * slips.std - filtered).max(0.0) * left;
    let counted = if is_guess {
        filtered + rest
    } else {
        before + slips.std * slips.std
    };
    let weight = (before / counted).min(1.0);
    let by_slips = weight * weight * left * (filtered + rest);
    let by_stated = (1.0 - weight * left) * stated.std;
    Quantity {
        value: stated.value + (slips.value - stated.value) * weight,
        std: sqrt(by_slips + by_stated * by_stated),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATED: Quantity = Quantity {
        value: 0.45,
        std: 0.02,
    };
    const WEIGHED: f64 = 0.02;
    const GUESSED: f64 = 0.019;

    fn slips(std: f64) -> Quantity {
        Quantity { value: 0.5, std }
    }

    #[test]
    fn slips_are_a_measurement_beside_what_was_weighed() {
        // The deviation is 1e-4 in the filter and .02 by what it leaves out: equal weights.
        let both = together(slips(0.02), 1e-4, STATED, WEIGHED);
        assert!((both.value - 0.475).abs() < 1e-5, "{both:?}");
        assert!((both.std - 0.02 / 2.0_f64.sqrt()).abs() < 1e-5, "{both:?}");
    }

    #[test]
    fn a_filter_that_was_opened_far_from_a_weighed_ratio_does_not_replace_it() {
        let opened = Quantity {
            value: 0.6,
            std: 0.2,
        };
        let both = together(opened, 0.2, STATED, WEIGHED);
        assert!(
            (both.value - STATED.value).abs() < 0.1 * STATED.std,
            "{both:?}"
        );
        assert_eq!(both.std, STATED.std);
    }

    #[test]
    fn a_guess_counts_by_what_it_knows_beyond_the_slips_and_never_at_once() {
        assert_eq!(
            together(slips(0.0199), 1e-4, STATED, GUESSED),
            slips(0.0199)
        );
        let as_sure = together(slips(0.0201), 1e-4, STATED, GUESSED);
        assert!((as_sure.value - 0.5).abs() < 1e-3, "{as_sure:?}");
        assert!((as_sure.std - 0.02).abs() < 2e-4, "{as_sure:?}");
        // Of the information 1/.02^2 the slips have a quarter.
        let sharper = together(slips(0.04), 1e-4, STATED, GUESSED);
        assert!((sharper.value - (0.45 + 0.05 / 4.0)).abs() < 1e-5);
        let std = 0.02 * (1.0_f64 - 0.25 + 0.25 * 0.25).sqrt();
        assert!((sharper.std - std).abs() < 1e-5, "{sharper:?}");
    }

    #[test]
    fn what_was_known_counts_once() {
        for limit in [WEIGHED, GUESSED] {
            // The filter has seen nothing yet: its state is the prior, whatever is left out.
            let slips = Quantity {
                value: 0.45,
                std: 0.03,
            };
            assert_eq!(together(slips, STATED.std, STATED, limit), STATED);
        }
        // Data and prior carry equal information: half of the error that the filter leaves out is already the prior's.
        let filter_std = 0.02 / 2.0_f64.sqrt();
        let slips = Quantity {
            value: 0.475,
            std: 0.03,
        };
        let both = together(slips, filter_std, STATED, WEIGHED);
        assert!(
            (both.value - (0.45 + 0.025 * 4.0 / 13.0)).abs() < 1e-12,
            "{both:?}"
        );
        // The best weight would be 4/7.5. The safe one costs 3 % of the deviation.
        let information: f64 = 1.0 / 4e-4 + 0.5 / 5.5e-4;
        let best = (1.0_f64 / information).sqrt();
        assert!((1.0..1.04).contains(&(both.std / best)), "{both:?}");
    }
}
