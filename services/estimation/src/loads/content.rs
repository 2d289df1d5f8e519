//! Content of the bucket from row to row: the known level, whether it may have changed, and the empty bucket.

use super::level::{Level, log_likelihood};
use super::open::{CHANGING, Open};
use super::row::Row;
use crate::Quantity;
use crate::math::norm;

/// Contents differ if they are further apart than this, in standard deviations of their difference,
const CLEAR: f64 = 2.5;
/// and by more than this, in rated payloads: no load is smaller.
pub(super) const LEAST: f64 = 0.08;
/// Differences up to this count as none, in rated payloads.
const SAME: f64 = 0.04;
/// Standard deviation of the empty bucket before it is weighed, in rated payloads.
const EMPTY_STD: f64 = 0.05;
/// Duration after which a content counts as constant [s].
pub(super) const SETTLED: f64 = 0.3;
/// A load: mean and standard deviation in rated payloads. Buckets are filled from a tenth to slightly more than the rated payload.
const LOAD: Quantity = Quantity {
    value: 0.6,
    std: 0.25,
};
/// Logarithm of the odds at which one of two hypotheses is accepted: 3 to 1.
const DECIDED: f64 = 1.1;
/// Logarithm of the prior odds that a standing machine that opens its bucket dumps a load: 2 to 1.
const OPENED_FOR_A_LOAD: f64 = 0.7;
/// Standard deviation of a load that nothing weighed, in rated payloads: that of a payload in a machine file.
const UNKNOWN: f64 = 0.4;
/// Ratio of a payload's variance to the smallest so far at which the estimator has reset it: the content that follows is another.
const OPENED: f64 = 1.5;

/// The content of the bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Content {
    rated: f64,
    pub level: Option<Level>,
    /// Candidate for another level.
    next: Option<Level>,
    pub open: Option<Open>,
    /// Best estimate of a content that is not weighed, from rows in motion.
    rough: Option<Level>,
    /// The same, from before the estimator detected a change.
    unchanged: Option<Level>,
    pub empty: Quantity,
    /// The level is the first one, or lower than the previous one.
    may_be_empty: bool,
    moving_since: Option<f64>,
    /// The estimator detects a change, and did not in the previous row.
    begins_to_change: bool,
    changes: bool,
    /// Duration of the detected change, while the machine stands [s].
    opening: f64,
    /// Path of the machine since the level was first seen [rad or m].
    path: f64,
}

/// Result of a row for the content.
pub(super) enum Shown {
    /// Not conclusive.
    Nothing,
    /// The content is unchanged.
    Same,
    /// The content is another, and constant.
    Another(Level),
}

/// State of the load in the bucket.
#[derive(Clone, Copy)]
pub(super) struct Carries {
    /// There is a load.
    pub a_load: bool,
    /// Its leaving has been detected.
    pub leaving: bool,
}

impl Content {
    pub fn new(rated: f64) -> Self {
        Self {
            rated,
            level: None,
            next: None,
            open: None,
            rough: None,
            unchanged: None,
            empty: Quantity {
                value: 0.0,
                std: EMPTY_STD * rated,
            },
            may_be_empty: true,
            moving_since: None,
            begins_to_change: false,
            changes: false,
            opening: 0.0,
            path: 0.0,
        }
    }

    /// Discards the contents of another time; the empty bucket stays known.
    pub fn forget(&mut self) {
        (self.level, self.next, self.open, self.moving_since) = (None, None, None, None);
        (self.rough, self.unchanged) = (None, None);
    }

    /// Updates whether the machine moves, and whether it opens its bucket while it stands.
    pub fn follow(&mut self, row: &Row, dt: f64) {
        self.begins_to_change = row.changing && !self.changes;
        self.changes = row.changing;
        self.opening = if row.changing && !row.moves() {
            self.opening + dt
        } else {
            0.0
        };
        let path = row.speed.abs() * dt;
        self.path += if path.is_finite() { path } else { 0.0 };
        let moved = self.moving(row.time);
        if !row.moves() && moved > 0.0 && moved < SETTLED {
            // Digging shakes the machine: a short motion carries no load.
            let is_of_it = |rough: &Level| rough.from >= row.time - moved;
            self.rough = self.rough.filter(|rough| !is_of_it(rough));
        }
        self.moving_since = row.moves().then(|| self.moving_since.unwrap_or(row.time));
        if let Some(open) = self.open.as_mut().filter(|_| self.opening >= CHANGING) {
            open.by_standing = true;
        }
    }

    /// Notes that the content may have changed; a change was detected during `changing` of this `dt` [s].
    pub fn doubt(&mut self, row: &Row, changing: f64, dt: f64) -> Open {
        self.next = None;
        let open = self.open.get_or_insert(Open::from(row, dt));
        open.go_on(row, changing, dt);
        *open
    }

    /// Takes a weighed content.
    pub fn weigh(&mut self, row: &Row, value: Quantity, carries: Carries) -> Shown {
        let floor = SAME * self.rated;
        let Some(level) = self.level else {
            let mut first = Level::new(row, value, row.time);
            first.left = self.filled(&first);
            (self.level, self.open, self.may_be_empty) = (Some(first), None, true);
            self.path = 0.0;
            return Shown::Nothing;
        };
        let left = carries.leaving && self.may_have_returned(row);
        let opened = self.open.is_some_and(|open| open.by_standing) && carries.a_load;
        let prior = if opened { OPENED_FOR_A_LOAD } else { 0.0 };
        let odds = self
            .open
            .map_or(-DECIDED, |_| self.exchanged(value) + prior);
        if level.holds(value, floor) && !left && odds < DECIDED {
            let is_decisive = odds <= -DECIDED && self.is_decisive(value, carries.a_load);
            if self.open.is_some() && !is_decisive {
                return Shown::Nothing;
            }
            let is_at_a_truck = self.path >= row.witness.trip();
            if let Some(level) = &mut self.level {
                level.may_lack_a_part |= carries.leaving && is_at_a_truck;
                level.join(row, value);
            }
            (self.next, self.open) = (None, None);
            (self.rough, self.unchanged) = (None, None);
            return Shown::Same;
        }
        match &mut self.next {
            Some(next) if next.holds(value, floor) => next.join(row, value),
            other => {
                let since = self.open.map_or(row.time, |open| open.since);
                let left = other.map_or(since, |next| next.left.min(since));
                *other = Some(Level::new(row, value, left));
            }
        }
        self.next
            .filter(|next| next.age() >= SETTLED)
            .map_or(Shown::Nothing, Shown::Another)
    }

    /// Whether the machine has moved as far as to a truck since the content became unknown.
    fn may_have_returned(&self, row: &Row) -> bool {
        self.open
            .is_some_and(|open| open.has_travelled(row.time, row.witness))
    }

    /// Whether a value is accurate enough to confirm that a content that may have changed has not.
    fn is_decisive(&self, value: Quantity, is_loaded: bool) -> bool {
        let close = (2.0 * self.level.map_or(0.0, |l| l.weight.std)).max(SAME * self.rated);
        value.std <= close || is_loaded && self.is_clear(value, self.empty)
    }

    /// Whether a content is more likely a load than the rest in an empty bucket.
    pub fn is_likely(&self, content: Quantity) -> bool {
        self.odds(content) > 0.0
    }

    /// Logarithm of the odds of a load against an empty bucket. Less than the last rest is a smaller rest.
    fn odds(&self, content: Quantity) -> f64 {
        let value = content.value.max(self.empty.value);
        let content = Quantity { value, ..content };
        log_likelihood(content, self.any_load()) - log_likelihood(content, self.empty)
    }

    fn any_load(&self) -> Quantity {
        Quantity {
            value: LOAD.value * self.rated,
            std: LOAD.std * self.rated,
        }
    }

    /// Logarithm of the odds that the content was exchanged, against an unchanged level, from a value that is weighed after it may have
    /// changed. Exchanged: a load was dumped, or an empty bucket filled.
    pub fn exchanged(&self, value: Quantity) -> f64 {
        let Some(level) = self.level.map(|level| level.weight.quantity()) else {
            return 0.0;
        };
        let other = if self.is_likely(level) {
            self.empty
        } else {
            self.any_load()
        };
        // Rows of one filter share their errors: the larger standard deviation bounds their difference.
        let std = value.std.max(level.std);
        let same = log_likelihood(Quantity { std, ..value }, Quantity { std: 0.0, ..level });
        log_likelihood(value, other) - same
    }

    /// Whether one content is significantly more than another.
    pub fn is_clear(&self, more: Quantity, less: Quantity) -> bool {
        let std = norm(&[more.std, less.std]);
        more.value - less.value > (CLEAR * std).max(LEAST * self.rated)
    }

    /// Replaces the level.
    pub fn change_to(&mut self, next: Level) {
        let fell = |old: Level| next.weight.kg < old.weight.kg;
        self.may_be_empty = self.level.is_some_and(fell);
        self.level = Some(Level {
            left: self.filled(&next),
            ..next
        });
        (self.next, self.open, self.path) = (None, None, 0.0);
        (self.rough, self.unchanged) = (None, None);
    }

    /// Takes a content that is not weighed, while the machine moves: improves the estimate of a load that leaves later.
    pub fn notice(&mut self, row: &Row, value: Quantity) {
        if self.begins_to_change {
            self.unchanged = self.rough;
        }
        if row.changing && self.open.is_some_and(|open| open.is_of_a_known_content()) {
            // A weighed content is leaving: less and less of it is seen.
            return;
        }
        let opened =
            |best: Level| value.std * value.std > OPENED * best.weight.std * best.weight.std;
        // The machine has stood since then, and moves again.
        let is_old = |best: &Level| best.is_over && self.moving_since.is_some_and(|t| t > best.to);
        self.rough = self.rough.filter(|best| !is_old(best));
        match &mut self.rough {
            Some(best) if opened(*best) => best.is_over = true,
            Some(best) if !best.is_over && row.moves() => best.join(row, value),
            _ if row.moves() => self.rough = Some(Level::new(row, value, row.time)),
            _ => {}
        }
    }

    /// Content that leaves where a standing machine opens its bucket, unless it is unlikely to be a load. Where a load has `left` before,
    /// only one that has been filled since then.
    pub fn leaves(&self, row: &Row, left: bool) -> Option<Level> {
        let is_back = |open: &Open| open.has_come_back(row.time, row.witness);
        let content = if left {
            self.rough
                .filter(|_| self.open.as_ref().is_some_and(is_back))
        } else {
            self.rough.or(self.level)
        };
        let may_leave = |level: &Level| self.odds(level.weight.quantity()) > -OPENED_FOR_A_LOAD;
        content.filter(|level| self.opening >= CHANGING && may_leave(level))
    }

    /// Content that has been suspended since then, unless it is unlikely to be a load.
    pub fn hung(&self, row: &Row, since: f64) -> Option<Level> {
        let any = Quantity {
            std: UNKNOWN * self.rated,
            ..self.any_load()
        };
        let seen = self.rough.or(self.level);
        let hung = seen.unwrap_or(Level::new(row, any, since));
        (self.odds(hung.weight.quantity()) > -OPENED_FOR_A_LOAD).then_some(hung)
    }

    /// Load that was seen in motion and has left since then, with the time of leaving. The weighed value must indicate an empty bucket
    /// rather than the same content.
    pub fn left_unseen(&self, value: Quantity) -> Option<(Level, f64)> {
        let open = self.open.filter(Open::has_changed)?;
        let load = self.unchanged?;
        let before = Self {
            level: Some(load),
            ..*self
        };
        let has_left = self.odds(load.weight.quantity()) > DECIDED
            && !self.is_likely(value)
            && before.exchanged(value) > DECIDED;
        Some((load, open.changed?)).filter(|_| has_left)
    }

    /// Sets the content to a load that has begun to leave.
    pub fn take(&mut self, mut level: Level, row: &Row, is_weighed: bool) {
        if !is_weighed {
            level.guess(Quantity {
                value: LOAD.value * self.rated,
                std: UNKNOWN * self.rated,
            });
        }
        (self.level, self.next) = (Some(level), None);
        (self.rough, self.unchanged) = (None, None);
        self.open = Some(Open::from(row, 0.0));
    }

    /// The level, where it is certainly unchanged.
    pub fn known(&self) -> Option<Level> {
        self.level.filter(|_| self.open.is_none())
    }

    /// Learns the weight of the empty bucket from a content that is no load, where it may be empty.
    pub fn learn_empty(&mut self, content: Quantity) {
        if self.may_be_empty && content.std < LEAST * self.rated {
            let std = content.std.max(SAME * self.rated / 2.0);
            self.empty = Quantity { std, ..content };
        }
    }

    /// Duration of the present motion [s].
    pub fn moving(&self, now: f64) -> f64 {
        self.moving_since.map_or(0.0, |since| now - since)
    }

    /// Time at which the bucket was full: when it was weighed, or when the machine set off if nothing showed the content before.
    pub fn filled(&self, next: &Level) -> f64 {
        match (self.open, self.moving_since) {
            (Some(open), Some(since)) => since.clamp(open.since.min(next.from), next.from),
            _ => next.from,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn less_than_the_last_rest_is_no_load() {
        let mut content = Content::new(600.0);
        let kg = |value, std| Quantity { value, std };
        content.empty = kg(97.0, 18.0);
        assert!(!content.is_likely(kg(7.0, 15.0)));
        assert!(content.is_likely(kg(300.0, 30.0)));
    }
}
