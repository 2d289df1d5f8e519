//! What the bucket holds from row to row: the level that is known, whether it may be another by now, and the empty bucket.

use super::level::Level;
use super::open::Open;
use super::row::Row;
use crate::Quantity;
use crate::math::{norm, sqrt};

/// Contents differ if they are further apart than this, in standard deviations of their difference.
const CLEAR: f64 = 2.5;
/// And by more than this, in rated payloads: smaller loads are none.
const LEAST: f64 = 0.08;
/// Differences up to this are none, in rated payloads.
const SAME: f64 = 0.04;
/// Empty bucket before it is weighed: standard deviation in rated payloads.
const EMPTY_STD: f64 = 0.05;
/// A content counts when it has been seen for this long [s].
pub(super) const SETTLED: f64 = 0.3;
/// Speed of a machine that moves [rad/s, m/s].
const MOVING: f64 = 0.05;
/// Share of the variance of a payload that all loads of a machine share, where the estimator does not tell.
const COMMON: f64 = 0.7;

/// The content of the bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Content {
    rated: f64,
    pub level: Option<Level>,
    /// What seems to be another level.
    next: Option<Level>,
    pub open: Option<Open>,
    pub empty: Quantity,
    /// The level is the first one, or lower than the one before.
    may_be_empty: bool,
    moving_since: Option<f64>,
}

/// What a row shows of the content.
pub(super) enum Shown {
    /// Nothing that is sure.
    Nothing,
    /// What is in the bucket is still there.
    Same,
    /// It is another, and stays.
    Another(Level),
}

/// What is known of the load in the bucket.
#[derive(Clone, Copy)]
pub(super) struct Carries {
    /// There is one.
    pub a_load: bool,
    /// It was seen to leave.
    pub leaving: bool,
}

impl Content {
    pub fn new(rated: f64) -> Self {
        Self {
            rated,
            level: None,
            next: None,
            open: None,
            empty: Quantity {
                value: 0.0,
                std: EMPTY_STD * rated,
            },
            may_be_empty: true,
            moving_since: None,
        }
    }

    /// What was seen is of another time; of the empty bucket it is not.
    pub fn forget(&mut self) {
        (self.level, self.next, self.open, self.moving_since) = (None, None, None, None);
    }

    /// Notes whether the machine moves.
    pub fn follow(&mut self, row: &Row) {
        let moves = row.speed.abs() > MOVING;
        self.moving_since = moves.then(|| self.moving_since.unwrap_or(row.time));
    }

    /// The content may be another than before; for how long it has been seen `changing` in this `dt`.
    pub fn doubt(&mut self, row: &Row, changing: f64, dt: f64) -> Open {
        self.next = None;
        let open = self.open.get_or_insert(Open::from(row, dt));
        open.go_on(row, changing, dt);
        *open
    }

    /// The content is weighed.
    pub fn weigh(&mut self, row: &Row, value: Quantity, carries: Carries) -> Shown {
        let common = row.common_std.filter(|c| c.is_finite());
        let common = common.unwrap_or(sqrt(COMMON) * value.std);
        let floor = SAME * self.rated;
        let Some(level) = self.level else {
            let mut first = Level::new(row, value, common, row.time);
            first.left = self.filled(&first);
            (self.level, self.open, self.may_be_empty) = (Some(first), None, true);
            return Shown::Nothing;
        };
        let left = carries.leaving && self.may_have_returned(row);
        if level.holds(value, floor) && !left {
            if self.open.is_some() && !self.is_telling(value, carries.a_load) {
                return Shown::Nothing;
            }
            if let Some(level) = &mut self.level {
                level.join(row, value, common);
            }
            (self.next, self.open) = (None, None);
            return Shown::Same;
        }
        match &mut self.next {
            Some(next) if next.holds(value, floor) => next.join(row, value, common),
            other => {
                let since = self.open.map_or(row.time, |open| open.since);
                let left = other.map_or(since, |next| next.left.min(since));
                *other = Some(Level::new(row, value, common, left));
            }
        }
        self.next
            .filter(|next| next.age() >= SETTLED)
            .map_or(Shown::Nothing, Shown::Another)
    }

    /// The machine has been as far away as a truck is since the content is not known.
    fn may_have_returned(&self, row: &Row) -> bool {
        self.open
            .is_some_and(|open| open.has_travelled(row.time, row.witness))
    }

    /// After the content may have changed: whether a value tells that it has not.
    fn is_telling(&self, value: Quantity, is_loaded: bool) -> bool {
        let close = (2.0 * self.level.map_or(0.0, |l| l.weight.std)).max(SAME * self.rated);
        value.std <= close || is_loaded && self.is_clear(value, self.empty)
    }

    /// Whether one content is more than another beyond doubt.
    pub fn is_clear(&self, more: Quantity, less: Quantity) -> bool {
        let std = norm(&[more.std, less.std]);
        more.value - less.value > (CLEAR * std).max(LEAST * self.rated)
    }

    /// The content is another one from now on.
    pub fn change_to(&mut self, next: Level) {
        let fell = |old: Level| next.weight.kg < old.weight.kg;
        self.may_be_empty = self.level.is_some_and(fell);
        self.level = Some(Level {
            left: self.filled(&next),
            ..next
        });
        (self.next, self.open) = (None, None);
    }

    /// The level, where it is sure that it is still there.
    pub fn known(&self) -> Option<Level> {
        self.level.filter(|_| self.open.is_none())
    }

    /// What is no load is what an empty bucket weighs, where it may be one.
    pub fn learn_empty(&mut self, content: Quantity) {
        if self.may_be_empty && content.std < LEAST * self.rated {
            let std = content.std.max(SAME * self.rated / 2.0);
            self.empty = Quantity { std, ..content };
        }
    }

    /// How long the machine has moved [s].
    pub fn moving(&self, now: f64) -> f64 {
        self.moving_since.map_or(0.0, |since| now - since)
    }

    /// When the bucket was full: when it was weighed; where nothing showed the content before, when the machine set off.
    pub fn filled(&self, next: &Level) -> f64 {
        match (self.open, self.moving_since) {
            (Some(open), Some(since)) => since.clamp(open.since.min(next.from), next.from),
            _ => next.from,
        }
    }
}
