//! Whether the load sensitivity of the rolling radii can be learnt: only a machine that drives both ways tells it.
//!
//! An acceleration a moves the load m h a/l from axle to axle, and with it the radii, in proportion to a. The slips, which tell
//! the ratio, go with a as well, but change their sign against it when the machine drives backward. Driven one way only, ratio
//! and sensitivity are distinguished by nothing but terms of second order, which brakes, uneven axles and pitching blur: a filter
//! that takes them at their word is wrong and sure. So the sensitivity is what the description says until the machine has been driven
//! both ways, and the interval carries its tolerance; then it is a state that is estimated. After a long drive one way it is considered
//! and not estimated: its variance counts in everything, and neither it nor its value changes (S. F. Schmidt, "Application of
//! state-space methods to navigation problems", 1966).

use crate::math::sqrt;

/// How far back a drive counts [s]: a loader at work turns round more than once in it.
const MEMORY: f64 = 60.0;
/// So long a drive in each direction tells the sensitivity [s].
const TELLS: f64 = 1.0;
/// What a pair of drives leaves open of the sensitivity. With .002 each line of `heft evaluate loader --table honesty` but that of
/// everything at once is wrong for at most .03 of the trusted time, without it for up to .15; with .003 a sound machine is trusted for .65, not .74.
const PAIR_STD: f64 = 0.002;
/// What all pairs leave: errors that change their sign with the direction do not average out. Rolling resistance f moves the load by
/// f r/l against the motion, half a percent of it, which shifts the ratio by about a percent.
/// The size was chosen as that of `SHARED_SLIP` was.
const COMMON_STD: f64 = 0.0005;

/// Whether the machine has been driven both ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BothDirections {
    /// Not yet.
    NotYet,
    /// With this row.
    JustNow,
    /// And of late.
    Recently,
    /// But not of late.
    LongAgo,
}

/// How long the machine has been driven forward and backward, of late [s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Directions {
    forward: f64,
    backward: f64,
    known: bool,
    /// The present drive is forward.
    ahead: bool,
    /// How long it has been [s].
    drive: f64,
    /// Drives of at least [`TELLS`], backward and forward.
    drives: [u32; 2],
}

impl Directions {
    /// Adds `dt` [s] at a speed [m/s]; slower than `slowest` counts as standing.
    pub fn drive(&mut self, speed: f64, slowest: f64, dt: f64) -> BothDirections {
        let kept = 1.0 - (dt / MEMORY).min(1.0);
        self.forward *= kept;
        self.backward *= kept;
        if speed > slowest {
            self.forward += dt;
        } else if speed < -slowest {
            self.backward += dt;
        }
        if speed.abs() > slowest {
            self.count(speed > 0.0, dt);
        }
        let both = self.forward.min(self.backward) > TELLS;
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
        let counted = self.drive >= TELLS;
        self.drive += dt;
        if self.drive >= TELLS && !counted {
            let drives = &mut self.drives[usize::from(ahead)];
            *drives = drives.saturating_add(1);
        }
    }

    /// It has been driven, but not yet both ways.
    pub fn one_way(&self) -> bool {
        !self.known && self.drives != [0; 2]
    }

    /// What is left of a standard deviation `before` of the sensitivity, by manoeuvres of this Birge ratio.
    pub fn left(&self, before: f64, birge: f64) -> f64 {
        if !self.known {
            return before;
        }
        let pairs = f64::from(self.drives[0].min(self.drives[1]));
        let pair = PAIR_STD * birge.max(1.0);
        // n pairs tell it as well as one with the error sqrt(pair^2/n + common^2).
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
    fn only_a_machine_that_has_driven_both_ways_of_late_tells() {
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
    fn each_pair_of_drives_tells_a_part_of_the_sensitivity() {
        let mut driven = Directions::default();
        let mut left = std::vec![driven.left(0.006, 1.0)];
        assert!(!driven.one_way(), "not driven at all");
        let mut ahead = driven;
        (0..500).for_each(|_| _ = ahead.drive(2.0, 0.5, 0.01));
        assert!(ahead.one_way());
        for _ in 0..4 {
            for speed in [2.0, -2.0] {
                (0..500).for_each(|_| _ = driven.drive(speed, 0.5, 0.01));
                // What is too short tells nothing.
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
