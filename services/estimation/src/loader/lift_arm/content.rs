//! When the bucket's content may change: while the bucket turns against the ground, which fills or empties it, or the ground takes hold.
//!
//! Carrying and lifting level leave the bucket's angle as it is. A bucket that turns low is in the heap: the ground carries
//! a part of it, and pushes. Whatever carries a bucket that does not turn comes as a jump of the moment (`scale`).

/// Rate of the bucket beyond which it turns [rad/s].
const TURNS: f64 = 0.12;
/// Rate of the arm beyond which it lifts or lowers [rad/s].
const LIFTS: f64 = 0.04;
/// How long the content settles after the bucket turned [s].
const SETTLES: f64 = 0.5;
/// How long the ground holds on after the bucket turned low [s].
const HOLDS: f64 = 0.8;
/// How long after a jump nothing is believed [s].
const AFTER_JUMP: f64 = 0.6;

/// Memory of arm and bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Content {
    /// Time that is left [s].
    settling: f64,
    held: f64,
}

impl Default for Content {
    /// At the start anything may hold the bucket.
    fn default() -> Self {
        Self {
            settling: SETTLES,
            held: HOLDS,
        }
    }
}

/// What arm and bucket do in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    /// The bucket turns, the arm lifts or lowers.
    pub turning: bool,
    pub lifting: bool,
    /// The content still moves.
    pub settling: bool,
    /// The ground may carry the bucket: its pressure says nothing.
    pub held: bool,
    /// The content is not known.
    pub open: bool,
}

impl Content {
    /// Takes the rates of arm and bucket [rad/s]; `low` where the ground is within reach.
    pub fn motion(&mut self, [lift, bucket]: [f64; 2], low: bool, dt: f64) -> Motion {
        let turning = bucket.abs() > TURNS;
        self.settling = (self.settling - dt).max(0.0);
        self.held = (self.held - dt).max(0.0);
        if turning {
            self.settling = SETTLES;
        }
        if turning && low {
            self.held = HOLDS;
        }
        let held = low && self.held > 0.0;
        Motion {
            turning,
            lifting: lift.abs() > LIFTS,
            settling: self.settling > 0.0,
            held,
            open: turning || held || self.settling > 0.0,
        }
    }

    /// The moment jumped: something took hold of the bucket, or let go.
    pub fn touch(&mut self) {
        self.held = self.held.max(AFTER_JUMP);
    }
}
