//! A content that is not known for a while: what may have happened to it meanwhile.

use super::row::{Row, Witness};

/// The content changes when the estimator has said so for this long [s].
pub(super) const CHANGING: f64 = 0.15;
/// Dumping, the way back and filling again take so long at least [s].
const ROUND_TRIP: f64 = 4.0;
/// A longer step between rows is a gap [s].
pub(super) const GAP: f64 = 2.0;

/// The content is not known since then.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Open {
    pub since: f64,
    /// For how long the estimator has seen it change, and since when [s].
    changing: f64,
    pub changed: Option<f64>,
    /// A standing machine has opened its bucket.
    pub by_standing: bool,
    /// Where the machine is, and the ends of where it has been since then [rad or m].
    at: f64,
    ends: [f64; 2],
    /// The furthest that it has come back from an end, from the lower and from the upper one [rad or m].
    back: [f64; 2],
}

impl Open {
    /// From a row on, or from the one before where nothing is known of the `dt` between them.
    pub fn from(row: &Row, dt: f64) -> Self {
        Self {
            since: row.time - if dt > GAP { dt } else { 0.0 },
            changing: 0.0,
            changed: None,
            by_standing: false,
            at: 0.0,
            ends: [0.0; 2],
            back: [0.0; 2],
        }
    }

    /// Goes on for `dt`, in which the content was seen `changing` for so long.
    pub fn go_on(&mut self, row: &Row, changing: f64, dt: f64) {
        self.changing += changing;
        if changing > 0.0 {
            self.changed.get_or_insert(row.time);
        }
        let way = row.speed * dt;
        self.at += if way.is_finite() { way } else { 0.0 };
        self.ends = [self.ends[0].min(self.at), self.ends[1].max(self.at)];
        let back = [self.at - self.ends[0], self.ends[1] - self.at];
        self.back = [self.back[0].max(back[0]), self.back[1].max(back[1])];
    }

    /// The estimator has seen the content change.
    pub fn has_changed(&self) -> bool {
        self.changing >= CHANGING
    }

    /// Whether the machine may have dumped and filled again by now: it was as far away as a truck is.
    pub fn has_travelled(&self, now: f64, witness: Witness) -> bool {
        let far = self.ends[1] - self.ends[0] >= witness.trip();
        far && now - self.since >= ROUND_TRIP
    }

    /// Whether it has been there and come back: a swing that goes on one way brings no second load.
    pub fn has_come_back(&self, now: f64, witness: Witness) -> bool {
        let both = self.back.iter().all(|back| *back >= witness.trip());
        both && self.has_travelled(now, witness)
    }
}
