//! Whether the centre drive is locked: then both axles turn alike, and the reported torques are not theirs.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | d | `difference` | measured difference of the wheel speeds, w_f - w_r | rad/s |
//! | y, S | `innovation`, `predicted` | its innovation in the filter, and the variance of its prediction | |
//! | Q | `process` | what process noise adds to S: both models have it | rad^2/s^2 |
//! | R | `noise` | variance of its measurement | rad^2/s^2 |
//! | L | `log_odds` | log odds of locked against free | 1 |
//!
//! Two models for the same data, weighed by Bayes' rule. Free axles: the filter's, y ~ N(0, S + R). Locked ones: d ~ N(0, Q + R),
//! whatever torques and radii.
//! ```text
//! L += 1/2 [ln((S + R)/(Q + R)) + y^2/(S + R) - d^2/(Q + R)]
//! ```
//! Rolling radii that differ by a thousandth turn free axles apart by some standard deviations a row, and so does a torque;
//! locked axles the filter explains by radii, share and height that just cancel, which it must find first, and that costs
//! it the logarithm. Odds are bounded, so that a lock that engages or opens shows at once.

use crate::math::{exp, ln};

/// Probability of a lock before the first row: the description says that the axles are free.
const PRIOR: f64 = 0.04;
/// Bound of the log odds: 1 in 1100.
const BOUND: f64 = 7.0;
/// Rows with more noise than this multiple of the sensors' are left out: what is added for disturbances is an upper bound, and
/// where the noise is less than R the logarithm outweighs the squares.
const PLAIN: f64 = 2.0;
/// What is less probable than this an interval of 95 % leaves out.
const EXCLUDED: f64 = 0.05;

/// The difference of the wheel speeds in one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turning {
    /// Measured [rad/s].
    pub difference: f64,
    /// Its innovation [rad/s].
    pub innovation: f64,
    /// Variance of its prediction [rad^2/s^2].
    pub predicted: f64,
    /// Share of the process noise in it [rad^2/s^2].
    pub process: f64,
    /// Variance of its measurement [rad^2/s^2].
    pub noise: f64,
    /// The part of it that is the sensors'.
    pub sensors: f64,
}

/// Memory of the two models.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Coupling {
    log_odds: f64,
}

impl Default for Coupling {
    fn default() -> Self {
        Self {
            log_odds: ln(PRIOR / (1.0 - PRIOR)),
        }
    }
}

impl Coupling {
    /// Takes a row in which the wheels tell something; what is not finite tells nothing.
    pub fn see(&mut self, row: &Turning) {
        if row.noise > PLAIN * row.sensors {
            return;
        }
        let free = row.predicted.max(row.process) + row.noise;
        let locked = row.process + row.noise;
        let evidence = ln(free / locked) + row.innovation * row.innovation / free
            - row.difference * row.difference / locked;
        if evidence.is_finite() {
            self.log_odds = (self.log_odds + 0.5 * evidence).clamp(-BOUND, BOUND);
        }
    }

    /// Probability that the axles are locked; 0 where an interval may leave it out.
    pub fn locked(&self) -> f64 {
        let probability = 1.0 / (1.0 + exp(-self.log_odds));
        if probability < EXCLUDED {
            0.0
        } else {
            probability
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(difference: f64, innovation: f64, predicted: f64) -> Turning {
        Turning {
            difference,
            innovation,
            predicted,
            process: 2e-6,
            noise: 8e-6,
            sensors: 8e-6,
        }
    }

    #[test]
    fn axles_that_turn_apart_are_free_and_those_that_never_do_are_locked() {
        let mut free = Coupling::default();
        assert_eq!(free.locked(), 0.0);
        for _ in 0..3 {
            free.see(&row(0.02, 0.001, 1e-4));
        }
        assert_eq!((free.locked(), free.log_odds), (0.0, -BOUND));
        // The lock engages: the filter still expects what it has learnt of the free axles.
        free.see(&row(0.001, -0.02, 3e-6));
        assert!(free.locked() > 0.9);

        let mut locked = Coupling::default();
        // Five parameters, each of which the filter could not know before.
        (0..5).for_each(|_| locked.see(&row(0.001, 0.001, 1e-4)));
        assert!(locked.locked() > 0.5, "{}", locked.locked());
        // What the filter has found, and what is no number, tells nothing more.
        let known = locked;
        locked.see(&row(0.003, 0.003, 2e-6));
        locked.see(&row(f64::NAN, 0.0, 1e-4));
        // Nor does a row that is disturbed.
        locked.see(&Turning {
            noise: 1e-4,
            ..row(0.001, 0.001, 1e-4)
        });
        assert_eq!(locked, known);
    }
}
