//! Trucks and days: where one ends and the next begins, and what they add up to.

use super::load::Load;
use super::total::Total;

/// One truck.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Truck {
    /// Counts from 1.
    pub number: u32,
    /// Value of the signal that called it, where there is one.
    pub signal: Option<f64>,
    /// Number of the day of its first load.
    pub day: i64,
    /// When its first load was dumped \[s\].
    pub from: Option<f64>,
    /// When its last load was dumped \[s\].
    pub to: Option<f64>,
    /// What it holds.
    pub total: Total,
    /// What it shall hold \[kg\].
    pub target: Option<f64>,
}

impl Truck {
    /// What is missing to the target; negative where there is too much \[kg\].
    pub fn remaining(&self) -> Option<f64> {
        self.target.map(|target| target - self.total.kg)
    }

    /// The next one.
    pub(super) fn next(&self, signal: Option<f64>) -> Self {
        Self {
            number: self.number.saturating_add(1),
            signal,
            target: self.target,
            ..Self::default()
        }
    }

    /// Adds a load that was dumped.
    pub(super) fn add(&mut self, load: &Load) {
        if self.from.is_none() {
            (self.from, self.day) = (load.dumped, load.day);
        }
        self.to = load.dumped.or(self.to);
        self.total.add(load);
    }

    /// The truck with one more load.
    pub(super) fn with(mut self, load: Option<&Load>) -> Self {
        if let Some(load) = load {
            self.add(load);
        }
        self
    }
}

/// One day.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Day {
    /// Midnights since that of the settings.
    pub number: i64,
    /// Trucks that got something.
    pub trucks: u32,
    /// What was delivered.
    pub total: Total,
}

/// Length of a day [s].
pub(super) const DAY: f64 = 86_400.0;
