//! Probability of a locked centre drive. Both axles then turn at the same speed, and the reported torques are not those of the
//! axles.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | d | `difference` | measured difference of the wheel speeds, w_f - w_r | rad/s |
//! | y, S | `innovation`, `predicted` | its innovation in the filter, and the variance of its prediction | |
//! | Q | `process` | part of S by process noise: both models have it | rad^2/s^2 |
//! | R | `noise` | variance of its measurement | rad^2/s^2 |
//! | L | - | log odds of locked against free; stored as `probability` | 1 |
//! | w | - | length of the row over [`WINDING`], at most 1 | 1 |
//!
//! Bayes' rule weighs two models of the same data. Free axles, as in the filter: y ~ N(0, S + R). Locked axles: d ~ N(0, Q + R),
//! whatever the torques and radii. A lock engages and opens at random.
//! ```text
//! L += w/2 [y^2/(S + R) - d^2/(Q + R)]
//! ```
//! Rolling radii that differ by a thousandth turn free axles apart by several standard deviations a row. So do a torque, and load
//! that moves between the axles. The filter can explain locked axles by radii, ratio and height that cancel exactly, but not in
//! every row.
//!
//! The determinants of S + R and Q + R are left out. They express how improbable such a cancellation is. But axles with equal
//! tyres, half the load and half the torque each are common, and a load that may have changed widens S at every stop.

use crate::math::exp;

/// Probability of a lock before the first row, and its long-term mean. It exceeds what a 95 % interval may leave out. So no torque
/// of an axle is trusted until the axles have turned apart.
const PRIOR: f64 = 0.1;
/// Typical duration of a lock [s]: time constant with which the probability returns to [`PRIOR`].
const HOLDS: f64 = 60.0;
/// Correlation time of the model errors [s]: a tyre winds up over a tenth of a metre, at 2.5 m/s in this time.
const WINDING: f64 = 0.04;
/// Probability below which a 95 % interval may leave a hypothesis out.
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
    /// Part of the predicted variance by process noise [rad^2/s^2].
    pub process: f64,
    /// Variance of its measurement [rad^2/s^2].
    pub noise: f64,
    /// Time since the last row [s].
    pub dt: f64,
}

/// Odds of the two models.
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
    /// Updates the probability with a row in which both wheels count; ignores a row that is not finite.
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
    fn equally_likely_and_non_finite_rows_carry_no_information_and_a_lock_is_forgotten() {
        let mut drive = Coupling::default();
        (0..100).for_each(|_| drive.see(&row(0.001, -0.02)));
        let locked = drive;
        drive.see(&row(f64::NAN, 0.0));
        drive.see(&row(0.0, f64::INFINITY));
        assert_eq!(drive, locked);
        // Ten minutes in which both models are equally likely.
        let same = Turning {
            predicted: 2e-6,
            ..row(0.003, 0.003)
        };
        (0..60_000).for_each(|_| drive.see(&same));
        assert!((drive.probability - PRIOR).abs() < 1e-3);
    }
}
