//! From levels to loads.
//!
//! | what is seen | what it means |
//! |---|---|
//! | the payload rises clear of the empty bucket | a load is in the bucket |
//! | it falls clear of the load, or the estimator sees it change | the load leaves |
//! | it is weighed lower after that | the load is dumped, and this stays in the bucket |
//! | it is weighed as before, and the machine has not moved meanwhile | the load never left |
//! | the machine has moved as far as from a truck to a pile | it was dumped, and this is the next one |
//! | it is weighed higher, and the machine has not moved meanwhile | one more scoop |

use super::book::{DAY, Day, Truck};
use super::level::Level;
use super::load::{CarryBack, Load, Stage, Weight};
use super::now::{Holding, Now};
use super::row::{Row, Witness};
use super::total::Total;
use crate::math::sqrt;
use crate::time_base::LONGEST;
use crate::{HALF_WIDTH_95, Quantity};

/// A payload is weighed where its 95 % interval is narrower than this to either side, in rated payloads.
const WEIGHED: f64 = 0.5;
/// Contents differ if they are further apart than this, in standard deviations of their difference.
const CLEAR: f64 = 2.5;
/// And by more than this, in rated payloads: smaller loads are none.
const LEAST: f64 = 0.08;
/// Differences up to this are none, in rated payloads.
const SAME: f64 = 0.04;
/// Empty bucket before it is weighed: standard deviation in rated payloads.
const EMPTY_STD: f64 = 0.05;
/// A content counts when it has been seen for this long [s].
const SETTLED: f64 = 0.3;
/// A load is reported when it has been weighed for this long [s].
const REPORTED_AFTER: f64 = 0.4;
/// The content changes when the estimator has said so for this long [s].
const CHANGING: f64 = 0.15;
/// More than this share of a load that stays is a load of its own.
const PARTIAL: f64 = 0.35;
/// Dumping, the way back and filling again take so long at least [s].
const ROUND_TRIP: f64 = 4.0;
/// Speed of a machine that moves [rad/s, m/s].
const MOVING: f64 = 0.05;
/// A longer step between rows is a gap [s].
const GAP: f64 = 2.0;
/// So many rows behind the clock: it was set back.
const SET_BACK: u32 = 5;
/// Share of the variance of a payload that all loads of a machine share, where the estimator does not tell.
const COMMON: f64 = 0.7;

/// What the ledger is given.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Payload of a full bucket, roughly \[kg\].
    pub rated: f64,
    /// What a truck shall hold \[kg\].
    pub target: Option<f64>,
    /// A load this long after the one before goes to another truck; 0 never \[s\].
    pub pause: f64,
    /// Time of a midnight, from which days are counted \[s\].
    pub midnight: f64,
}

impl Settings {
    /// No bucket holds less or more \[kg\].
    pub const RATED: [f64; 2] = [1e-3, 1e7];

    /// No target, a new truck after five minutes, days from time 0.
    pub fn with_rated(rated: f64) -> Self {
        Self {
            rated,
            target: None,
            pause: 300.0,
            midnight: 0.0,
        }
    }
}

/// What one row has brought about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Events {
    /// A load came as far as its stage says, or is reported better.
    pub load: Option<Load>,
    /// A truck is complete.
    pub truck: Option<Truck>,
    /// A day is over.
    pub day: Option<Day>,
}

impl Events {
    /// Whether nothing has happened.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// The load in the bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Held {
    filled: f64,
    is_reported: bool,
    /// It is said to leave since then.
    leaving: Option<f64>,
}

/// The content is not known since then.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Open {
    since: f64,
    changing: f64,
    /// Where the machine is, and the ends of where it has been since then [rad or m].
    at: f64,
    ends: [f64; 2],
}

impl Open {
    /// Whether the machine may have dumped and filled again by now: it was as far away as a truck is.
    fn has_travelled(&self, now: f64, witness: Witness) -> bool {
        let far = self.ends[1] - self.ends[0] >= witness.trip();
        far && now - self.since >= ROUND_TRIP
    }
}

/// Counts loads, trucks and days.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ledger {
    settings: Settings,
    time: Option<f64>,
    behind: u32,
    moving_since: Option<f64>,
    holding: Holding,
    level: Option<Level>,
    next: Option<Level>,
    open: Option<Open>,
    empty: Quantity,
    /// The level is the first one, or lower than the one before.
    may_be_empty: bool,
    carry_back: CarryBack,
    held: Option<Held>,
    /// Dumped, and what stays in the bucket is still being weighed.
    pending: Option<Load>,
    loads: u32,
    truck: Truck,
    day: Day,
    day_has_truck: u32,
    all: Total,
}

impl Ledger {
    /// An empty book.
    pub fn new(settings: Settings) -> Self {
        let rated = if settings.rated.is_finite() {
            settings.rated.clamp(Settings::RATED[0], Settings::RATED[1])
        } else {
            1.0
        };
        let settings = Settings {
            rated,
            target: settings.target.filter(|t| t.is_finite()),
            ..settings
        };
        let truck = Truck {
            number: 1,
            target: settings.target,
            ..Truck::default()
        };
        Self {
            settings,
            time: None,
            behind: 0,
            moving_since: None,
            holding: Holding::new(rated),
            level: None,
            next: None,
            open: None,
            empty: Quantity {
                value: 0.0,
                std: EMPTY_STD * rated,
            },
            may_be_empty: true,
            carry_back: CarryBack::new(rated),
            held: None,
            pending: None,
            loads: 0,
            truck,
            day: Day::default(),
            day_has_truck: 0,
            all: Total::default(),
        }
    }

    /// Takes one estimate. Rows whose time does not increase are passed over.
    pub fn step(&mut self, row: &Row) -> Events {
        let Some(dt) = self.clock(row.time) else {
            return Events::default();
        };
        let mut events = Events::default();
        self.call_truck(row, &mut events);
        self.moving_since = if row.speed.abs() > MOVING {
            self.moving_since.or(Some(row.time))
        } else {
            None
        };
        let weighed = row
            .weighed()
            .filter(|p| !row.changing && HALF_WIDTH_95 * p.std < WEIGHED * self.settings.rated);
        self.holding.step(row, dt, weighed.is_some());
        if dt > GAP {
            self.doubt(row, 0.0, dt, &mut events);
        }
        match weighed {
            Some(value) => self.weigh(row, value, &mut events),
            None => self.doubt(row, if row.changing { dt } else { 0.0 }, dt, &mut events),
        }
        self.find(row, &mut events);
        events
    }

    /// What the bucket holds now: always a value.
    pub fn now(&self) -> Now {
        self.holding.now()
    }

    /// The load in the bucket, as far as it is known; `None` when it is empty.
    pub fn carried(&self) -> Option<Load> {
        self.held.map(|held| self.load(&held, Stage::Carried))
    }

    /// The truck that is being loaded, with what has been dumped so far.
    pub fn truck(&self) -> Truck {
        self.truck.with(self.on_the_way().as_ref())
    }

    /// Today.
    pub fn day(&self) -> Day {
        let last = self.on_the_way();
        let mut day = self.day;
        day.trucks += u32::from(self.day_has_truck == 0 && last.is_some());
        day.total = day.total.with(last.as_ref());
        day
    }

    /// Everything since the beginning.
    pub fn all(&self) -> Total {
        self.all.with(self.on_the_way().as_ref())
    }

    /// Begins another truck: what is dumped from now on goes there.
    pub fn next_truck(&mut self) -> Events {
        let mut events = Events::default();
        self.change_truck(self.truck.signal, &mut events);
        events
    }

    /// Says what each truck shall hold from now on \[kg\].
    pub fn set_target(&mut self, target: Option<f64>) {
        self.truck.target = target.filter(|t| t.is_finite());
    }

    /// The recording is over: the last load, truck and day. What is still in the bucket is [`Self::carried`].
    pub fn finish(&mut self) -> Events {
        let mut events = Events::default();
        let left = self.held.and_then(|held| held.leaving);
        if let Some(time) = left {
            self.dump(time, None, &mut events);
        }
        self.settle(&mut events);
        events.truck = Some(self.truck).filter(|t| t.total.loads > 0);
        events.day = Some(self.day).filter(|d| d.total.loads > 0);
        events
    }

    /// Time since the row before; `None` for a row that comes too late.
    fn clock(&mut self, time: f64) -> Option<f64> {
        if !time.is_finite() {
            return None;
        }
        let dt = time - self.time.unwrap_or(time);
        if self.time.is_some() && dt <= 0.0 {
            self.behind += 1;
            if self.behind < SET_BACK {
                return None;
            }
            (self.level, self.next, self.open, self.held) = (None, None, None, None);
            self.moving_since = None;
        }
        self.behind = 0;
        self.time = Some(time);
        Some(dt.clamp(0.0, LONGEST))
    }

    /// Another value of the signal begins another truck.
    fn call_truck(&mut self, row: &Row, events: &mut Events) {
        let Some(signal) = row.truck.filter(|s| s.is_finite()) else {
            return;
        };
        if self.truck.signal.is_some_and(|known| known != signal) {
            self.change_truck(Some(signal), events);
        }
        self.truck.signal = Some(signal);
    }

    fn change_truck(&mut self, signal: Option<f64>, events: &mut Events) {
        self.settle(events);
        if self.truck.total.loads > 0 {
            events.truck = Some(self.truck);
            self.truck = self.truck.next(signal);
        }
        self.truck.signal = signal;
        self.day_has_truck = 0;
    }

    fn change_day(&mut self, time: f64, events: &mut Events) {
        let days = (time - self.settings.midnight) / DAY;
        // Rounds down, for times before that midnight too.
        let number = (days as i64).saturating_sub(i64::from(days < 0.0));
        if number != self.day.number {
            events.day = Some(self.day).filter(|d| d.total.loads > 0);
            self.day = Day {
                number,
                ..Day::default()
            };
            self.day_has_truck = 0;
        }
    }

    /// What was dumped and is not in the sums yet.
    fn on_the_way(&self) -> Option<Load> {
        let leaving = self.held.filter(|held| held.leaving.is_some());
        self.pending
            .or_else(|| leaving.map(|held| self.load(&held, Stage::Dumped)))
    }

    /// The content may be another than before.
    fn doubt(&mut self, row: &Row, changing: f64, dt: f64, events: &mut Events) {
        self.next = None;
        let open = self.open.get_or_insert(Open {
            since: row.time - if dt > GAP { dt } else { 0.0 },
            changing: 0.0,
            at: 0.0,
            ends: [0.0; 2],
        });
        open.changing += changing;
        let way = row.speed * dt;
        open.at += if way.is_finite() { way } else { 0.0 };
        open.ends = [open.ends[0].min(open.at), open.ends[1].max(open.at)];
        let (since, leaves) = (open.since, open.changing >= CHANGING);
        let staying = self.held.as_mut().filter(|held| held.leaving.is_none());
        if let Some(held) = staying.filter(|_| leaves) {
            held.leaving = Some(since);
            let reported = *held;
            if reported.is_reported {
                events.load = Some(self.load(&reported, Stage::Dumped));
            }
        }
        if self.held.is_none() && open_for(self.open, row.time) >= SETTLED {
            self.settle(events);
        }
    }

    /// The content is weighed.
    fn weigh(&mut self, row: &Row, value: Quantity, events: &mut Events) {
        let common = row.common_std.filter(|c| c.is_finite());
        let common = common.unwrap_or(sqrt(COMMON) * value.std);
        let floor = SAME * self.settings.rated;
        let Some(level) = &mut self.level else {
            let mut first = Level::new(row, value, common, row.time);
            first.left = filled(&first, self.moving_since, self.open);
            (self.level, self.open, self.may_be_empty) = (Some(first), None, true);
            return;
        };
        let returned = self
            .open
            .is_some_and(|open| open.has_travelled(row.time, row.witness));
        let left = self.held.is_some_and(|held| held.leaving.is_some());
        let is_same = level.holds(value, floor) && !(left && returned);
        if is_same {
            if self.open.is_some() && !self.is_telling(value) {
                return;
            }
            if let Some(level) = &mut self.level {
                level.join(row, value, common);
            }
            self.next = None;
            self.open = None;
            self.take_back(events);
            return;
        }
        match &mut self.next {
            Some(next) if next.holds(value, floor) => next.join(row, value, common),
            other => {
                let since = self.open.map_or(row.time, |open| open.since);
                let left = other.map_or(since, |next| next.left.min(since));
                *other = Some(Level::new(row, value, common, left));
            }
        }
        if let Some(next) = self.next.filter(|next| next.age() >= SETTLED) {
            self.move_to(next, events);
        }
    }

    /// After the content may have changed: whether a value tells that it has not.
    fn is_telling(&self, value: Quantity) -> bool {
        let close =
            (2.0 * self.level.map_or(0.0, |l| l.weight.std)).max(SAME * self.settings.rated);
        let loaded = self.held.is_some() && self.is_clear(value, self.empty);
        value.std <= close || loaded
    }

    /// Whether one content is more than another beyond doubt.
    fn is_clear(&self, more: Quantity, less: Quantity) -> bool {
        let std = crate::math::norm(&[more.std, less.std]);
        more.value - less.value > (CLEAR * std).max(LEAST * self.settings.rated)
    }

    /// A load that was said to leave is still there.
    fn take_back(&mut self, events: &mut Events) {
        let Some(held) = self.held.as_mut().filter(|held| held.leaving.is_some()) else {
            return;
        };
        held.leaving = None;
        let back = *held;
        if back.is_reported {
            events.load = Some(self.load(&back, Stage::Carried));
        }
    }

    /// The content is another, and stays.
    fn move_to(&mut self, next: Level, events: &mut Events) {
        let Some(old) = self.level else { return };
        let (before, after) = (old.weight.quantity(), next.weight.quantity());
        let leaving = self.held.and_then(|held| held.leaving);
        let returned = self
            .open
            .is_some_and(|open| open.has_travelled(next.to, next.witness));
        let fell = self.is_clear(before, after);
        if self.held.is_some() && fell {
            self.dump(leaving.unwrap_or(next.left), Some(next.weight), events);
            let rest = after.value > PARTIAL * before.value && self.is_clear(after, self.empty);
            if rest {
                self.held = Some(Held {
                    filled: next.from,
                    is_reported: false,
                    leaving: None,
                });
            }
        } else if self.held.is_some() && leaving.is_some() && returned {
            // Dumped and filled again; nobody weighed the empty bucket.
            self.dump(leaving.unwrap_or(next.left), None, events);
        } else if let Some(held) = &mut self.held {
            held.leaving = None;
            if self.open.is_some() {
                held.filled = filled(&next, self.moving_since, self.open);
            }
        }
        self.may_be_empty = after.value < before.value;
        self.level = Some(Level {
            left: filled(&next, self.moving_since, self.open),
            ..next
        });
        (self.next, self.open) = (None, None);
    }

    /// The load has left; `rest` is what stays in the bucket.
    fn dump(&mut self, time: f64, rest: Option<Weight>, events: &mut Events) {
        self.settle(events);
        let Some(held) = self.held.take() else { return };
        let reported = held.leaving.is_some() && held.is_reported;
        let mut load = self.load(
            &Held {
                leaving: Some(time),
                ..held
            },
            Stage::Dumped,
        );
        self.loads = load.number;
        self.change_day(time, events);
        let pause = self.settings.pause;
        if pause > 0.0 && self.truck.to.is_some_and(|last| time - last > pause) {
            let signal = self.truck.signal;
            self.change_truck(signal, events);
        }
        (load.truck, load.day) = (self.truck.number, self.day.number);
        if let Some(rest) = rest {
            (load.carry_back, load.carry_back_weighed) = (rest, true);
        }
        self.pending = Some(load);
        if !reported {
            events.load = Some(load);
        }
        if rest.is_none() {
            self.settle(events);
        }
    }

    /// Nothing more will be known of what stayed in the bucket.
    fn settle(&mut self, events: &mut Events) {
        let Some(mut load) = self.pending.take() else {
            return;
        };
        if load.carry_back_weighed {
            self.carry_back.add(&load.carry_back);
        }
        load.stage = Stage::Settled;
        self.truck.add(&load);
        self.all.add(&load);
        self.day.total.add(&load);
        if self.day_has_truck == 0 {
            self.day.trucks += 1;
            self.day_has_truck = self.truck.number;
        }
        events.load = Some(load);
    }

    /// Whether the content is a load, and tells it.
    fn find(&mut self, row: &Row, events: &mut Events) {
        let Some(level) = self.level.filter(|_| self.open.is_none()) else {
            return;
        };
        let content = level.weight.quantity();
        if self.held.is_none() {
            let clear = self.is_clear(content, self.empty);
            // What is clear of the empty bucket is the next load, not what stayed of the last.
            if let Some(load) = self.pending.as_mut().filter(|_| !clear)
                && load.carry_back_weighed
            {
                load.carry_back = level.weight;
            }
            if self.may_be_empty && content.std < LEAST * self.settings.rated && !clear {
                let std = content.std.max(SAME * self.settings.rated / 2.0);
                self.empty = Quantity { std, ..content };
            }
            if !clear {
                return;
            }
            self.held = Some(Held {
                filled: level.left,
                is_reported: false,
                leaving: None,
            });
        }
        let moving = self.moving_since.map_or(0.0, |since| row.time - since);
        if let Some(held) = &mut self.held
            && !held.is_reported
            && events.load.is_none()
            && level.age().max(moving) >= REPORTED_AFTER
        {
            if self.pending.is_some() {
                return self.settle(events);
            }
            held.is_reported = true;
            let reported = *held;
            events.load = Some(self.load(&reported, Stage::Carried));
        }
    }

    /// The load in the bucket as it is known now.
    fn load(&self, held: &Held, stage: Stage) -> Load {
        let level = self.level;
        Load {
            number: self.loads.saturating_add(1),
            truck: self.truck.number,
            day: self.day.number,
            stage,
            filled: held.filled,
            dumped: held.leaving,
            weight: level.map(|l| l.weight).unwrap_or_default(),
            carry_back: self.carry_back.expected(),
            carry_back_weighed: false,
            trusted: level.is_some_and(|l| l.trusted),
            why: level.map_or(0, |l| l.why),
            witness: level.map(|l| l.witness).unwrap_or_default(),
        }
    }
}

/// How long the content is not known [s].
fn open_for(open: Option<Open>, time: f64) -> f64 {
    open.map_or(0.0, |open| time - open.since)
}

/// When the bucket was full: when it was weighed; where nothing showed the content before, when the machine set off.
fn filled(next: &Level, moving_since: Option<f64>, open: Option<Open>) -> f64 {
    match (open, moving_since) {
        (Some(open), Some(since)) => since.clamp(open.since.min(next.from), next.from),
        _ => next.from,
    }
}
