//! Faults of a run: those that were noted, and those by the counts of channels and processes.

use messages::channels::Channel;
use messages::fault;

use super::Watch;
use super::counts::SampleCounts;
use crate::fault::Fault;

/// State of the loggers of a run: whether the recording may lack uncounted samples.
#[derive(Default)]
pub(super) struct Loggers {
    /// The latest logger died, and is not back. A restarted one counts the samples that it missed.
    is_away: bool,
    /// It has reported its counts since it came.
    has_reported: bool,
    /// One died before it reported its counts.
    may_lack: bool,
}

impl Loggers {
    fn died(&mut self, has_begun: bool) {
        let was_there = !self.is_away && has_begun;
        self.may_lack |= was_there && !self.has_reported;
        self.is_away = true;
    }

    fn came(&mut self) {
        (self.is_away, self.has_reported) = (false, false);
    }

    pub(super) fn reported(&mut self) {
        self.has_reported = true;
    }

    fn may_lack(&self, has_begun: bool) -> bool {
        self.may_lack || self.is_away && has_begun
    }
}

impl Watch {
    /// Notes what went wrong.
    pub fn note(&mut self, fault: Fault) {
        let dead = match fault {
            Fault::Died { service, .. } | Fault::Hung { service, .. } => service,
            _ => "",
        };
        if dead == "logger" {
            self.loggers.died(self.next_sequence() > 0);
        }
        match self.faults.iter_mut().find(|(known, _)| *known == fault) {
            Some((_, times)) => *times += 1,
            None => self.faults.push((fault, 1)),
        }
    }

    /// Notes that a service has started, perhaps again.
    pub fn is_there(&mut self, service: &str) {
        if service == "logger" {
            self.loggers.came();
        }
    }

    /// The words of a fault, with its count if it came several times.
    pub fn fault_words(&self, fault: &Fault) -> String {
        let times = self.faults.iter().find(|(known, _)| known == fault);
        match times {
            Some((_, times @ 2..)) => format!("{} ({times} times)", fault.words()),
            _ => fault.words(),
        }
    }

    /// All faults, each once.
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults: Vec<Fault> = self.faults.iter().map(|(fault, _)| fault.clone()).collect();
        let sent = self.sent();
        let samples = sent.next.saturating_sub(sent.samples + sent.unseen);
        if samples > 0 {
            faults.push(Fault::Unmeasured { samples });
        }
        let frames = self.processes.counts_of("sensor").lost;
        if frames > 0 {
            faults.push(Fault::Dropped { frames });
        }
        faults.extend(self.unanswered(sent));
        let samples = self.processes.counts_of("logger").lost;
        if samples > 0 || self.loggers.may_lack(sent.next > 0) {
            faults.push(Fault::Unrecorded { samples });
        }
        let logger = self.processes.health("logger");
        if logger.is_some_and(|health| health.fault == fault::DISK) {
            faults.push(Fault::Disk);
        }
        let failed = self.memory.as_ref().and_then(|memory| memory.failed());
        faults.extend(failed.map(|why| Fault::NotStored { why: why.into() }));
        let late = self.processes.counts();
        let late = late.filter(|(_, counts)| counts.late > 0);
        faults.extend(late.map(|(service, counts)| Fault::Late {
            service,
            samples: counts.late,
        }));
        faults
    }

    /// Samples that were measured and have no answer, by service.
    fn unanswered(&self, sent: SampleCounts) -> Vec<Fault> {
        let Some(pipeline) = self.processes.pipeline() else {
            return Vec::new();
        };
        let known = sent.samples + sent.unseen;
        let unmeasured = sent.next.saturating_sub(known);
        let fault = |channel: &'static Channel| {
            let answers = self.carried.get(channel.name).copied().unwrap_or_default();
            let service = pipeline.writer(channel)?.name;
            // An answer that the supervisor missed may never have existed: the result is at least what the service counts as not received.
            let samples = known.saturating_sub(answers.samples + answers.unseen);
            // A number that no sample had, as its source was away, is missing there too, and was not to be answered.
            let lost = self.processes.counts_of(service).lost;
            let samples = samples.max(lost.saturating_sub(unmeasured).min(known));
            (samples > 0).then_some(Fault::Unanswered {
                service,
                samples,
                of: known,
            })
        };
        pipeline.estimates().filter_map(fault).collect()
    }
}

#[cfg(test)]
mod tests {
    use messages::channels::{EXCAVATOR_TRUTH, HEALTH};
    use messages::{ExcavatorEstimate, ExcavatorTruth, Health, Machine};
    use runtime::Sink as _;
    use steps::stages::Pipeline;

    use super::*;
    use crate::watch::Show;

    #[test]
    fn what_may_lack_in_the_recording_is_reported_unless_the_logger_has_counted_it() {
        let (dies, comes, is_back, reports) = (1, 2, 3, 4);
        let lost = |story: &[u32]| {
            let mut watch = Watch::new(Machine::Excavator, None, None, Show::Nothing);
            for &event in story {
                if event == dies {
                    let (service, how) = ("logger", "killed".to_owned());
                    watch.note(Fault::Died { service, how });
                } else if event == comes {
                    watch.accept(&EXCAVATOR_TRUTH, &ExcavatorTruth::default());
                } else if event == is_back {
                    watch.is_there("logger");
                } else {
                    let names = Pipeline::of(Machine::Excavator);
                    let process = (0..).find(|i| names.process_name(*i) == "logger");
                    let mut health = Health::default();
                    (health.process, health.steps) = (process.expect("a row"), 1);
                    watch.accept(&HEALTH, &health);
                }
            }
            watch.finish();
            let faults = watch.faults();
            faults.iter().any(|f| matches!(f, Fault::Unrecorded { .. }))
        };
        assert!(lost(&[is_back, comes, reports, dies, comes]));
        assert!(!lost(&[is_back, dies]), "nothing came");
        let whole = [is_back, comes, reports, dies, comes, is_back, comes];
        assert!(!lost(&whole), "it counts by itself what it lacks");
        let silent = [&whole[..], &[dies, is_back, reports]].concat();
        assert!(lost(&silent), "what the second one lacked is not known");
        let reported = [&whole[..], &[reports, dies, is_back, reports]].concat();
        assert!(!lost(&reported));
    }

    #[test]
    fn what_a_service_did_not_receive_is_unanswered_though_the_supervisor_missed_the_answers_too() {
        let lost = |count: u64, sequence: u64| {
            let mut watch = Watch::new(Machine::Excavator, None, None, Show::Nothing);
            watch.accept(&EXCAVATOR_TRUTH, &ExcavatorTruth::default());
            for estimates in Pipeline::of(Machine::Excavator).estimates() {
                watch.accept(estimates, &ExcavatorEstimate::default());
            }
            if sequence > 0 {
                let mut truth = ExcavatorTruth::default();
                (truth.stamp.sequence, truth.stamp.epoch) = (sequence, 1);
                watch.accept(&EXCAVATOR_TRUTH, &truth);
                for estimates in Pipeline::of(Machine::Excavator).estimates() {
                    let estimate = ExcavatorEstimate {
                        stamp: truth.stamp,
                        ..ExcavatorEstimate::default()
                    };
                    watch.accept(estimates, &estimate);
                }
            }
            let names = Pipeline::of(Machine::Excavator);
            let process = (0..).find(|i| names.process_name(*i) == "rls");
            let mut health = Health::default();
            (health.process, health.steps) = (process.expect("a row"), 1);
            health.lost = count;
            watch.accept(&HEALTH, &health);
            watch.finish();
            watch.faults()
        };
        assert_eq!(lost(0, 0), []);
        // A source that was away left out the numbers 1 to 270.
        let away = lost(270, 271);
        assert_eq!(away, [Fault::Unmeasured { samples: 270 }]);
        let (service, samples, of) = ("rls", 1, 1);
        assert_eq!(
            lost(270, 0),
            [Fault::Unanswered {
                service,
                samples,
                of
            }]
        );
    }

    #[test]
    fn a_service_that_dies_again_and_again_is_one_fault_with_its_count() {
        let mut watch = Watch::new(Machine::Excavator, None, None, Show::Nothing);
        let died = |service| Fault::Died {
            service,
            how: "exit status: 2".into(),
        };
        for _ in 0..45 {
            watch.note(died("ukf"));
            watch.note(died("kalman"));
        }
        watch.note(died("rls"));
        let said = watch
            .faults()
            .iter()
            .map(|f| watch.fault_words(f))
            .collect::<Vec<_>>();
        assert_eq!(
            said,
            [
                "ukf died (exit status: 2); it was started again (45 times)",
                "kalman died (exit status: 2); it was started again (45 times)",
                "rls died (exit status: 2); it was started again",
            ]
        );
    }

    #[test]
    fn a_sample_is_late_only_where_it_was_due_at_a_time() {
        let mut watch = Watch::new(Machine::Excavator, None, None, Show::Nothing);
        let health = Health {
            late: 3,
            ..Health::default()
        };
        watch.accept(&HEALTH, &health);
        let late = |watch: &Watch| {
            watch
                .faults()
                .iter()
                .any(|f| matches!(f, Fault::Late { .. }))
        };
        assert!(late(&watch));
        watch.unpaced();
        assert!(!late(&watch));
    }
}
