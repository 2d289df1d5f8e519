//! Whether the load sensitivity of the rolling radii is observable, which takes driving in both directions.
//!
//! An acceleration a moves the load m h a/l between the axles, and changes the radii in proportion to a. The slips, which determine
//! the ratio, are proportional to a as well, but change their sign relative to it when the machine drives backward. In one
//! direction, only terms of second order distinguish ratio and sensitivity. Brakes, uneven axles and pitching blur these terms, and
//! a filter that uses them is overconfident.
//!
//! So the sensitivity keeps its stated value until the machine has driven in both directions, and the interval includes its
//! tolerance. From then on it is an estimated state. After a long drive in one direction it is a consider parameter: its variance
//! enters every update, and neither its value nor its variance changes (S. F. Schmidt, "Application of state-space methods to
//! navigation problems", 1966).

use crate::math::sqrt;

/// Time constant with which driving times fade [s]: a loader at work turns round more than once in it.
const MEMORY: f64 = 60.0;
/// Least duration of a drive that carries information about the sensitivity [s], in each direction.
const LEAST_DRIVE: f64 = 1.0;
/// Standard deviation of the sensitivity after a pair of drives. With .002, each line of `heft evaluate loader --table honesty` is
/// wrong for at most .03 of the trusted time, except that of everything at once. Without it, they are wrong for up to .15. With
/// .003 a sound machine is trusted for .65, not .74.
const PAIR_STD: f64 = 0.002;
/// Standard deviation common to all pairs: errors that change their sign with the direction do not average out. Rolling resistance
/// f moves the load by f r/l against the motion, half a percent of it, which shifts the ratio by about a percent. The size was
/// chosen as that of `SHARED_SLIP` was.
const COMMON_STD: f64 = 0.0005;

/// Whether the machine has driven in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BothDirections {
    /// Not yet.
    NotYet,
    /// Since this row.
    JustNow,
    /// Yes, and recently.
    Recently,
    /// Yes, but not recently.
    LongAgo,
}

/// Driving times forward and backward, which fade with `MEMORY` [s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Directions {
    forward: f64,
    backward: f64,
    known: bool,
    /// The present drive is forward.
    ahead: bool,
    /// Duration of the present drive [s].
    drive: f64,
    /// Number of drives of at least [`LEAST_DRIVE`], backward and forward.
    drives: [u32; 2],
}

impl Directions {
    /// Adds `dt` [s] at `speed` [m/s]; below `slowest` [m/s] the machine stands.
    pub fn drive(&mut self, speed: f64, slowest: f64, dt: f64) -> BothDirections {
        let remaining = 1.0 - (dt / MEMORY).min(1.0);
        self.forward *= remaining;
        self.backward *= remaining;
        if speed > slowest {
            self.forward += dt;
        } else if speed < -slowest {
            self.backward += dt;
        }
        if speed.abs() > slowest {
            self.count(speed > 0.0, dt);
        }
        let both = self.forward.min(self.backward) > LEAST_DRIVE;
        let before = self.known;
        self.known |= both;
        match (before, both) {
            (false, false) => BothDirections::NotYet,
            (false, true) => BothDirections::JustNow,
            (true, true) => BothDirections::Recently,
            (true, false) => BothDirections::LongAgo,
        }
    }

    fn count(&mut self, ahead: bool, dt: f64) {
        if self.ahead != ahead {
            (self.ahead, self.drive) = (ahead, 0.0);
        }
        let counted = self.drive >= LEAST_DRIVE;
        self.drive += dt;
        if self.drive >= LEAST_DRIVE && !counted {
            let drives = &mut self.drives[usize::from(ahead)];
            *drives = drives.saturating_add(1);
        }
    }

    /// Whether the machine has driven, but not yet in both directions.
    pub fn one_way(&self) -> bool {
        !self.known && self.drives != [0; 2]
    }

    /// Standard deviation of the sensitivity that remains of the prior's `before`, with manoeuvres of this Birge ratio.
    pub fn left(&self, before: f64, birge: f64) -> f64 {
        if !self.known {
            return before;
        }
        let pairs = f64::from(self.drives[0].min(self.drives[1]));
        let pair = PAIR_STD * birge.max(1.0);
        // n pairs are as good as one measurement with the error sqrt(pair^2/n + common^2).
        let information = before * before * pairs / (pair * pair + pairs * COMMON_STD * COMMON_STD);
        before / sqrt(1.0 + information)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn both_directions_count_while_they_are_recent() {
        let mut driven = Directions::default();
        let mut drive = |speed: f64, time: f64| -> Vec<BothDirections> {
            let rows = 0..(time * 100.0) as u32;
            rows.map(|_| driven.drive(speed, 0.5, 0.01)).collect()
        };
        assert!(
            drive(3.0, 600.0)
                .iter()
                .all(|b| *b == BothDirections::NotYet)
        );
        assert!(
            drive(-3.0, 0.9)
                .iter()
                .all(|b| *b == BothDirections::NotYet)
        );
        let turned = drive(-3.0, 2.0);
        assert_eq!(
            turned
                .iter()
                .filter(|b| **b == BothDirections::JustNow)
                .count(),
            1
        );
        assert!(
            drive(0.0, 10.0)
                .iter()
                .all(|b| *b == BothDirections::Recently)
        );
        assert_eq!(drive(3.0, 200.0).last(), Some(&BothDirections::LongAgo));
        assert_eq!(drive(-3.0, 4.0).last(), Some(&BothDirections::Recently));
    }

    #[test]
    fn each_pair_of_drives_reduces_the_deviation_of_the_sensitivity() {
        let mut driven = Directions::default();
        let mut left = std::vec![driven.left(0.006, 1.0)];
        assert!(!driven.one_way(), "not driven at all");
        let mut ahead = driven;
        (0..500).for_each(|_| _ = ahead.drive(2.0, 0.5, 0.01));
        assert!(ahead.one_way());
        for _ in 0..4 {
            for speed in [2.0, -2.0] {
                (0..500).for_each(|_| _ = driven.drive(speed, 0.5, 0.01));
                // A drive that is too short does not count.
                (0..50).for_each(|_| _ = driven.drive(-speed, 0.5, 0.01));
            }
            left.push(driven.left(0.006, 1.0));
        }
        let expected = |n: f64| 0.006 / (1.0 + 36.0 * n / (4.0 + 0.25 * n)).sqrt();
        for (n, left) in left.into_iter().enumerate() {
            assert!((left - expected(n as f64)).abs() < 1e-12, "{n}: {left}");
        }
        assert!(!driven.one_way());
        assert!(driven.left(0.006, 2.0) > driven.left(0.006, 1.0));
        assert_eq!(driven.left(0.0, 1.0), 0.0);
    }
}
