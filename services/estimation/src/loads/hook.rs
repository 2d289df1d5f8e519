//! A load that hangs from a hook: no bucket opens where it leaves. It was there while it swung, and is set down where the machine stops.

use super::content::SETTLED;
use super::open::Open;
use super::row::Row;

/// Setting down, and taking up the next one, take so long at least [s].
const SETS_DOWN: f64 = 4.0;

/// What was seen of a load that hangs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Hook {
    /// Since when it swings, and for how long it was seen to \[s\].
    since: Option<f64>,
    swung: f64,
    /// How long the machine has stood [s].
    stood: f64,
    /// Where the machine has been since the last load left.
    way: Option<Open>,
}

impl Hook {
    /// A load has left: what swings on the way back is none.
    pub fn left(&mut self, row: &Row) {
        self.way = Some(Open::from(row, 0.0));
    }

    /// Takes a row, `dt` after the one before. Since when there was a load on the hook and when the machine stopped, where it is set
    /// down now.
    pub fn step(&mut self, row: &Row, dt: f64) -> Option<[f64; 2]> {
        self.stood = if row.moves() { 0.0 } else { self.stood + dt };
        if let Some(way) = &mut self.way {
            way.go_on(row, 0.0, dt);
        }
        if row.hangs && row.moves() {
            self.since.get_or_insert(row.time);
            self.swung += dt;
        }
        let since = self.since.filter(|_| self.stood >= SETS_DOWN)?;
        let is_back = self
            .way
            .is_none_or(|way| way.has_come_back(row.time, row.witness));
        let is_load = self.swung >= SETTLED && is_back;
        (self.since, self.swung) = (None, 0.0);
        is_load.then_some([since, row.time - self.stood])
    }
}
