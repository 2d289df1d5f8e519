//! Mean and standard deviation of a normal distribution truncated at zero, for a quantity that is not negative.
//!
//! ```text
//! a = m/sigma,  lambda = phi(a)/Phi(a):     m' = m + sigma lambda,   sigma'^2 = sigma^2 [1 - lambda (lambda + a)]
//! ```
//! (Johnson, Kotz, Balakrishnan 1994, 13.10.1.) m' is below 1.96 sigma' wherever a is below zero: truncation alone never excludes zero
//! from the interval.

use crate::Quantity;
use crate::math::{exp, sqrt};

/// Value of a beyond which truncation changes nothing: phi(8) is 5e-15.
const FAR: f64 = 8.0;
/// Value of a below which the rest is an exponential distribution to a thousandth; further digits are rounding.
const DEEP: f64 = -30.0;
/// Value of a below which the continued fraction of the tail replaces the series of Phi.
const TAIL: f64 = -3.0;
/// Largest number of terms of both: to 1e-12 where they meet.
const TERMS: u32 = 40;

/// Moments of the quantity, truncated at zero.
pub(crate) fn positive(normal: Quantity) -> Quantity {
    let Quantity { value, std } = normal;
    let a = value / std;
    if !a.is_finite() || a > FAR {
        return normal;
    }
    let a = a.max(DEEP);
    let lambda = hazard(a);
    Quantity {
        value: std * (a + lambda),
        std: std * sqrt((1.0 - lambda * (lambda + a)).max(0.0)),
    }
}

/// phi(a)/Phi(a).
fn hazard(a: f64) -> f64 {
    if a < TAIL {
        // phi(x)/Phi(-x) = x + 1/(x + 2/(x + 3/(x + ..)))
        let x = -a;
        return (1..=TERMS).rev().fold(x, |rest, n| x + f64::from(n) / rest);
    }
    let density = exp(-0.5 * a * a) / sqrt(core::f64::consts::TAU);
    // Phi(a) = 1/2 + phi(a) [a + a^3/3 + a^5/(3 5) + ..]
    let (mut term, mut sum) = (a, a);
    for n in 1..=2 * TERMS {
        term *= a * a / f64::from(2 * n + 1);
        sum += term;
        // Further terms are rounding.
        if term.abs() < 1e-17 * sum.abs() {
            break;
        }
    }
    density / (0.5 + density * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(value: f64) -> Quantity {
        positive(Quantity { value, std: 1.0 })
    }

    #[test]
    fn moments_are_those_of_the_cut_distribution() {
        for a in [-12.0, -3.1, -2.9, -1.0, 0.0, 0.7, 2.0, 5.0] {
            let (mut mass, mut first, mut second) = (0.0, 0.0, 0.0);
            let step = 1e-4;
            for k in 0..200_000 {
                let x = (f64::from(k) + 0.5) * step;
                // Normal density about `a`, relative to its largest value above zero.
                let near = f64::max(a, 0.0);
                let away = ((x - a) * (x - a) - (near - a) * (near - a)) / 2.0;
                let density = exp(-away) * step;
                mass += density;
                first += x * density;
                second += x * x * density;
            }
            let (mean, square) = (first / mass, second / mass);
            let cut = of(a);
            assert!((cut.value - mean).abs() < 1e-6, "{a}: {cut:?} {mean}");
            let std = (square - mean * mean).sqrt();
            assert!((cut.std - std).abs() < 1e-5, "{a}: {cut:?} {std}");
        }
    }

    #[test]
    fn far_from_zero_nothing_changes_and_deep_below_it_is_a_number() {
        assert_eq!(
            of(9.0),
            Quantity {
                value: 9.0,
                std: 1.0
            }
        );
        let deep = of(-1e9);
        assert!(deep.value > 0.0 && deep.value < 0.05 && deep.std > 0.0 && deep.std < 0.05);
        let nothing = Quantity {
            value: 0.0,
            std: 0.0,
        };
        assert_eq!(positive(nothing), nothing);
        // The zero stays within the interval.
        for k in 0..300 {
            let cut = of(-0.1 * f64::from(k));
            assert!(cut.value < 1.96 * cut.std, "{k} {cut:?}");
        }
    }
}
