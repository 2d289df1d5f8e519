//! Turn t of the bucket per turn of the arm, tilt cylinder held: a Bayes estimate on a grid. By this share the lift cylinders carry the part
//! of a load's moment that is due to its distance from the bucket's pin.
//!
//! ```text
//! d(beta) = t d(th);   moment of a mass m, by virtual work:   m [(L cos th + t c cos beta) g' - (L sin th + t c sin beta) a]
//! ```
//! L is the arm's length, c the distance from pin to load; th, beta, g' and a are those of the parent module.
//! t is 1 where the tilt cylinder sits on the arm, and 0 where the linkage holds the bucket level. The Z-bar of most wheel loaders, with
//! its cylinder on the frame, has .1 to .3: there the tilt cylinder carries a part of the load, and the lift cylinders less.
//!
//! An operator who levels the bucket turns it as a linkage does, but mostly while lifting. A linkage acts equally in both directions. So the
//! likelihood of t is the share of upward stretches of arm motion that fit it, times the same share of downward stretches:
//! ```text
//! p(t) ~ prior(t) s_up(t) s_down(t),   s = (n_t + n_0)/(n + n_0)
//! ```
//! n counts stretches, n_t those near t, n_0 is a pseudo-count. A product over stretches would not do, since an operator's habit repeats.
//! n is limited by forgetting, so no share becomes negligible. With the cylinder on the arm an operator must level a full bucket while
//! lifting: for t = 1 a share of the level upward stretches counts as well.
//!
//! At work an operator may level in both directions, so p(1) is at least one half. Lifts for a calibration are without tilting: there the
//! posterior is used as it is.

use core::f64::consts::TAU;

use crate::Quantity;
use crate::math::{exp, sqrt};

/// Directions of the arm.
const UP: usize = 0;
const DOWN: usize = 1;

/// Arm motion of a stretch [rad].
const STRETCH: f64 = 0.15;
/// Pseudo-count n_0 of a direction, and largest number of stretches remembered.
const N_0: f64 = 1.5;
const REMEMBERED: f64 = 40.0;
/// Grid of t: first value, spacing, size, and index of t = 1, the tilt cylinder on the arm.
const FROM: f64 = -0.3;
const STEP: f64 = 0.1;
const SIZE: usize = 15;
const ON_THE_ARM: usize = 13;
/// Prior of t with the cylinder on the frame: mean and standard deviation.
pub(super) const FRAME: f64 = 0.15;
const FRAME_STD: f64 = 0.15;
/// Prior probability of the cylinder on the arm: skid steers, tractor loaders, some small wheel loaders.
const ARMS: f64 = 0.25;
/// Least probability of the cylinder on the arm, at work: an operator may level the bucket in both directions, as a linkage does.
const AT_WORK: f64 = 0.5;
/// Range of t that counts as level, and share of the level upward stretches that count for t = 1: operators who level a bucket by hand.
const LEVEL: [f64; 2] = [-0.15, 0.25];
const HANDS: f64 = 0.3;
/// Standard deviation of t of a linkage from posture to posture.
const POSTURE: f64 = 0.07;

/// Counts of the stretches, from which the posterior of t is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Linkage {
    /// Angles of arm and bucket at the start of the stretch [rad].
    began: Option<[f64; 2]>,
    /// Number of stretches near each t, and of all, upward and downward.
    near: [[f64; SIZE]; 2],
    all: [f64; 2],
}

impl Linkage {
    /// Without stretches.
    pub const NEW: Self = Self {
        began: None,
        near: [[0.0; SIZE]; 2],
        all: [0.0; 2],
    };

    /// Updates with the angles of arm and bucket to the horizontal [rad]; `moves` while the arm does. Returns the estimate at work where a
    /// stretch has ended.
    pub fn see(&mut self, angles: [f64; 2], moves: bool) -> Option<Quantity> {
        if !moves {
            self.began = None;
            return None;
        }
        let began = *self.began.get_or_insert(angles);
        let [lift, bucket] = [angles[0] - began[0], angles[1] - began[1]];
        if lift.abs() < STRETCH {
            return None;
        }
        self.began = Some(angles);
        let direction = if lift > 0.0 { UP } else { DOWN };
        self.count(direction, bucket / lift);
        Some(self.known())
    }

    /// Counts a stretch, shared between the two neighbouring values of the grid.
    fn count(&mut self, direction: usize, turned: f64) {
        let (near, all) = (&mut self.near[direction], &mut self.all[direction]);
        if *all >= REMEMBERED {
            let forgetting = 1.0 - 1.0 / REMEMBERED;
            near.iter_mut().for_each(|n| *n *= forgetting);
            *all *= forgetting;
        }
        *all += 1.0;
        for (i, n) in near.iter_mut().enumerate() {
            *n += (1.0 - (turned - place(i)).abs() / STEP).max(0.0);
        }
    }

    /// Estimate of t at work, where an operator may level the bucket.
    pub fn known(&self) -> Quantity {
        self.posterior(AT_WORK)
    }

    /// Estimate of t where nobody tilted, as in lifts for a calibration.
    pub fn untouched(&self) -> Quantity {
        self.posterior(0.0)
    }

    /// Mean and standard deviation of the posterior, with at least this probability of t = 1.
    fn posterior(&self, least: f64) -> Quantity {
        let (mut sum, mut mean, mut square, mut arm) = (0.0, 0.0, 0.0, 0.0);
        let levelled: f64 = (0..SIZE)
            .filter(|i| (LEVEL[0]..LEVEL[1]).contains(&place(*i)))
            .map(|i| self.near[UP][i])
            .sum();
        for i in 0..SIZE {
            let is_arm = i == ON_THE_ARM;
            let by_hand = if is_arm { HANDS * levelled } else { 0.0 };
            let near = [self.near[UP][i].max(by_hand), self.near[DOWN][i]];
            let fits = |direction: usize| (near[direction] + N_0) / (self.all[direction] + N_0);
            let weight = prior(i) * fits(UP) * fits(DOWN);
            if is_arm {
                arm = weight;
                continue;
            }
            sum += weight;
            mean += weight * place(i);
            square += weight * place(i) * place(i);
        }
        let arm = (arm / (sum + arm)).max(least);
        let frame = (1.0 - arm) / sum;
        let value = frame * mean + arm;
        let between = (frame * square + arm - value * value).max(0.0);
        Quantity {
            value,
            std: sqrt(between + POSTURE * POSTURE),
        }
    }
}

/// Value of t at an index of the grid.
fn place(i: usize) -> f64 {
    FROM + STEP * i as f64
}

/// Prior probability at an index of the grid.
fn prior(i: usize) -> f64 {
    let z = (place(i) - FRAME) / FRAME_STD;
    let frame = STEP / (FRAME_STD * sqrt(TAU)) * exp(-0.5 * z * z);
    let arm = if i == ON_THE_ARM { ARMS } else { 0.0 };
    (1.0 - ARMS) * frame + arm
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten raises and ten lowerings in which the bucket turns by these shares of the arm's turn.
    fn shown(up: f64, down: f64) -> Linkage {
        let mut linkage = Linkage::NEW;
        for _ in 0..10 {
            let (mut lift, mut bucket) = (-0.5, 0.6);
            for (sign, share) in [(1.0, up), (-1.0, down)] {
                for _ in 0..200 {
                    lift += 0.005 * sign;
                    bucket += 0.005 * sign * share;
                    linkage.see([lift, bucket], true);
                }
                // The driver dumps or turns in while the arm stands.
                bucket -= 0.8 * sign;
                linkage.see([lift, bucket], false);
            }
        }
        linkage
    }

    fn seen(up: f64, down: f64) -> Quantity {
        shown(up, down).known()
    }

    #[test]
    fn before_the_first_stretch_a_cylinder_may_sit_on_the_frame_or_on_the_arm() {
        let Quantity { value, std } = Linkage::NEW.known();
        assert!((0.5..0.65).contains(&value), "{value}");
        for turn in [0.0, 1.0] {
            assert!((turn - value).abs() < 1.96 * std, "{value} {std}");
        }
    }

    #[test]
    fn a_linkage_turns_the_bucket_equally_up_and_down_and_is_learnt_where_nobody_tilts() {
        for turn in [0.0, 0.2, 0.3, 1.0] {
            let Quantity { value, std } = shown(turn, turn).untouched();
            assert!(
                (value - turn).abs() < 0.08 && std < 0.2,
                "{turn}: {value} {std}"
            );
        }
    }

    #[test]
    fn at_work_a_hand_may_do_what_a_linkage_does_and_both_cylinders_stay_possible() {
        for turn in [0.0, 0.2, 0.3] {
            let Quantity { value, std } = seen(turn, turn);
            let holds = |truth: f64| (truth - value).abs() < 1.96 * std;
            assert!(holds(turn) && holds(1.0), "{turn}: {value} {std}");
        }
    }

    #[test]
    fn a_hand_that_levels_the_bucket_on_the_way_up_is_no_linkage() {
        for down in [-0.33, 0.63] {
            let Quantity { value, std } = seen(0.0, down);
            assert!((1.0 - value).abs() < 1.96 * std, "{down}: {value} {std}");
            assert!(value.abs() < 1.96 * std, "{down}: {value} {std}");
        }
        // An operator does not hold a bucket still to the arm against a linkage that turns it.
        assert!(seen(0.0, 1.0).value > 0.85);
    }

    #[test]
    fn short_motions_and_a_resting_arm_carry_no_information() {
        let mut linkage = Linkage::NEW;
        for k in 0..1000 {
            linkage.see([0.05 * f64::from(k % 2), 0.3 * f64::from(k % 3)], true);
            linkage.see([0.0, 0.01 * f64::from(k)], false);
        }
        assert_eq!(linkage, Linkage::NEW);
    }
}
