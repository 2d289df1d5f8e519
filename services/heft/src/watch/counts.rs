//! What channels carried and processes counted.

use messages::{Health, Stamp};

/// What a channel carried.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SampleCounts {
    /// Number after that of the latest sample.
    pub next: u64,
    /// Time of the latest sample, as the data tell it \[s\].
    pub time: f64,
    /// Samples.
    pub samples: u64,
    /// Samples that the supervisor, held up itself, did not see.
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

/// What a process counted, before its restarts and since.
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
