//! What the joints say about the bucket's content: it can change only when they move.

use super::super::drive::Drive;
use super::super::opening::Opening;

/// Joints that have moved this far since the machine stopped may have changed the content [rad].
const MOVED: f64 = 0.03;
/// A bucket that has opened this far is empty unless the motion says otherwise [rad].
const EMPTIED: f64 = 1.15;
/// A standing bucket that has closed this far may have been filled [rad].
const FILLED: f64 = 0.4;
/// Ticks after an opening in which the last of the material may still leave (0.20 s).
const SETTLING: u32 = 20;

/// What is known of the content after a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Content {
    /// As before.
    Unchanged,
    /// What sticks in a bucket that has just been opened wide.
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
    settling: u32,
    /// It has opened wide before.
    opened: bool,
    /// Its angle when it weighed what it held, and the one that did not change while it lost that \[rad\].
    weighed: f64,
    frozen: f64,
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
            settling: 0,
            opened: false,
            weighed: f64::NAN,
            frozen: f64::NAN,
        }
    }

    /// One tick; `share` of new angles in the smoothed ones. Where the load is weighed, which tells whether the bucket `digs`,
    /// it changes only then, or where the bucket opens.
    pub(super) fn step(
        &mut self,
        drive: &Drive,
        share: f64,
        standing: bool,
        digs: Option<bool>,
    ) -> Content {
        if !drive.seen {
            // What the joints do meanwhile may fill or empty the bucket.
            *self = Self::new(self.opening.threshold());
            return Content::Unknown;
        }
        self.rate = self.opening.step(drive);
        let was_settling = self.settling > 0;
        self.settling = if self.is_open() {
            SETTLING
        } else {
            self.settling.saturating_sub(1)
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
        let fixed = digs.is_some_and(|digs| !digs && self.settling == 0);
        if fixed && was_settling && self.emptied {
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
            (self.emptied, self.opened) = (true, true);
            self.most = bucket;
            self.least = bucket - EMPTIED;
        }
        if standing && self.most - bucket > FILLED {
            self.emptied = false;
            self.least = bucket;
            self.most = bucket + FILLED;
        }
    }

    /// It weighs what it holds, at this angle \[rad\].
    pub(super) fn keeps(&mut self, angle: f64) {
        self.weighed = angle;
        if angle != self.frozen {
            self.frozen = f64::NAN;
        }
    }

    /// It weighs less than it did, in the air. One that opened before, and has not turned while it lost that, has a frozen angle.
    pub(super) fn loses(&mut self, angle: f64) {
        if self.opened && angle == self.weighed {
            self.frozen = angle;
        }
    }

    /// Its angle still repeats the value at which what it held has changed \[rad\].
    pub(super) fn is_frozen(&self, angle: f64) -> bool {
        angle == self.frozen
    }

    /// The bucket opens, or has just done so.
    pub(super) fn is_open(&self) -> bool {
        self.opening.is_open()
    }

    /// The last of the material may still be leaving.
    pub(super) fn is_settling(&self) -> bool {
        self.settling > 0
    }

    /// The joints have moved since the machine stopped.
    pub(super) fn is_unlocked(&self) -> bool {
        self.unlocked
    }

    /// Rate of opening, 0 while the bucket does not open [rad/s].
    pub(super) fn opening_rate(&self) -> f64 {
        self.rate
    }

    /// The bucket was opened wide, and has not been filled since.
    pub(super) fn is_emptied(&self) -> bool {
        self.emptied && !self.is_open() && self.settling == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A standing bucket that opens wide if it `opens`, weighs what is left, and turns by this while it loses that [rad].
    fn freezes(opens: bool, turns: f64) -> bool {
        let mut bucket = Bucket::new(0.5);
        let turn = |bucket: &mut Bucket, angle: f64| {
            let drive = Drive {
                period: 0.01,
                posture: [0.6, -1.8, angle],
                seen: true,
                ..Drive::default()
            };
            bucket.step(&drive, 0.2, true, Some(false));
        };
        let open = if opens { -0.2 } else { -1.5 };
        let opening = |k: u32| -1.5 + (open + 1.5) * f64::from(k.min(300)) / 300.0;
        (0..400).for_each(|k| turn(&mut bucket, opening(k)));
        let angle = opening(400);
        bucket.keeps(angle);
        bucket.loses(angle + turns);
        let freezes = bucket.is_frozen(angle + turns);
        // It turns, and is back there later.
        assert!(!bucket.is_frozen(angle + turns + 1e-6));
        bucket.keeps(angle + turns + 1e-6);
        assert!(!bucket.is_frozen(angle + turns));
        freezes
    }

    #[test]
    fn a_bucket_that_opened_before_and_loses_its_load_without_turning_is_frozen() {
        assert!(freezes(true, 0.0));
        assert!(!freezes(true, 0.01), "it turned");
        assert!(!freezes(false, 0.0), "a grapple: it never opened");
    }
}
