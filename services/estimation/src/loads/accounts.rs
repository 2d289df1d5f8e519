//! Accounts of dumped loads: when a weight is final, and to which truck and day it belongs.

use super::book::{DAY, Day, Truck};
use super::events::Events;
use super::load::{CarryBack, Load, Stage, Weight};
use super::settings::Settings;
use super::total::Total;

/// Trucks and days, and the load that is still to be booked.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Accounts {
    settings: Settings,
    pub carry_back: CarryBack,
    /// Dumped load whose carry-back is still being weighed.
    pub pending: Option<Load>,
    /// What the bucket shows after it.
    shown: Weight,
    /// Number of loads so far.
    pub loads: u32,
    pub truck: Truck,
    pub day: Day,
    /// Whether the day has counted this truck.
    day_has_truck: bool,
    pub all: Total,
}

impl Accounts {
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            carry_back: CarryBack::new(settings.rated),
            pending: None,
            shown: Weight::default(),
            loads: 0,
            truck: Truck {
                number: 1,
                target: settings.target,
                ..Truck::default()
            },
            day: Day::default(),
            day_has_truck: false,
            all: Total::default(),
        }
    }

    /// The present day with one more load.
    pub fn day_with(&self, load: Option<&Load>) -> Day {
        let mut day = self.day;
        day.trucks += u32::from(!self.day_has_truck && load.is_some());
        day.total = day.total.with(load);
        day
    }

    /// Takes the truck signal; another value starts another truck.
    pub fn call_truck(&mut self, signal: f64, events: &mut Events) {
        if self.truck.signal.is_some_and(|known| known != signal) {
            self.change_truck(Some(signal), events);
        }
        self.truck.signal = Some(signal);
    }

    /// Assigns the loads dumped from now on to another truck, unless the present one is empty.
    pub fn change_truck(&mut self, signal: Option<f64>, events: &mut Events) {
        self.settle(events);
        if self.truck.total.loads > 0 {
            events.truck = Some(self.truck);
            self.truck = self.truck.next(signal);
        }
        self.truck.signal = signal;
        self.day_has_truck = false;
    }

    fn change_day(&mut self, time: f64, events: &mut Events) {
        let days = (time - self.settings.midnight) / DAY;
        // Rounds down, also for times before that midnight.
        let whole = days as i64;
        let number = whole.saturating_sub(i64::from(days < whole as f64));
        if number != self.day.number {
            events.day = Some(self.day).filter(|d| d.total.loads > 0);
            self.day = Day {
                number,
                ..Day::default()
            };
            self.day_has_truck = false;
        }
    }

    /// Books a load that has left at `time`; `rest` is what stays in the bucket. Returns it with its truck and day.
    pub fn dump(
        &mut self,
        load: Load,
        time: f64,
        rest: Option<Weight>,
        events: &mut Events,
    ) -> Load {
        self.loads = load.number;
        self.change_day(time, events);
        let pause = self.settings.pause;
        if pause > 0.0 && self.truck.to.is_some_and(|last| time - last > pause) {
            self.change_truck(self.truck.signal, events);
        }
        let mut dumped = Load {
            truck: self.truck.number,
            day: self.day.number,
            carry_back_weighed: rest.is_some(),
            ..load
        };
        if let Some(rest) = rest {
            self.leave(&mut dumped, rest);
        }
        self.pending = Some(dumped);
        dumped
    }

    /// Sets what stays in the bucket, by what the bucket shows: what an emptied one keeps, or a part of the load.
    fn leave(&mut self, load: &mut Load, shown: Weight) {
        load.is_emptied = self.carry_back.is_emptied(&shown, load.weight.kg) > 0.5;
        load.carry_back = if load.is_emptied {
            self.carry_back.weighed(&shown)
        } else {
            shown
        };
        self.shown = shown;
    }

    /// Replaces the weight of what stays in the bucket by a better one.
    pub fn weigh_rest(&mut self, weight: Weight) {
        if let Some(mut load) = self.pending.filter(|l| l.carry_back_weighed) {
            self.leave(&mut load, weight);
            self.pending = Some(load);
        }
    }

    /// Books the pending load: nothing more becomes known of what stayed in the bucket.
    pub fn settle(&mut self, events: &mut Events) {
        let Some(mut load) = self.pending.take() else {
            return;
        };
        if load.carry_back_weighed && load.is_emptied {
            self.carry_back.add(&self.shown);
        }
        load.stage = Stage::Settled;
        self.truck.add(&load);
        self.all.add(&load);
        self.day.total.add(&load);
        self.day.trucks += u32::from(!self.day_has_truck);
        self.day_has_truck = true;
        events.load = Some(load);
    }

    /// Closes the last load, truck and day.
    pub fn close(&mut self, events: &mut Events) {
        self.settle(events);
        events.truck = Some(self.truck).filter(|t| t.total.loads > 0);
        events.day = Some(self.day).filter(|d| d.total.loads > 0);
    }
}
