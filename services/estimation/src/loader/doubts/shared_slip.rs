//! What an error that the slips of all wheels share does to the slip stiffness.
//!
//! Wheels whose torque drives the machine with f = F/m slip by s = f/(K g). A torque that comes tau before the wheel speeds and the speed
//! shifts their difference by up to tau f, where the slip is v s: both go with f, so
//! ```text
//! 1/K' = 1/K + tau g/v,   1/v the mean over the motion, weighted by v^2 f^2 as least squares does
//! ```
//! At 2 m/s a millisecond is a tenth of K. No sensor tells its time more closely, so no data tell K more closely. What else slips share
//! (a leaning accelerometer, wheels that spin, a speed that is not the body's) may shift K by any amount, and shows in how far K lies from
//! what it was expected to be:
//! ```text
//! sigma_rep^2 = sigma^2 + (l K^2 g tau/v)^2 + p (K - K_0)^2,   p/(1 - p) = P/(1 - P) (1/R)/N(K - K_0; 0, sigma_0^2 + sigma^2 + ..)
//! ```
//! by Bayes' rule, where a shared error puts K anywhere in its range R. l = 1 - sigma^2/sigma_0^2 is the share that the motion has told.

use core::f64::consts::TAU;

use crate::GRAVITY;
use crate::Quantity;
use crate::math::{exp, norm, sqrt};

/// How far apart in time signals come that say the same [s]: a frame of a CAN bus and a task of a controller.
const APART: f64 = 1e-3;
/// So many machines have a larger error in both slips. Chosen on 52 loaders of a plant of others: the interval covers K for .94 of their
/// time at least, for .93 on 60 that were drawn afterwards, and for .51 to .62 without either term.
const SHARED: f64 = 0.3;
/// Slower than this wheels say nothing [m/s].
const SLOWEST: f64 = 0.5;

/// Memory of the motion: sums of v f^2 and v^2 f^2 over time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SharedSlip {
    first: f64,
    second: f64,
}

impl SharedSlip {
    /// Takes `dt` of motion at a speed [m/s], driven by this force over the mass [m/s^2].
    pub fn see(&mut self, speed: f64, force: f64, dt: f64) {
        let speed = speed.abs();
        let tells = speed * force * force * dt;
        if speed > SLOWEST && tells.is_finite() {
            self.first += tells;
            self.second += speed * tells;
        }
    }

    /// Mean of 1/v over the motion, weighted as least squares does [s/m].
    fn per_speed(&self) -> f64 {
        if self.second > 0.0 {
            (self.first / self.second).min(1.0 / SLOWEST)
        } else {
            1.0 / SLOWEST
        }
    }

    /// Derivative of the ratio by a lag between the wheel speeds of both axles [1/s].
    pub fn ratio_by_lag(&self, stiffness: f64, ratio: f64) -> f64 {
        // 1/lam^2 + 1/(1 - lam)^2 is (1 - 2 p)/p^2.
        let p = ratio * (1.0 - ratio);
        2.0 * GRAVITY * stiffness * self.per_speed() * p * p / (1.0 - 2.0 * p)
    }

    /// Standard deviation of the slip stiffness `k` with what its slips share; `prior`: what it was expected to be; `range`: what it may be;
    /// `lag`: between the wheel speeds of both axles, half of which each may be late [s].
    pub fn std(&self, k: Quantity, prior: Quantity, range: f64, lag: f64) -> f64 {
        let learnt = (1.0 - k.std * k.std / (prior.std * prior.std)).max(0.0);
        let apart = sqrt(APART * APART + 0.25 * lag * lag);
        let timing = learnt * k.value * k.value * GRAVITY * apart * self.per_speed();
        let away = k.value - prior.value;
        let spread = norm(&[prior.std, k.std, timing]);
        let z = away / spread;
        let expected = exp(-0.5 * z * z) / (spread * sqrt(TAU));
        let shared = SHARED / range;
        let probability = shared / (shared + (1.0 - SHARED) * expected);
        let std = norm(&[k.std, timing, sqrt(probability) * away]);
        if std.is_finite() { std } else { k.std }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRIOR: Quantity = Quantity {
        value: 19.0,
        std: 2.5,
    };

    fn std(value: f64, speed: f64) -> f64 {
        let mut slip = SharedSlip::default();
        (0..1000).for_each(|k| slip.see(speed, f64::from(k % 3) - 1.0, 0.01));
        slip.std(Quantity { value, std: 0.5 }, PRIOR, 76.0, 0.0)
    }

    #[test]
    fn a_millisecond_is_a_tenth_of_the_stiffness_at_two_metres_per_second() {
        let slow = std(19.0, 2.0);
        assert!((slow - 1.70_f64.hypot(0.5)).abs() < 0.01, "{slow}");
        assert!(std(19.0, 8.0) < 0.7, "{}", std(19.0, 8.0));
        assert!(std(19.0, -2.0) == slow);
        let stood = SharedSlip::default().std(PRIOR, PRIOR, 76.0, 0.0);
        assert_eq!(stood, PRIOR.std, "nothing has moved");
    }

    #[test]
    fn what_lies_far_from_what_was_expected_spans_both() {
        for value in [6.0, 40.0] {
            let std = std(value, 8.0);
            assert!(1.96 * std > (value - 19.0).abs(), "{value}: {std}");
        }
        assert!(std(21.0, 8.0) < 1.2, "{}", std(21.0, 8.0));
    }
}
