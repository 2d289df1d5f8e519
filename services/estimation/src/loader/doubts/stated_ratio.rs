//! The ratio by the slips and what was known of it before them, by Bayes' rule.
//!
//! Slips tell the *apparent* ratio. An axle whose tyres or torque differ by a share x looks like a load, lam (1 - lam) x, and nothing
//! in the motion tells both apart. The filter knows no such error, so within a minute it knows its state far better than the ratio is known,
//! and its prior counts for nothing. The ratio of the machine does not wander, so here the prior counts as what it is:
//! ```text
//! R = sigma_rep^2 - P,   r = P/sigma_0^2,   D = sigma_0^2 + R (1 - r)
//! lam = lam_0 + (lam_P - lam_0) sigma_0^2/D,   sigma^2 = sigma_0^2 (P + R (1 - r))/D
//! ```
//! | symbol | code | meaning |
//! |---|---|---|
//! | lam_P, P | `slips.value`, `filter_std` | state of the filter and its variance, in which the prior counts already: r is its share |
//! | sigma_rep | `slips.std` | deviation of the apparent ratio from the ratio as reported, with floors and doubts |
//! | lam_0, sigma_0 | `stated` | what was known of the empty machine before |
//!
//! With r = 1 the slips have told nothing yet; with r = 0 they are a measurement with variance P + R that is independent of the prior.
//! A ratio that is stated no closer than the slips tell it is a guess of a data sheet, and leaves them alone: on thirty machines whose
//! axles are alike it would double their error, from .9 to 1.7 %.

use crate::Quantity;
use crate::math::sqrt;

/// Both together, where the stated one is the sharper.
pub fn together(slips: Quantity, filter_std: f64, stated: Quantity) -> Quantity {
    if stated.std > slips.std {
        return slips;
    }
    let (told, before) = (filter_std * filter_std, stated.std * stated.std);
    let left = (1.0 - told / before).max(0.0);
    let rest = (slips.std * slips.std - told).max(0.0) * left;
    let sum = before + rest;
    Quantity {
        value: stated.value + (slips.value - stated.value) * before / sum,
        std: sqrt(before * (told + rest) / sum),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATED: Quantity = Quantity {
        value: 0.45,
        std: 0.02,
    };

    #[test]
    fn slips_are_a_measurement_beside_what_was_known() {
        let slips = |std| Quantity { value: 0.5, std };
        // Known to 1e-4 by the filter, to .02 by what it leaves out: half and half.
        let both = together(slips(0.02), 1e-4, STATED);
        assert!((both.value - 0.475).abs() < 1e-5, "{both:?}");
        assert!((both.std - 0.02 / 2.0_f64.sqrt()).abs() < 1e-5, "{both:?}");
        // A guess leaves them as they are.
        let guess = Quantity {
            std: 0.03,
            ..STATED
        };
        assert_eq!(together(slips(0.02), 1e-4, guess), slips(0.02));
    }

    #[test]
    fn what_was_known_counts_once() {
        // The filter has seen nothing yet: its state is the prior, whatever is left out.
        let slips = Quantity {
            value: 0.45,
            std: 0.03,
        };
        assert_eq!(together(slips, STATED.std, STATED), STATED);
        // It has seen as much as it knew: half of what it left out is already the prior's.
        let filter_std = 0.02 / 2.0_f64.sqrt();
        let slips = Quantity {
            value: 0.475,
            std: 0.03,
        };
        let both = together(slips, filter_std, STATED);
        assert!(
            (both.value - (0.45 + 0.025 * 4.0 / 7.5)).abs() < 1e-12,
            "{both:?}"
        );
    }
}
