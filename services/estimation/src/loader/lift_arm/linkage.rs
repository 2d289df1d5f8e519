//! How far the bucket turns with the arm while nobody tilts: the cylinders of the arm carry bucket and load by this share beyond the hinge.
//!
//! ```text
//! d(beta) = t d(th) with the tilt cylinder held;   by virtual work a mass m in the bucket asks for   m [(L cos th + t c cos beta) g' - (L sin th + t c sin beta) a]
//! ```
//! t is 1 where the tilt cylinder sits on the arm, 0 where the linkage keeps the bucket level, .1 to .3 with the Z-bar of most wheel
//! loaders, whose cylinder sits on the frame: there it carries a part of the load, and the lift cylinders less.
//!
//! The angles show t, and so does a hand that levels the bucket: what it does on the way up it does not do on the way down, and a linkage
//! does the same both ways. So the posterior on a grid of t has the share of the stretches that fit it, of the way up times of the way down:
//! ```text
//! p(t) ~ prior(t) s_up(t) s_down(t),   s = (n_t + n_0)/(n + n_0)
//! ```
//! It is a share and no product over stretches: what a hand does in one stretch it does in the next. Stretches are forgotten beyond a number,
//! so no share is less than that of doubt. With a cylinder on the arm a hand must level a full bucket on the way up: for t = 1 a share
//! of the level stretches counts there as well.
//!
//! At work a hand may level both ways, so no angles make the arm less likely than one in two. Who lifts for a calibration tilts nothing,
//! and there the posterior stands as it is.

use core::f64::consts::TAU;

use crate::Quantity;
use crate::math::{exp, sqrt};

/// Ways of the arm.
const UP: usize = 0;
const DOWN: usize = 1;

/// Arm angle of a stretch [rad].
const STRETCH: f64 = 0.15;
/// Stretches of each way that count as doubt, and that are remembered.
const DOUBT: f64 = 1.5;
const REMEMBERED: f64 = 40.0;
/// The grid: from where, how far apart, how many, and which of it is 1, the tilt cylinder on the arm.
const FROM: f64 = -0.3;
const STEP: f64 = 0.1;
const SIZE: usize = 15;
const ON_THE_ARM: usize = 13;
/// Linkages with the cylinder on the frame: mean and standard deviation.
pub(super) const FRAME: f64 = 0.15;
const FRAME_STD: f64 = 0.15;
/// Share of the machines that have the cylinder on the arm: skid steers, loaders of tractors, some small ones.
const ARMS: f64 = 0.25;
/// At work a hand may level the bucket both ways, as a linkage does: no angles make a cylinder on the arm less likely than one in two.
const AT_WORK: f64 = 0.5;
/// What is level on the way up, and how many of the hands that lift with a cylinder on the arm keep it so.
const LEVEL: [f64; 2] = [-0.15, 0.25];
const HANDS: f64 = 0.3;
/// How much a linkage differs from posture to posture.
const POSTURE: f64 = 0.07;

/// How far the bucket turns with the arm, and what the angles have shown of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Linkage {
    /// Angles of arm and bucket where the stretch began [rad].
    began: Option<[f64; 2]>,
    /// Stretches near each t, and all, upward and downward.
    near: [[f64; SIZE]; 2],
    all: [f64; 2],
}

impl Linkage {
    /// Nothing has been seen.
    pub const NEW: Self = Self {
        began: None,
        near: [[0.0; SIZE]; 2],
        all: [0.0; 2],
    };

    /// Takes the angles of arm and bucket to the horizontal [rad]; `moves` while the arm does. What is known with a stretch that ended.
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
        let way = if lift > 0.0 { UP } else { DOWN };
        self.count(way, bucket / lift);
        Some(self.known())
    }

    /// Counts a stretch, shared between the two places of the grid that it lies between.
    fn count(&mut self, way: usize, turned: f64) {
        let (near, all) = (&mut self.near[way], &mut self.all[way]);
        if *all >= REMEMBERED {
            let kept = 1.0 - 1.0 / REMEMBERED;
            near.iter_mut().for_each(|n| *n *= kept);
            *all *= kept;
        }
        *all += 1.0;
        for (i, n) in near.iter_mut().enumerate() {
            *n += (1.0 - (turned - place(i)).abs() / STEP).max(0.0);
        }
    }

    /// What is known of it at work, where a hand may level the bucket.
    pub fn known(&self) -> Quantity {
        self.posterior(AT_WORK)
    }

    /// What is known of it where nobody tilted, as in a lift for a calibration.
    pub fn untouched(&self) -> Quantity {
        self.posterior(0.0)
    }

    /// The tilt cylinder is on the arm at least this likely.
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
            let fits = |way: usize| (near[way] + DOUBT) / (self.all[way] + DOUBT);
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

/// Where a place of the grid is.
fn place(i: usize) -> f64 {
    FROM + STEP * i as f64
}

/// How likely it is before anything was seen.
fn prior(i: usize) -> f64 {
    let z = (place(i) - FRAME) / FRAME_STD;
    let frame = STEP / (FRAME_STD * sqrt(TAU)) * exp(-0.5 * z * z);
    let arm = if i == ON_THE_ARM { ARMS } else { 0.0 };
    (1.0 - ARMS) * frame + arm
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What ten raises and ten lowerings show in which the bucket turns by these shares of the arm's turn.
    fn shown(up: f64, down: f64) -> Linkage {
        let mut linkage = Linkage::NEW;
        for _ in 0..10 {
            let (mut lift, mut bucket) = (-0.5, 0.6);
            for (way, share) in [(1.0, up), (-1.0, down)] {
                for _ in 0..200 {
                    lift += 0.005 * way;
                    bucket += 0.005 * way * share;
                    linkage.see([lift, bucket], true);
                }
                // The driver dumps or turns in while the arm stands.
                bucket -= 0.8 * way;
                linkage.see([lift, bucket], false);
            }
        }
        linkage
    }

    fn seen(up: f64, down: f64) -> Quantity {
        shown(up, down).known()
    }

    #[test]
    fn before_anything_is_seen_a_cylinder_may_sit_on_the_frame_or_on_the_arm() {
        let Quantity { value, std } = Linkage::NEW.known();
        assert!((0.5..0.65).contains(&value), "{value}");
        for turn in [0.0, 1.0] {
            assert!((turn - value).abs() < 1.96 * std, "{value} {std}");
        }
    }

    #[test]
    fn a_linkage_turns_the_bucket_alike_up_and_down_and_is_learnt_where_nobody_tilts() {
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
        // Nobody keeps a bucket still to the arm that a linkage turns.
        assert!(seen(0.0, 1.0).value > 0.85);
    }

    #[test]
    fn bits_of_motion_and_a_resting_arm_tell_nothing() {
        let mut linkage = Linkage::NEW;
        for k in 0..1000 {
            linkage.see([0.05 * f64::from(k % 2), 0.3 * f64::from(k % 3)], true);
            linkage.see([0.0, 0.01 * f64::from(k)], false);
        }
        assert_eq!(linkage, Linkage::NEW);
    }
}
