//! Stretches of work in which a fault of a sensor left no load weighed: loads may be missing in the sum.
//!
//! A stretch has neither a trusted row nor a weighed load that was dumped, and a trusted row or the recording ends it: where such a load
//! ends it, loads are still weighed. It counts if the machine moved, if one fault was the reason for half of it or more, and if it is
//! longer than loads take to come.

use estimation::{excavator, loader};
use messages::{Machine, excavator_bits};

/// Time in which a load is awaited before two are known, and the shortest one later \[s\].
const UNKNOWN: f64 = 60.0;
const SHORTEST: f64 = 30.0;
/// The same as a multiple of the mean time between two loads.
const MEAN_TIMES: f64 = 1.5;
/// Least time of motion in a stretch: a swing there and back \[s\].
const MOVED: f64 = 5.0;
/// Longest time that a row stands for \[s\]; a logger may pause.
const ROW: f64 = 1.0;
/// Number of codes of reasons.
const CODES: usize = 32;

const _: () = {
    assert!(excavator::Reason::NAMES.len() <= CODES && loader::Reason::NAMES.len() <= CODES);
};

/// The code of an input that is missing or too old, where no reason is named.
pub const MISSING: u32 = 0;

/// The recording's time per time without a weighed load, below which the sum is in doubt.
const ONE_IN: f64 = 10.0;

/// Whether the sums of loads are in doubt: the outages are more than a tenth of so many `seconds`.
#[must_use]
pub fn are_doubtful(outages: &[Outage], seconds: f64) -> bool {
    ONE_IN * outages.iter().map(|outage| outage.seconds).sum::<f64>() > seconds
}

/// The time in which no load was weighed because of one fault.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Outage {
    /// Code of the reason; [`MISSING`] where an input is missing or too old.
    pub reason: u32,
    /// Number of stretches.
    pub stretches: u32,
    /// Their sum \[s\].
    pub seconds: f64,
    /// Begin and end of the longest one \[s\].
    pub longest: [f64; 2],
    /// Whether the longest one lasts to the end of the recording.
    pub lasts: bool,
}

/// A row, as far as an outage depends on it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Watched {
    pub time: f64,
    pub moves: bool,
    pub trusted: bool,
    /// Number of the weighed load that was dumped in this row.
    pub dumped: Option<u32>,
    /// The fault, see [`fault`].
    pub fault: Option<u32>,
}

/// Reasons of the excavator that are faults of a sensor.
const FAULTS: [excavator::Reason; 8] = {
    use excavator::Reason as R;
    [
        R::Gain,
        R::Delay,
        R::Offset,
        R::Limit,
        R::Frozen,
        R::Sign,
        R::Jump,
        R::Contradiction,
    ]
};

/// The fault of a sensor in a row of reason and flags; `None` if there is none.
pub(super) fn fault(machine: Machine, reason: u32, flags: u32) -> Option<u32> {
    match machine {
        Machine::Excavator => {
            let found = excavator::Reason::of(reason);
            let is_fault = FAULTS.contains(&found);
            let is_missing = flags & excavator_bits::FRESH == 0;
            is_fault.then_some(reason).or(is_missing.then_some(MISSING))
        }
        Machine::Loader => {
            use loader::Reason as R;
            let found = R::of(reason);
            let is_stuck = (R::StuckSpeed.code()..=R::StuckAcceleration.code()).contains(&reason);
            (is_stuck || matches!(found, R::Missing | R::LiftCylinder)).then_some(reason)
        }
    }
}

/// A fault within the current stretch.
#[derive(Debug, Clone, Copy, Default)]
struct Share {
    /// Its time in the stretch \[s\].
    seconds: f64,
    /// Time of its first row, and the length of the stretch before it \[s\].
    begin: f64,
    before: f64,
}

/// The current stretch without a trusted row and a dumped load.
#[derive(Debug, Clone, Copy, Default)]
struct Stretch {
    seconds: f64,
    /// Its time in motion \[s\].
    moved: f64,
    end: f64,
    faults: [Share; CODES],
}

impl Stretch {
    /// The most frequent fault as an outage, if it is one for loads that come every `period` \[s\].
    fn outage(&self, period: f64) -> Option<Outage> {
        let faults = self.faults.iter().zip(0_u32..);
        let (share, reason) = faults.max_by(|a, b| a.0.seconds.total_cmp(&b.0.seconds))?;
        let seconds = self.seconds - share.before;
        let is_one = seconds > period && 2.0 * share.seconds >= seconds && self.moved >= MOVED;
        is_one.then_some(Outage {
            reason,
            stretches: 1,
            seconds,
            longest: [share.begin, self.end],
            lasts: false,
        })
    }
}

/// Finds the outages of a machine.
#[derive(Debug, Clone, Default)]
pub(super) struct Outages {
    last: Option<f64>,
    /// Time of all rows \[s\].
    seconds: f64,
    stretch: Stretch,
    /// Number of the last dumped load, and its time if there was no outage since \[s\].
    dumped: Option<u32>,
    since: Option<f64>,
    /// Sum of the times between two loads \[s\], and their number.
    between: (f64, u32),
    /// One for each reason.
    found: Vec<Outage>,
}

impl Outages {
    /// Takes a row.
    pub(super) fn see(&mut self, row: &Watched) {
        if !row.time.is_finite() {
            return;
        }
        let before = self.last.replace(row.time).unwrap_or(row.time);
        let passed = (row.time - before).clamp(0.0, ROW);
        self.seconds += passed;
        let is_new = |number: &u32| self.dumped.is_none_or(|known| *number > known);
        if let Some(number) = row.dumped.filter(is_new) {
            self.note_load(number);
            return;
        }
        if row.trusted {
            self.end_stretch();
            return;
        }
        let stretch = &mut self.stretch;
        if let Some(share) = row.fault.and_then(|f| stretch.faults.get_mut(f as usize)) {
            if share.seconds == 0.0 {
                (share.begin, share.before) = (row.time, stretch.seconds);
            }
            // Above 0, so that the begin stays.
            share.seconds += passed.max(f64::MIN_POSITIVE);
        }
        stretch.seconds += passed;
        stretch.moved += if row.moves { passed } else { 0.0 };
        stretch.end = row.time;
    }

    fn note_load(&mut self, number: u32) {
        if let Some(since) = self.since.replace(self.seconds) {
            self.between.0 += self.seconds - since;
            self.between.1 += 1;
        }
        self.dumped = Some(number);
        self.stretch = Stretch::default();
    }

    fn end_stretch(&mut self) {
        if self.stretch.seconds > 0.0 {
            let ended = std::mem::take(&mut self.stretch).outage(self.period());
            self.since = self.since.filter(|_| ended.is_none());
            add(&mut self.found, ended);
        }
    }

    /// Time without a load above which one may be missing \[s\].
    fn period(&self) -> f64 {
        match self.between {
            (_, 0) => UNKNOWN,
            (sum, count) => (MEAN_TIMES * sum / f64::from(count)).max(SHORTEST),
        }
    }

    /// The outages up to now.
    pub(super) fn all(&self) -> Vec<Outage> {
        let mut all = self.found.clone();
        let open = self.stretch.outage(self.period());
        let open = open.map(|outage| Outage {
            lasts: true,
            ..outage
        });
        add(&mut all, open);
        all
    }

    /// Time of all rows \[s\].
    pub(super) fn seconds(&self) -> f64 {
        self.seconds
    }
}

/// Adds an outage to those of its reason.
fn add(all: &mut Vec<Outage>, new: Option<Outage>) {
    let Some(new) = new else {
        return;
    };
    let length = |outage: &Outage| outage.longest[1] - outage.longest[0];
    match all.iter_mut().find(|outage| outage.reason == new.reason) {
        None => all.push(new),
        Some(known) => {
            let longer = if length(&new) > length(known) {
                new
            } else {
                *known
            };
            *known = Outage {
                stretches: known.stretches + 1,
                seconds: known.seconds + new.seconds,
                ..longer
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of 10 Hz from `begin` to `end` \[s\].
    struct Work(Outages);

    impl Work {
        fn go(&mut self, [begin, end]: [u32; 2], moves: bool, fault: Option<excavator::Reason>) {
            for k in 10 * begin..10 * end {
                let time = f64::from(k) / 10.0;
                self.0.see(&Watched {
                    time,
                    moves,
                    // Work without a fault is trusted, and dumps a load every 20 s.
                    trusted: fault.is_none(),
                    dumped: (fault.is_none() && k % 200 == 199).then_some(k / 200),
                    fault: fault.map(excavator::Reason::code),
                });
            }
        }
    }

    #[test]
    fn a_fault_that_lasts_to_the_end_is_an_outage_from_its_first_row() {
        let mut work = Work(Outages::default());
        work.go([0, 90], true, None);
        assert_eq!(work.0.all(), []);
        work.go([90, 240], true, Some(excavator::Reason::Jump));
        let [outage] = work.0.all()[..] else {
            panic!("{:?}", work.0.all());
        };
        assert!(outage.lasts && outage.stretches == 1);
        assert_eq!(outage.reason, excavator::Reason::Jump.code());
        assert!((outage.seconds - 150.0).abs() < 0.2, "{outage:?}");
        assert!((outage.longest[0] - 90.0).abs() < 0.2, "{outage:?}");
        assert!((work.0.seconds() - 239.9).abs() < 0.2);
    }

    #[test]
    fn stretches_of_one_fault_are_summed_and_the_longest_is_named() {
        let mut work = Work(Outages::default());
        let jump = Some(excavator::Reason::Jump);
        work.go([0, 60], true, None);
        work.go([60, 110], true, jump);
        work.go([110, 150], true, None);
        work.go([150, 190], true, jump);
        work.go([190, 240], true, None);
        let [outage] = work.0.all()[..] else {
            panic!("{:?}", work.0.all());
        };
        assert_eq!((outage.stretches, outage.lasts), (2, false));
        assert!((outage.seconds - 90.0).abs() < 0.5, "{outage:?}");
        assert!((outage.longest[0] - 60.0).abs() < 0.2, "{outage:?}");
    }

    #[test]
    fn where_a_load_ends_the_stretch_loads_are_still_found() {
        let mut work = Work(Outages::default());
        work.go([0, 60], true, None);
        work.go([60, 130], true, Some(excavator::Reason::Jump));
        work.0.see(&Watched {
            time: 130.0,
            moves: true,
            trusted: false,
            dumped: Some(100),
            fault: None,
        });
        work.go([131, 150], true, None);
        assert_eq!(work.0.all(), []);
    }

    #[test]
    fn a_parked_machine_a_short_fault_and_a_content_that_changes_are_none() {
        for (seconds, moves, reason) in [
            (150, false, excavator::Reason::Jump),
            (20, true, excavator::Reason::Jump),
        ] {
            let mut work = Work(Outages::default());
            work.go([0, 60], true, None);
            work.go([60, 60 + seconds], moves, Some(reason));
            assert_eq!(work.0.all(), [], "{reason:?}");
        }
        let fresh = excavator_bits::FRESH;
        let content = excavator::Reason::Content.code();
        assert_eq!(fault(Machine::Excavator, content, fresh), None);
        assert_eq!(fault(Machine::Excavator, content, 0), Some(MISSING));
        let load = loader::Reason::Load.code();
        assert_eq!(fault(Machine::Loader, load, 0), None);
    }
}
