//! The interval of a mixture of two hypotheses.
//!
//! Moments of a mixture make a bad interval of it: of a hypothesis with a probability of .01 they show a tenth of the distance,
//! though the 95 % interval may leave it out; of one with .2 not half of it, though the interval must reach it.

use crate::math::{ln, sqrt};

/// What an interval leaves outside, and its half width in standard deviations.
const OUTSIDE: f64 = 0.05;
const HALF_WIDTH: f64 = 1.959_964;

/// What a hypothesis adds to the 95 % interval about the other's value, as a standard deviation (to be added as squares). It has this
/// `probability`; by it the value lies `away`, on either side, with standard deviation `std`.
pub fn spread(probability: f64, away: f64, std: f64) -> f64 {
    let outside = OUTSIDE / probability.max(OUTSIDE);
    let shifted = away.abs() + std * upper_quantile(outside);
    let about = std * upper_quantile(0.5 * outside);
    if outside < 1.0 {
        shifted.max(about) / HALF_WIDTH
    } else {
        0.0
    }
}

/// What a normal deviate exceeds with this probability, to .0005 (Abramowitz, Stegun 1964, 26.2.23).
fn upper_quantile(probability: f64) -> f64 {
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
