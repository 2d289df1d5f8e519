//! Changes of the bucket's content by the joint angles: it can change only when joints move.

use super::super::drive::Drive;
use super::super::opening::Opening;

/// Motion of a joint since the machine stopped that may have changed the content [rad].
const MOVED: f64 = 0.03;
/// Opening by which a bucket counts as empty, unless the motion contradicts [rad].
const EMPTIED: f64 = 1.15;
/// Closing by which a standing bucket may have been filled [rad].
const FILLED: f64 = 0.4;
/// Ticks after an opening in which the last material may still leave as fast as before (0.20 s).
const SETTLING: u32 = 20;
/// Ticks after an opening in which a bucket that still weighs something may be losing it: wet soil slides out slowly (2 s).
const SLIDING: u32 = 200;

/// Knowledge of the content after a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Content {
    /// As before.
    Unchanged,
    /// What sticks in a bucket just opened wide.
    Emptied,
    /// Anything from empty to full.
    Unknown,
}

/// Follows the joints.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Bucket {
    opening: Opening,
    rate: f64,
    posture: Option<[f64; 3]>,
    /// Posture in which the machine stopped.
    stopped: Option<[f64; 3]>,
    unlocked: bool,
    /// Least and largest bucket angle since the last emptying or filling [rad].
    least: f64,
    most: f64,
    emptied: bool,
    /// Ticks since the bucket last opened.
    closed: u32,
}

impl Bucket {
    pub(super) fn new(opening_rate: f64) -> Self {
        Self {
            opening: Opening::new(opening_rate),
            rate: 0.0,
            posture: None,
            stopped: None,
            unlocked: true,
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            emptied: false,
            closed: u32::MAX,
        }
    }

    /// Processes one tick; `share`: weight of new angles in the smoothed ones. Where the load is weighed, it is known whether the bucket
    /// `digs`. The content then changes only while it digs or opens.
    pub(super) fn step(
        &mut self,
        drive: &Drive,
        share: f64,
        standing: bool,
        digs: Option<bool>,
    ) -> Content {
        if !drive.seen {
            // Unseen joint motion may fill or empty the bucket.
            *self = Self::new(self.opening.threshold());
            return Content::Unknown;
        }
        self.rate = self.opening.step(drive);
        self.closed = if self.is_open() {
            0
        } else {
            self.closed.saturating_add(1)
        };
        let before = self.posture.unwrap_or(drive.posture);
        let now = core::array::from_fn(|i| before[i] + share * (drive.posture[i] - before[i]));
        self.posture = Some(now);
        self.follow(now[2], standing);
        if !standing {
            self.stopped = None;
            self.unlocked = false;
            return Content::Unchanged;
        }
        let stopped = *self.stopped.get_or_insert(now);
        self.unlocked |= (0..3).any(|i| (now[i] - stopped[i]).abs() > MOVED);
        let fixed = digs.is_some_and(|digs| !digs && !self.is_settling());
        if fixed && self.closed == SETTLING && self.emptied {
            Content::Emptied
        } else if self.unlocked && !fixed {
            Content::Unknown
        } else {
            Content::Unchanged
        }
    }

    fn follow(&mut self, bucket: f64, standing: bool) {
        self.least = self.least.min(bucket);
        self.most = self.most.max(bucket);
        if bucket - self.least > EMPTIED {
            self.emptied = true;
            self.most = bucket;
            self.least = bucket - EMPTIED;
        }
        if standing && self.most - bucket > FILLED {
            self.emptied = false;
            self.least = bucket;
            self.most = bucket + FILLED;
        }
    }

    /// Returns whether the bucket opens or has just done so.
    pub(super) fn is_open(&self) -> bool {
        self.opening.is_open()
    }

    /// Returns whether the bucket opens, or material may still leave as fast as while it did.
    pub(super) fn is_settling(&self) -> bool {
        self.closed < SETTLING
    }

    /// Returns whether the rest may still slide out of an emptied bucket.
    pub(super) fn may_slide(&self) -> bool {
        self.is_emptied() && self.closed < SLIDING
    }

    /// Returns whether joints have moved since the machine stopped.
    pub(super) fn is_unlocked(&self) -> bool {
        self.unlocked
    }

    /// Rate of opening, 0 while the bucket does not open [rad/s].
    pub(super) fn opening_rate(&self) -> f64 {
        self.rate
    }

    /// Returns whether the bucket was opened wide and has not been filled since.
    pub(super) fn is_emptied(&self) -> bool {
        self.emptied && !self.is_settling()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_may_slide_out_of_an_emptied_bucket_for_two_seconds_after_its_opening() {
        let mut bucket = Bucket::new(0.3);
        let mut may_slide = |angle: f64| {
            let drive = Drive {
                period: 0.01,
                posture: [0.6, -1.8, angle],
                seen: true,
                ..Drive::default()
            };
            bucket.step(&drive, 1.0, false, None);
            bucket.may_slide()
        };
        assert!(!may_slide(-1.5), "it has not opened");
        let opening = (0..100).map(|k| -1.5 + 0.015 * f64::from(k));
        assert!(opening.into_iter().all(|angle| !may_slide(angle)));
        let lasts = (0..300).filter(|_| may_slide(0.0)).count();
        assert_eq!(lasts as u32, SLIDING - SETTLING);
    }
}
