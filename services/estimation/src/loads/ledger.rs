//! Ledger: detects loads in the levels of the bucket's content.
//!
//! | observation | meaning |
//! |---|---|
//! | the payload rises significantly above the empty bucket | a load is in the bucket |
//! | it falls significantly below the load, or the estimator detects a change | the load leaves |
//! | it is weighed lower after that | the load is dumped, and this stays in the bucket |
//! | it is weighed as before, and the machine has not moved meanwhile | the load never left |
//! | the machine has moved as far as from a truck to a pile | the load was dumped, and this is the next one |
//! | it was suspended during a swing, and the machine stops for a while | the load is set down |
//! | it is weighed higher, and the machine has not moved meanwhile | one more scoop |

use super::accounts::Accounts;
use super::book::{Day, Truck};
use super::clock::{Clock, Tick};
use super::content::{Carries, Content, LEAST, SETTLED, Shown};
use super::events::Events;
use super::hook::Hook;
use super::level::Level;
use super::load::{Load, Stage, Weight};
use super::now::{Holding, Now};
use super::open::GAP;
use super::row::Row;
use super::settings::Settings;
use super::total::Total;
use crate::{CommonError, HALF_WIDTH_95, Quantity};

/// Largest half width of the 95 % interval of a weighed payload, in rated payloads.
const WEIGHED: f64 = 0.5;
/// Duration for which a load must be weighed before it is reported [s].
const REPORTED_AFTER: f64 = 0.4;
/// Share of a load above which a rest in the bucket is a load of its own.
const PARTIAL: f64 = 0.35;

/// The load in the bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Held {
    filled: f64,
    is_reported: bool,
    /// Time since which it is reported to leave.
    leaving: Option<f64>,
}

impl Held {
    fn since(filled: f64) -> Self {
        Self {
            filled,
            is_reported: false,
            leaving: None,
        }
    }
}

/// Counts loads, trucks and days.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ledger {
    /// Payload of a full bucket [kg].
    rated: f64,
    clock: Clock,
    /// Errors common to all payloads. They cancel between two contents, so loads are found without them.
    common: CommonError,
    /// Errors common to all payloads that a lift arm weighs.
    lift_arm: Option<CommonError>,
    holding: Holding,
    content: Content,
    hook: Hook,
    held: Option<Held>,
    accounts: Accounts,
}

impl Ledger {
    /// An empty ledger.
    pub fn new(settings: Settings) -> Self {
        let settings = settings.usable();
        let rated = settings.rated;
        Self {
            rated,
            clock: Clock::default(),
            common: settings.common,
            lift_arm: settings.lift_arm,
            holding: Holding::new(rated),
            content: Content::new(rated),
            hook: Hook::default(),
            held: None,
            accounts: Accounts::new(settings),
        }
    }

    /// Rated payload \[kg\].
    pub fn rated(&self) -> f64 {
        self.rated
    }

    /// Smallest content that counts as a load \[kg\].
    pub fn smallest(&self) -> f64 {
        LEAST * self.rated
    }

    /// Takes one estimate. Rows whose time does not increase are ignored.
    pub fn step(&mut self, row: &Row) -> Events {
        let mut events = Events::default();
        let row = &row.with_common(self.lift_arm);
        let dt = match self.clock.tick(row.time) {
            Tick::Later(dt) => dt,
            Tick::Refused => return events,
            Tick::SetBack => {
                self.content.forget();
                self.held = None;
                0.0
            }
        };
        let before = (self.leaving(), self.accounts.loads);
        if let Some(signal) = row.truck.filter(|s| s.is_finite()) {
            self.accounts.call_truck(signal, &mut events);
        }
        self.content.follow(row, dt);
        let weighed = row
            .own(&self.common)
            .filter(|p| !row.changing && self.is_weighed(*p));
        self.holding.step(row, dt, weighed.is_some());
        if dt > GAP {
            self.doubt(row, 0.0, dt, &mut events);
        }
        match weighed {
            Some(value) => self.weigh(row, value, &mut events),
            None => self.doubt(row, if row.changing { dt } else { 0.0 }, dt, &mut events),
        }
        if let Some([since, stopped]) = self.hook.step(row, dt) {
            self.set_down(row, since, stopped, &mut events);
        }
        if (self.leaving(), self.accounts.loads) != before {
            self.hook.left(row);
        }
        self.find(row, &mut events);
        events
    }

    /// The present content of the bucket: always a value.
    pub fn now(&self) -> Now {
        self.holding.now()
    }

    /// The load in the bucket as estimated so far; `None` when it is empty.
    pub fn carried(&self) -> Option<Load> {
        self.held.map(|held| self.load(&held, Stage::Carried))
    }

    /// The truck that is being loaded, with the loads dumped so far.
    pub fn truck(&self) -> Truck {
        self.accounts.truck.with(self.unbooked().as_ref())
    }

    /// The present day.
    pub fn day(&self) -> Day {
        self.accounts.day_with(self.unbooked().as_ref())
    }

    /// Total since the start.
    pub fn all(&self) -> Total {
        self.accounts.all.with(self.unbooked().as_ref())
    }

    /// Starts another truck for the loads dumped from now on.
    pub fn next_truck(&mut self) -> Events {
        let mut events = Events::default();
        let signal = self.accounts.truck.signal;
        self.accounts.change_truck(signal, &mut events);
        events
    }

    /// Sets the target weight of each truck from now on \[kg\].
    pub fn set_target(&mut self, target: Option<f64>) {
        self.accounts.truck.target = target.filter(|t| t.is_finite());
    }

    /// Ends the recording: closes the last load, truck and day. A load still in the bucket is [`Self::carried`].
    pub fn finish(&mut self) -> Events {
        let mut events = Events::default();
        if let Some(time) = self.leaving() {
            self.dump(time, None, &mut events);
        }
        self.accounts.close(&mut events);
        events
    }

    /// Time since which the load in the bucket is reported to leave.
    fn leaving(&self) -> Option<f64> {
        self.held.and_then(|held| held.leaving)
    }

    /// A dumped or leaving load that may still change, as the sums of truck and day have it.
    pub fn unbooked(&self) -> Option<Load> {
        let leaving = self.held.filter(|held| held.leaving.is_some());
        self.accounts
            .pending
            .or_else(|| leaving.map(|held| self.load(&held, Stage::Dumped)))
    }

    /// Handles a row after which the content may be another.
    fn doubt(&mut self, row: &Row, changing: f64, dt: f64, events: &mut Events) {
        let open = self.content.doubt(row, changing, dt);
        if let Some(value) = row.own(&self.common) {
            self.notice(row, value, events);
        }
        let staying = self.held.as_mut().filter(|held| held.leaving.is_none());
        if let Some(held) = staying.filter(|_| open.has_changed()) {
            held.leaving = Some(open.since);
            self.report(Stage::Dumped, events);
        }
        if self.held.is_none() && row.time - open.since >= SETTLED {
            self.accounts.settle(events);
        }
    }

    /// Handles a content that is not weighed: what it may be, and whether it leaves.
    fn notice(&mut self, row: &Row, value: Quantity, events: &mut Events) {
        self.content.notice(row, value);
        let is_staying = self.held.is_some_and(|held| held.leaving.is_none());
        let Some(level) = self.content.leaves(row, self.held.is_some()) else {
            return;
        };
        if is_staying {
            return;
        }
        if let Some(left) = self.leaving() {
            self.dump(left, None, events);
        }
        self.take_leaving(level, row, row.time);
    }

    /// Handles a load suspended since `since` and set down where the machine stopped. A load that is held, or left after `since`, is
    /// the same.
    fn set_down(&mut self, row: &Row, since: f64, stopped: f64, events: &mut Events) {
        let is_it = |held: Held| held.leaving.is_none_or(|left| left >= since);
        if self.held.is_some_and(is_it) {
            return;
        }
        let Some(level) = self.content.hung(row, since) else {
            return;
        };
        if let Some(left) = self.leaving() {
            self.dump(left, None, events);
        }
        self.take_leaving(level, row, stopped);
    }

    /// Makes this level the load in the bucket, which has begun to leave.
    fn take_leaving(&mut self, level: Level, row: &Row, leaving: f64) {
        let is_weighed = self.is_weighed(level.weight.quantity());
        self.content.take(level, row, is_weighed);
        self.held = Some(Held {
            leaving: Some(leaving),
            ..Held::since(level.left)
        });
    }

    /// Whether the interval is narrow enough for a weighed content.
    fn is_weighed(&self, value: Quantity) -> bool {
        HALF_WIDTH_95 * value.std < WEIGHED * self.rated
    }

    /// Handles a weighed content.
    fn weigh(&mut self, row: &Row, value: Quantity, events: &mut Events) {
        if self.held.is_none()
            && let Some((load, left)) = self.content.left_unseen(value)
        {
            self.take_leaving(load, row, left);
        }
        let carries = Carries {
            a_load: self.held.is_some(),
            leaving: self.leaving().is_some(),
        };
        match self.content.weigh(row, value, carries) {
            Shown::Nothing => self.content.notice(row, value),
            Shown::Same => self.take_back(events),
            Shown::Another(next) => self.move_to(next, events),
        }
    }

    /// Revokes the leaving of a load that is still there.
    fn take_back(&mut self, events: &mut Events) {
        let leaving = self.held.as_mut().and_then(|held| held.leaving.take());
        if leaving.is_some() {
            self.report(Stage::Carried, events);
        }
    }

    /// Reports the stage of a load that has been reported before.
    fn report(&self, stage: Stage, events: &mut Events) {
        if let Some(held) = self.held.filter(|held| held.is_reported) {
            events.load = Some(self.load(&held, stage));
        }
    }

    /// Handles another constant content.
    fn move_to(&mut self, next: Level, events: &mut Events) {
        let Some(old) = self.content.level else {
            return;
        };
        let (before, after) = (old.weight.quantity(), next.weight.quantity());
        let open = self.content.open;
        let returned = open.is_some_and(|open| open.has_travelled(next.to, next.witness));
        let left = self.leaving().unwrap_or(next.left);
        let emptied =
            open.is_some() && self.content.is_likely(before) && self.content.exchanged(after) > 0.0;
        if emptied && self.held.is_none() {
            // It was too uncertain to be called a load until it was gone.
            self.held = Some(Held::since(old.left));
        }
        if self.held.is_some() && (emptied || self.content.is_clear(before, after)) {
            self.dump(left, Some(next.weight), events);
            let is_load = self.content.is_clear(after, self.content.empty);
            if after.value > PARTIAL * before.value && is_load {
                self.held = Some(Held::since(next.from));
            }
        } else if self.leaving().is_some() && returned {
            // Dumped and filled again; the empty bucket was not weighed.
            self.dump(left, None, events);
        } else if let Some(held) = &mut self.held {
            held.leaving = None;
            if open.is_some() {
                held.filled = self.content.filled(&next);
            }
        }
        self.content.change_to(next);
    }

    /// Books a load that has left; `rest` is what stays in the bucket.
    fn dump(&mut self, time: f64, rest: Option<Weight>, events: &mut Events) {
        self.accounts.settle(events);
        let Some(held) = self.held.take() else { return };
        let was_reported = held.leaving.is_some() && held.is_reported;
        let leaving = Some(time);
        let load = self.load(&Held { leaving, ..held }, Stage::Dumped);
        let load = self.accounts.dump(load, time, rest, events);
        if !was_reported {
            events.load = Some(load);
        }
        if rest.is_none() {
            self.accounts.settle(events);
        }
    }

    /// Decides whether the content is a load, and reports it.
    fn find(&mut self, row: &Row, events: &mut Events) {
        let Some(level) = self.content.known() else {
            return;
        };
        if self.held.is_none() {
            let content = level.weight.quantity();
            if !self.content.is_clear(content, self.content.empty) {
                if self.content.is_likely(content) {
                    return;
                }
                // A content significantly above the empty bucket is the next load, not the rest of the last.
                self.accounts.weigh_rest(level.weight);
                self.content.learn_empty(content);
                return;
            }
            self.held = Some(Held::since(level.left));
        }
        let seen = level.age().max(self.content.moving(row.time));
        if let Some(held) = &mut self.held
            && !held.is_reported
            && events.load.is_none()
            && seen >= REPORTED_AFTER
        {
            if self.accounts.pending.is_some() {
                return self.accounts.settle(events);
            }
            held.is_reported = true;
            self.report(Stage::Carried, events);
        }
    }

    /// The load in the bucket as estimated now.
    fn load(&self, held: &Held, stage: Stage) -> Load {
        let (level, accounts) = (self.content.level, &self.accounts);
        Load {
            number: accounts.loads.saturating_add(1),
            truck: accounts.truck.number,
            day: accounts.day.number,
            stage,
            filled: held.filled,
            dumped: held.leaving,
            weight: level
                .map(|l| l.weight.with_common(&self.common))
                .unwrap_or_default(),
            carry_back: accounts.carry_back.expected(),
            carry_back_weighed: false,
            is_emptied: false,
            trusted: level.is_some_and(|l| l.trusted),
            why: level.map_or(0, |l| l.why),
            witness: level.map(|l| l.witness).unwrap_or_default(),
        }
    }
}
