//! A machine that sends samples, as the site sees it: which run, how far, how much it may still send.

use std::time::{Duration, Instant};

use recording::payload::put_delimited;

use crate::label::Label;

/// Samples a second that a machine may send over some time, and at once.
const RATE: f64 = 2000.0;
const BURST: f64 = 10_000.0;
/// Least time between two new runs of a machine.
pub const RUNS: Duration = Duration::from_secs(2);

/// What was counted of a machine.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Samples that went to `heft serve`.
    pub samples: u64,
    /// Samples that are missing between those that came.
    pub missing: u64,
    /// Samples for which `heft serve` was too slow.
    pub late: u64,
    /// Messages that were not taken.
    pub refused: u64,
    /// Estimates that came back.
    pub estimates: u64,
}

/// A machine that sends samples.
pub struct Machine {
    /// Start of its run [ms since 1970], and since when it is known.
    pub epoch: u64,
    since: Instant,
    /// Number of its last sample, -1 before the first.
    last: i64,
    /// Its wall clock minus its monotonic clock [ms].
    pub wall_offset_ms: i64,
    pub heard: Instant,
    /// Samples that it may send now.
    left: f64,
    /// It is in `heft serve`.
    pub is_served: bool,
    pub counts: Counts,
}

/// A sample, as it came.
pub struct One<'a> {
    pub number: u64,
    pub measured_ns: u64,
    pub bytes: &'a [u8],
}

/// What a run is called in `heft serve`.
pub fn name(machine: &str, epoch: u64) -> String {
    format!("{machine} {epoch}")
}

/// Machine and run of such a name.
pub fn run_of(name: &str) -> Option<(&str, u64)> {
    let (machine, epoch) = name.rsplit_once(' ')?;
    Some((machine, epoch.parse().ok()?))
}

impl Machine {
    pub fn new(now: Instant) -> Self {
        Self {
            epoch: 0,
            since: now,
            last: -1,
            wall_offset_ms: 0,
            heard: now,
            left: BURST,
            is_served: false,
            counts: Counts::default(),
        }
    }

    /// The records of samples for `heft serve`, and how many; `None` if they may not be sent now.
    pub fn admit(
        &mut self,
        now: Instant,
        label: &Label,
        samples: &[One<'_>],
        records: &mut Vec<u8>,
    ) -> Option<u64> {
        let earned = now.duration_since(self.heard).as_secs_f64() * RATE;
        self.left = (self.left + earned).min(BURST);
        self.heard = now;
        let wanted = samples.len() as f64;
        if self.left < wanted {
            return None;
        }
        self.left -= wanted;
        if label.epoch != self.epoch {
            let is_soon = self.is_served && now.duration_since(self.since) < RUNS;
            if label.epoch < self.epoch || is_soon {
                return None;
            }
            if self.is_served {
                forget(&name(&label.machine, self.epoch), records);
            }
            (self.epoch, self.since, self.last) = (label.epoch, now, -1);
        }
        self.is_served = true;
        let name = name(&label.machine, label.epoch);
        let mut count = 0;
        for sample in samples {
            let number = sample.number as i64;
            if number <= self.last {
                continue;
            }
            if self.last >= 0 {
                self.counts.missing += (number - self.last - 1) as u64;
            }
            self.last = number;
            count += 1;
            put_delimited(name.as_bytes(), records);
            put_delimited(sample.bytes, records);
        }
        let measured_ns = samples.last().map_or(0, |s| s.measured_ns);
        self.wall_offset_ms = label.wall_ms as i64 - (measured_ns / 1_000_000) as i64;
        Some(count)
    }
}

/// Tells `heft serve` that a run is over.
pub fn forget(name: &str, records: &mut Vec<u8>) {
    put_delimited(name.as_bytes(), records);
    put_delimited(&[], records);
}
