//! State of a machine that sends samples: its runs, their progress, and its rate limit.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use recording::payload::put_delimited;

use crate::label::Label;

/// Sample rate of a machine [1/s]: sustained here, burst below.
const RATE: f64 = 2000.0;
const BURST: f64 = 10_000.0;
/// Least time between two new runs of a machine.
pub const RUNS: Duration = Duration::from_secs(2);

/// Counts of a machine.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Samples that went to `heft serve`.
    pub samples: u64,
    /// Samples that are missing between received ones.
    pub missing: u64,
    /// Samples dropped because `heft serve` was too slow.
    pub late: u64,
    /// Messages that were refused.
    pub refused: u64,
    /// Estimates from `heft serve`.
    pub estimates: u64,
}

/// Runs of a machine that are estimated at a time: the ending one, the beginning one, and room for forged ones.
const AT_A_TIME: usize = 4;

/// Most gaps of a run whose estimates are pending; the oldest is dropped.
const GAPS: usize = 256;

/// A run of a machine.
pub struct Run {
    /// Its id.
    pub id: u64,
    heard: Instant,
    /// Number of its last sample, -1 before the first.
    last: i64,
    /// The last samples were not passed on.
    is_cut: bool,
    /// First samples after a gap, whose estimates are pending.
    gaps: VecDeque<i64>,
    /// The machine's wall clock minus its monotonic clock [ms].
    pub wall_offset_ms: i64,
}

/// A machine that sends samples.
pub struct Machine {
    /// The runs in `heft serve`. They are ordered by nothing but the time of their last samples.
    pub runs: Vec<Run>,
    began: Option<Instant>,
    pub heard: Instant,
    /// Tokens left: samples that it may send now.
    left: f64,
    pub counts: Counts,
}

/// A received sample.
pub struct One<'a> {
    pub number: u64,
    pub measured_ns: u64,
    pub bytes: &'a [u8],
}

/// Name of a run in `heft serve`.
pub fn name(machine: &str, run: u64) -> String {
    format!("{machine} {run}")
}

/// Machine and run of such a name.
pub fn run_of(name: &str) -> Option<(&str, u64)> {
    let (machine, run) = name.rsplit_once(' ')?;
    Some((machine, run.parse().ok()?))
}

impl Run {
    fn note_gap(&mut self, number: i64) {
        if self.gaps.len() >= GAPS {
            self.gaps.pop_front();
        }
        self.gaps.push_back(number);
    }

    /// Whether samples are missing between the previous estimate and that of this sample.
    pub fn passes_gap(&mut self, number: i64) -> bool {
        let waiting = self.gaps.len();
        self.gaps.retain(|gap| *gap > number);
        self.gaps.len() < waiting
    }
}

impl Machine {
    pub fn new(now: Instant) -> Self {
        Self {
            runs: Vec::new(),
            began: None,
            heard: now,
            left: BURST,
            counts: Counts::default(),
        }
    }

    /// The run of this id, begun if new; `None` if runs begin faster than the limit. The run that was silent for longest is
    /// dropped.
    fn run(&mut self, now: Instant, label: &Label, records: &mut Vec<u8>) -> Option<&mut Run> {
        if let Some(i) = self.runs.iter().position(|r| r.id == label.run) {
            return self.runs.get_mut(i);
        }
        if self.began.is_some_and(|at| now.duration_since(at) < RUNS) {
            return None;
        }
        if self.runs.len() >= AT_A_TIME {
            let oldest = (0..self.runs.len()).min_by_key(|i| self.runs[*i].heard)?;
            if now.duration_since(self.runs[oldest].heard) < RUNS {
                return None;
            }
            let gone = self.runs.swap_remove(oldest);
            forget(&name(&label.machine, gone.id), records);
        }
        self.began = Some(now);
        self.runs.push(Run {
            id: label.run,
            heard: now,
            last: -1,
            is_cut: false,
            gaps: VecDeque::new(),
            wall_offset_ms: 0,
        });
        self.runs.last_mut()
    }

    /// Notes that the last samples of a run were not passed on.
    pub fn cut(&mut self, run: u64) {
        if let Some(run) = self.runs.iter_mut().find(|r| r.id == run) {
            run.is_cut = true;
        }
    }

    /// Writes the records of the samples for `heft serve`; returns their number, `None` if they exceed the limits.
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
        let run = self.run(now, label, records)?;
        run.heard = now;
        let name = name(&label.machine, label.run);
        let (mut count, mut missing) = (0, 0_u64);
        for sample in samples {
            let number = sample.number as i64;
            if number <= run.last {
                continue;
            }
            if run.last >= 0 {
                missing = missing.saturating_add((number - run.last - 1) as u64);
            }
            let is_cut = std::mem::take(&mut run.is_cut);
            if is_cut || number != run.last + 1 {
                run.note_gap(number);
            }
            run.last = number;
            count += 1;
            put_delimited(name.as_bytes(), records);
            put_delimited(sample.bytes, records);
        }
        let measured_ns = samples.last().map_or(0, |s| s.measured_ns);
        run.wall_offset_ms = label.wall_ms as i64 - (measured_ns / 1_000_000) as i64;
        self.counts.missing = self.counts.missing.saturating_add(missing);
        Some(count)
    }
}

/// Writes the record that ends a run in `heft serve`.
pub fn forget(name: &str, records: &mut Vec<u8>) {
    put_delimited(name.as_bytes(), records);
    put_delimited(&[], records);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_numbers_of_a_hostile_machine_overflow_nothing() {
        let begun = Instant::now();
        let mut machine = Machine::new(begun);
        for run in 0..3 {
            let now = begun + RUNS * (run + 1);
            let one = |number| One {
                number,
                measured_ns: 0,
                bytes: &[1],
            };
            let samples = [one(0), one(i64::MAX as u64)];
            let label = Label {
                machine: "ex-1".into(),
                run: u64::from(run),
                number: i64::MAX as u64,
                after: None,
                wall_ms: 0,
            };
            let taken = machine.admit(now, &label, &samples, &mut Vec::new());
            assert_eq!(taken, Some(2));
        }
        assert_eq!(machine.counts.missing, u64::MAX);
    }
}
