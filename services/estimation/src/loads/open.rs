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
    /// For how long the estimator has seen it change [s].
    changing: f64,
    /// Where the machine is, and the ends of where it has been since then [rad or m].
    at: f64,
    ends: [f64; 2],
}

impl Open {
    /// From a row on, or from the one before where nothing is known of the `dt` between them.
    pub fn from(row: &Row, dt: f64) -> Self {
        Self {
            since: row.time - if dt > GAP { dt } else { 0.0 },
            changing: 0.0,
            at: 0.0,
            ends: [0.0; 2],
        }
    }

    /// Goes on for `dt`, in which the content was seen `changing` for so long.
    pub fn go_on(&mut self, row: &Row, changing: f64, dt: f64) {
        self.changing += changing;
        let way = row.speed * dt;
        self.at += if way.is_finite() { way } else { 0.0 };
        self.ends = [self.ends[0].min(self.at), self.ends[1].max(self.at)];
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
}
