//! Trucks and days and their totals.

use super::load::Load;
use super::total::Total;

/// One truck.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Truck {
    /// Number, from 1.
    pub number: u32,
    /// Value of the truck signal, where there is one.
    pub signal: Option<f64>,
    /// Number of the day of its first load.
    pub day: i64,
    /// Time at which its first load was dumped \[s\].
    pub from: Option<f64>,
    /// Time at which its last load was dumped \[s\].
    pub to: Option<f64>,
    /// Total of its loads.
    pub total: Total,
    /// Target weight \[kg\].
    pub target: Option<f64>,
}

impl Truck {
    /// Remaining weight to the target; negative above it \[kg\].
    pub fn remaining(&self) -> Option<f64> {
        self.target.map(|target| target - self.total.kg)
    }

    /// Returns the next truck.
    pub(super) fn next(&self, signal: Option<f64>) -> Self {
        Self {
            number: self.number.saturating_add(1),
            signal,
            target: self.target,
            ..Self::default()
        }
    }

    /// Adds a dumped load.
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
    /// Number of midnights since that of the settings.
    pub number: i64,
    /// Number of trucks that were loaded.
    pub trucks: u32,
    /// Total delivered.
    pub total: Total,
}

/// Length of a day [s].
pub(super) const DAY: f64 = 86_400.0;
