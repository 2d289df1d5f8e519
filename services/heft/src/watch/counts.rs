//! Counts of channels and processes.

use messages::{Health, Stamp};

/// Messages of a channel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SampleCounts {
    /// Sequence number after that of the latest sample.
    pub next: u64,
    /// Time of the latest sample, by the data \[s\].
    pub time: f64,
    /// Samples.
    pub samples: u64,
    /// Samples that the supervisor itself missed while it was held up.
    pub unseen: u64,
}

impl SampleCounts {
    pub(super) fn add(&mut self, stamp: &Stamp) {
        if stamp.sequence >= self.next {
            (self.next, self.time) = (stamp.sequence + 1, stamp.time);
            self.samples += 1;
        }
    }
}

/// Counts of a process, summed over its restarts.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    /// Samples handled.
    pub steps: u64,
    /// Samples that never arrived.
    pub lost: u64,
    /// Samples that came later than a period.
    pub late: u64,
}

impl Counts {
    pub(super) fn add(&mut self, health: &Health) {
        self.steps += health.steps;
        self.lost += health.lost;
        self.late += health.late;
    }
}
