//! A content that may have changed, and what the machine did meanwhile.

use super::row::{Row, Witness};

/// Duration of a detected change after which the content counts as changed [s].
pub(super) const CHANGING: f64 = 0.15;
/// Least duration of dumping, returning and filling again [s].
const ROUND_TRIP: f64 = 4.0;
/// A longer step between two rows is a gap [s].
pub(super) const GAP: f64 = 2.0;

/// Interval in which the content is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Open {
    pub since: f64,
    /// Duration for which the estimator has detected a change, and its first time [s].
    changing: f64,
    pub changed: Option<f64>,
    /// Whether a standing machine has opened its bucket.
    pub by_standing: bool,
    /// Position of the machine, and lowest and highest position since then [rad or m].
    at: f64,
    ends: [f64; 2],
    /// Largest return from the lowest and from the highest position [rad or m].
    back: [f64; 2],
}

impl Open {
    /// Starts at a row, or at the previous row where `dt` between them is a gap.
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

    /// Continues for `dt`, in which a change was detected during `changing` [s].
    pub fn go_on(&mut self, row: &Row, changing: f64, dt: f64) {
        self.changing += changing;
        if changing > 0.0 {
            self.changed.get_or_insert(row.time);
        }
        let travel = row.speed * dt;
        self.at += if travel.is_finite() { travel } else { 0.0 };
        self.ends = if dt > GAP {
            // In a gap the machine may have gone anywhere.
            [f64::NEG_INFINITY, f64::INFINITY]
        } else {
            [self.ends[0].min(self.at), self.ends[1].max(self.at)]
        };
        let back = [self.at - self.ends[0], self.ends[1] - self.at];
        self.back = [self.back[0].max(back[0]), self.back[1].max(back[1])];
    }

    /// Whether the content was known until the estimator detected a change.
    pub fn is_of_a_known_content(&self) -> bool {
        self.changed.is_some_and(|changed| changed <= self.since)
    }

    /// Whether the estimator has detected a change.
    pub fn has_changed(&self) -> bool {
        self.changing >= CHANGING
    }

    /// Whether the machine may have dumped and filled again by now: it has moved as far as to a truck.
    pub fn has_travelled(&self, now: f64, witness: Witness) -> bool {
        let far = self.ends[1] - self.ends[0] >= witness.trip();
        far && now - self.since >= ROUND_TRIP
    }

    /// Whether it has also come back: a swing in one direction brings no second load.
    pub fn has_come_back(&self, now: f64, witness: Witness) -> bool {
        let both = self.back.iter().all(|back| *back >= witness.trip());
        both && self.has_travelled(now, witness)
    }
}
