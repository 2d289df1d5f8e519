//! Mixture of two hypotheses: its moments, for a filter that continues, and its interval, for the report.
//!
//! The moments of a mixture give a poor interval. A hypothesis with a probability of .01 widens them by a tenth of its distance,
//! though the 95 % interval may leave it out. One with .2 widens them by less than half of it, though the interval must include it.

/// Probability outside an interval, and its half width in standard deviations.
const OUTSIDE: f64 = 0.05;
const HALF_WIDTH: f64 = 1.959_964;

/// Logarithm of the odds up to which a 95 % interval may leave a hypothesis out: up to here it adds nothing.
pub const POSSIBLE: f64 = -2.944_438_979_166_440_3;

/// Standard deviation that a hypothesis adds to the 95 % interval about the other's value (to be added as squares). It has this
/// `probability`; under it the value lies `away`, on either side, with standard deviation `std`.
pub fn spread(probability: f64, away: f64, std: f64) -> f64 {
    let probability = probability.max(OUTSIDE);
    if probability <= OUTSIDE {
        return 0.0;
    }
    let outside = OUTSIDE / probability;
    let shifted = away.abs() + std * upper_quantile(outside);
    let about = std * upper_quantile(0.5 * outside);
    shifted.max(about) / HALF_WIDTH
}

/// Replaces mean and covariance by those of the mixture with `other`, which has this probability.
pub fn mix<const N: usize>(
    state: &mut [f64; N],
    covariance: &mut [[f64; N]; N],
    other: (&[f64; N], &[[f64; N]; N]),
    probability: f64,
) {
    let mut apart = [0.0; N];
    for (i, apart) in apart.iter_mut().enumerate() {
        *apart = other.0[i] - state[i];
        state[i] += probability * *apart;
    }
    let spread = probability * (1.0 - probability);
    for (i, row) in covariance.iter_mut().enumerate() {
        for (j, p) in row.iter_mut().enumerate() {
            *p += probability * (other.1[i][j] - *p) + spread * apart[i] * apart[j];
        }
    }
}

/// Upper end of the central form of the quantile; a larger probability is limited to this.
const CENTRAL: f64 = 0.975_75;
/// Coefficients of its numerator and denominator.
const NUMERATOR: [f64; 6] = [
    -39.696_830_286_653_76,
    220.946_098_424_520_5,
    -275.928_510_446_968_7,
    138.357_751_867_269,
    -30.664_798_066_147_16,
    2.506_628_277_459_239,
];
const DENOMINATOR: [f64; 6] = [
    -54.476_098_798_224_06,
    161.585_836_858_040_9,
    -155.698_979_859_886_6,
    66.801_311_887_719_72,
    -13.280_681_552_885_72,
    1.0,
];

/// Upper quantile of the normal distribution, for probabilities from .02425 to .97575; a larger one is limited
/// (P. J. Acklam, "An algorithm for computing the inverse normal cumulative distribution function", 2003: relative error 1.2e-9).
fn upper_quantile(probability: f64) -> f64 {
    let q = 0.5 - probability.min(CENTRAL);
    let r = q * q;
    let polynomial = |of: [f64; 6]| of.into_iter().fold(0.0, |sum, c| sum * r + c);
    q * polynomial(NUMERATOR) / polynomial(DENOMINATOR)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{ln, sqrt};

    /// Upper quantile at any probability, to .0005 (Abramowitz, Stegun 1964, 26.2.23).
    fn quantile(probability: f64) -> f64 {
        let tail = probability.min(1.0 - probability).max(1e-300);
        let t = sqrt(-2.0 * ln(tail));
        let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
        let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
        let quantile = t - above / below;
        if probability < 0.5 {
            quantile
        } else {
            -quantile
        }
    }

    #[test]
    fn odds_that_are_possible_are_those_that_add_something() {
        let adds = |odds: f64| spread(1.0 / (1.0 + crate::math::exp(-odds)), 1.0, 1.0) > 0.0;
        assert!(!adds(POSSIBLE - 1e-9) && adds(POSSIBLE + 1e-9));
    }

    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        for (probability, deviate) in [(0.5, 0.0), (0.05, 1.644_854), (0.025, HALF_WIDTH)] {
            assert!((upper_quantile(probability) - deviate).abs() < 1e-6);
            assert!((upper_quantile(1.0 - probability) + deviate).abs() < 1e-6);
        }
        for probability in (3..98).map(|i| 0.01 * f64::from(i)) {
            assert!((upper_quantile(probability) - quantile(probability)).abs() < 5e-4);
        }
    }

    #[test]
    fn the_interval_leaves_a_twentieth_of_the_mixture_outside() {
        // About a value that the other hypothesis knows exactly; quantiles of the hypothesis on a fine grid.
        for (probability, away, std) in [
            (0.1, 0.0, 1.0),
            (0.2, 5.0, 1.0),
            (0.5, -4.0, 1.0),
            (1.0, 6.0, 2.0),
        ] {
            let half_width = HALF_WIDTH * spread(probability, away, std);
            let outside = (0..10_000)
                .map(|i| away + std * quantile((f64::from(i) + 0.5) / 10_000.0))
                .filter(|value| value.abs() > half_width)
                .count();
            let share = probability * outside as f64 / 10_000.0;
            assert!(
                (share - OUTSIDE).abs() < 1e-3,
                "{probability} {away} {share}"
            );
        }
    }

    #[test]
    fn what_has_less_than_a_twentieth_adds_nothing() {
        for probability in [0.0, 0.01, 0.05, f64::NAN] {
            assert_eq!(spread(probability, 10.0, 3.0), 0.0);
        }
        assert!(spread(0.051, 10.0, 3.0).abs() < 3.0);
    }
}
