//! The ratio by the slips and what was known of it before them, by Bayes' rule.
//!
//! Slips tell the *apparent* ratio. An axle whose tyres or torque differ by a share x looks like a load, lam (1 - lam) x, and nothing
//! in the motion tells both apart. The filter knows no such error, so within a minute it knows its state far better than the ratio is known,
//! and its prior counts for nothing. The ratio of the machine does not wander, so here the prior counts as what it is:
//! ```text
//! R = sigma_rep^2 - P,   r = P/sigma_0^2,   S = P + R (1 - r)
//! lam = lam_0 + w (lam_P - lam_0),   sigma^2 = w^2 (1 - r) S + (1 - w (1 - r))^2 sigma_0^2
//! weighed: w = sigma_0^2/(sigma_0^2 + R (1 - r)),   a guess: w = sigma_0^2/S, at most 1
//! ```
//! | symbol | code | meaning |
//! |---|---|---|
//! | lam_P, P | `slips.value`, `filter_std` | state of the filter and its variance, in which the prior counts already: r is its share |
//! | sigma_rep | `slips.std` | deviation of the apparent ratio from the ratio as reported, with floors and doubts |
//! | lam_0, sigma_0 | `stated` | what was known of the empty machine before |
//! | S/(1 - r) | - | variance of the slips alone, independent of the prior |
//!
//! With r = 1 the slips have told nothing yet; with r = 0 they are a measurement with variance P + R that is independent of the prior.
//!
//! A ratio that would be trusted by itself has been weighed, and counts by Bayes' rule. A wider one is a guess of a data sheet: on thirty
//! machines whose axles are alike it would double their error, from .9 to 1.7 %. So it counts by the information that it has beyond the
//! slips' alone, 1/sigma_0^2 - (1 - r)/S, and not at all where it has none: what was known cannot pull the ratio away by half when the
//! slips become a little less sure than the guess.

use crate::Quantity;
use crate::math::sqrt;

/// Both together; `limit`: the deviation at which a ratio is trusted.
pub fn together(slips: Quantity, filter_std: f64, stated: Quantity, limit: f64) -> Quantity {
    let is_guess = stated.std > limit;
    if is_guess && stated.std > slips.std {
        return slips;
    }
    let (told, before) = (filter_std * filter_std, stated.std * stated.std);
    let left = (1.0 - told / before).max(0.0);
    let rest = (slips.std * slips.std - told).max(0.0) * left;
    let counted = if is_guess { told } else { before };
    let way = (before / (counted + rest)).min(1.0);
    let by_slips = way * way * left * (told + rest);
    let by_stated = (1.0 - way * left) * stated.std;
    Quantity {
        value: stated.value + (slips.value - stated.value) * way,
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
        // Known to 1e-4 by the filter, to .02 by what it leaves out: half and half.
        let both = together(slips(0.02), 1e-4, STATED, WEIGHED);
        assert!((both.value - 0.475).abs() < 1e-5, "{both:?}");
        assert!((both.std - 0.02 / 2.0_f64.sqrt()).abs() < 1e-5, "{both:?}");
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
        // It has seen as much as it knew: half of what it left out is already the prior's.
        let filter_std = 0.02 / 2.0_f64.sqrt();
        let slips = Quantity {
            value: 0.475,
            std: 0.03,
        };
        let both = together(slips, filter_std, STATED, WEIGHED);
        assert!(
            (both.value - (0.45 + 0.025 * 4.0 / 7.5)).abs() < 1e-12,
            "{both:?}"
        );
        let information: f64 = 1.0 / 4e-4 + 0.5 / 5.5e-4;
        assert!(
            (both.std - (1.0_f64 / information).sqrt()).abs() < 1e-12,
            "{both:?}"
        );
    }
}
