//! A load suspended from a hook: no bucket opens where it leaves. It is present while it swings, and is set down where the machine stops.

use super::content::SETTLED;
use super::open::Open;
use super::row::Row;

/// Least duration of setting down and taking up the next load [s].
const SETS_DOWN: f64 = 4.0;

/// Observations of a suspended load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Hook {
    /// Time since which it swings, and duration of swinging so far \[s\].
    since: Option<f64>,
    swung: f64,
    /// Duration for which the machine has stood [s].
    stood: f64,
    /// Travel of the machine since the last load left.
    way: Option<Open>,
}

impl Hook {
    /// Notes that a load has left: swinging on the return travel is no load.
    pub fn left(&mut self, row: &Row) {
        self.way = Some(Open::from(row, 0.0));
    }

    /// Takes a row, `dt` after the previous one. Where a load is set down now, returns since when it was on the hook, and when the machine
    /// stopped.
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
