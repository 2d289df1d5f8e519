//! Effect of an error common to the slips of all wheels on the slip stiffness.
//!
//! Wheels whose torque drives the machine with f = F/m slip by s = f/(K g). A torque signal that is tau earlier than wheel speed
//! and speed shifts their difference by up to tau f, where the slip makes v s. Both are proportional to f, so
//! ```text
//! 1/K' = 1/K + tau g/v,   1/v the mean over the motion, weighted by v^2 f^2 as least squares does
//! ```
//! At 2 m/s a millisecond is a tenth of K. The timing of signals is known no better, and so K is known no better. Other errors
//! common to the slips may shift K by any amount: a leaning accelerometer, wheels that spin, a speed that is not the body's. The
//! distance of K from its prior indicates them:
//! ```text
//! sigma_rep^2 = sigma^2 + (l K^2 g tau/v)^2 + p (K - K_0)^2,   p/(1 - p) = P/(1 - P) (1/R)/N(K - K_0; 0, sigma_0^2 + sigma^2 + ..)
//! ```
//! by Bayes' rule, where a common error, of prior probability P, puts K anywhere in its range R. l = 1 - sigma^2/sigma_0^2 is the
//! share of the information that the motion has contributed.

use core::f64::consts::TAU;

use crate::GRAVITY;
use crate::Quantity;
use crate::math::{exp, norm, sqrt};

/// Time between signals of one instant [s]: a frame of a CAN bus and a task of a controller.
const APART: f64 = 1e-3;
/// Share of machines with a larger error in both slips, P. Chosen on 52 loaders of an independent simulator. The interval covers K
/// for at least .94 of their time, for .93 on 60 that were drawn afterwards, and for .51 to .62 without either term.
const SHARED: f64 = 0.3;
/// Speed below which wheel speeds carry no information [m/s].
const SLOWEST: f64 = 0.5;

/// Sums of v f^2 and v^2 f^2 over time, for the mean of 1/v.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SharedSlip {
    first: f64,
    second: f64,
}

impl SharedSlip {
    /// Adds `dt` of motion at `speed` [m/s], driven by this force over the mass [m/s^2].
    pub fn see(&mut self, speed: f64, force: f64, dt: f64) {
        let speed = speed.abs();
        let weight = speed * force * force * dt;
        if speed > SLOWEST && weight.is_finite() {
            self.first += weight;
            self.second += speed * weight;
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

    /// Standard deviation of the slip stiffness `k`, common errors of the slips included. `range`: width of its bounds; `lag`: time
    /// between the wheel speeds of both axles, of which each may be late by half [s].
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
