//! Whether the centre drive is locked: then both axles turn alike, and the reported torques are not theirs.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | d | `difference` | measured difference of the wheel speeds, w_f - w_r | rad/s |
//! | y, S | `innovation`, `predicted` | its innovation in the filter, and the variance of its prediction | |
//! | Q | `process` | what process noise adds to S: both models have it | rad^2/s^2 |
//! | R | `noise` | variance of its measurement | rad^2/s^2 |
//! | L | - | log odds of locked against free; `probability` keeps them | 1 |
//! | w | - | share of [`WINDING`] that the row lasts, at most 1 | 1 |
//!
//! Two models for the same data, weighed by Bayes' rule. Free axles: the filter's, y ~ N(0, S + R). Locked ones: d ~ N(0, Q + R),
//! whatever torques and radii; a lock engages and opens by chance.
//! ```text
//! L += w/2 [y^2/(S + R) - d^2/(Q + R)]
//! ```
//! Rolling radii that differ by a thousandth turn free axles apart by some standard deviations a row, and so do a torque and a load
//! that moves from axle to axle; locked axles the filter explains by radii, share and height that just cancel, but not in every row.
//! How unlikely it was that they cancel (the determinants of S + R and Q + R) is left out: axles with the same tyres, half the load
//! and half the torque each are no rarity, and a load that may have changed widens S at every stop.

use crate::math::exp;

/// Probability of a lock before the first row, and in the mean: more than an interval leaves out, so until the axles have turned apart
/// nothing is believed of what they pull.
const PRIOR: f64 = 0.1;
/// A lock stays for about so long [s].
const HOLDS: f64 = 60.0;
/// A tyre winds up over a tenth of a metre, at 2.5 m/s in so long: rows that are closer together share the errors of the model [s].
const WINDING: f64 = 0.04;
/// What is less probable than this an interval of 95 % leaves out.
const EXCLUDED: f64 = 0.05;

/// The difference of the wheel speeds in one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turning {
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
    /// Time since the last row [s].
    pub dt: f64,
}

/// Memory of the two models.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Coupling {
    /// Probability that the axles are locked.
    probability: f64,
}

impl Default for Coupling {
    fn default() -> Self {
        Self { probability: PRIOR }
    }
}

impl Coupling {
    /// Takes a row in which the wheels tell something; what is not finite tells nothing.
    pub fn see(&mut self, row: &Turning) {
        let free = row.predicted.max(row.process) + row.noise;
        let locked = row.process + row.noise;
        let evidence =
            row.innovation * row.innovation / free - row.difference * row.difference / locked;
        if !evidence.is_finite() {
            return;
        }
        let odds = exp(-0.5 * (row.dt / WINDING).min(1.0) * evidence);
        let known = self.probability / (self.probability + (1.0 - self.probability) * odds);
        self.probability = known + (PRIOR - known) * (row.dt / HOLDS).min(1.0);
    }

    /// Probability that the axles are locked; 0 where an interval may leave it out.
    pub fn locked(&self) -> f64 {
        let probability = self.probability;
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

    fn row(difference: f64, innovation: f64) -> Turning {
        Turning {
            difference,
            innovation,
            predicted: 3e-6,
            process: 2e-6,
            noise: 8e-6,
            dt: 0.01,
        }
    }

    #[test]
    fn axles_that_turn_apart_are_free_and_those_that_never_do_are_locked() {
        let mut drive = Coupling::default();
        assert_eq!(drive.locked(), PRIOR);
        (0..100).for_each(|_| drive.see(&row(0.02, 0.001)));
        assert_eq!(drive.locked(), 0.0);
        // The lock engages: the filter still expects what it has learnt of the free axles.
        (0..20).for_each(|_| drive.see(&row(0.001, -0.02)));
        assert!(drive.locked() > 0.9);
        // And opens.
        (0..20).for_each(|_| drive.see(&row(0.02, 0.001)));
        assert_eq!(drive.locked(), 0.0);
    }

    #[test]
    fn what_both_models_explain_or_is_no_number_tells_nothing_and_a_lock_is_forgotten() {
        let mut drive = Coupling::default();
        (0..100).for_each(|_| drive.see(&row(0.001, -0.02)));
        let locked = drive;
        drive.see(&row(f64::NAN, 0.0));
        drive.see(&row(0.0, f64::INFINITY));
        assert_eq!(drive, locked);
        // Ten minutes in which both models say the same.
        let same = Turning {
            predicted: 2e-6,
            ..row(0.003, 0.003)
        };
        (0..60_000).for_each(|_| drive.see(&same));
        assert!((drive.probability - PRIOR).abs() < 1e-3);
    }
}
