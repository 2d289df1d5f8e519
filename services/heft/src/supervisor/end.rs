//! The end of a run: drains the channels, ends every worker, and leaves one recording.

use std::time::{Duration, Instant};

use runtime::now_ns;

use super::{QUICK_LOOK, Supervisor};
use crate::fault::Fault;
use crate::parts;
use crate::supervised::Supervised;

/// Time in which all workers must have answered the waiting samples, and the disk taken them.
const DRAIN_LIMIT: Duration = Duration::from_millis(3500);
/// Time after that in which all workers must have ended.
const EXIT_LIMIT: Duration = Duration::from_secs(1);

impl Supervisor {
    /// Counts the samples that were due while the source was away at the end of the run: they leave no gap in the numbers.
    pub(super) fn note_what_was_due(&mut self) {
        let away = self
            .workers
            .iter()
            .find(|w| w.is_source())
            .is_some_and(|w| !w.ready);
        if away && !self.plan.lossless {
            let seconds = now_ns().saturating_sub(self.start_ns) as f64 * 1e-9;
            let due = (seconds * self.plan.rate) as u64;
            let samples = due.saturating_sub(self.watch.next_sequence());
            self.watch.note(Fault::Unmeasured { samples });
        }
    }

    /// Upstream first, so that each writer has sent its last message before its readers are drained.
    pub(super) fn drain(&mut self) {
        let begun = Instant::now();
        for i in 0..self.workers.len() {
            self.workers[i].drained = false;
            self.workers[i].control.say("drain");
            while !self.workers[i].drained && begun.elapsed() < DRAIN_LIMIT {
                self.wait(QUICK_LOOK);
                self.end_hanging();
                self.bury();
                if !self.workers[i].is_alive() {
                    break;
                }
            }
        }
    }

    /// Notes the deaths of workers that are not restarted.
    fn bury(&mut self) {
        for worker in &mut self.workers {
            let service = worker.process.name;
            // Dead, and not restarted.
            if worker.due().is_some() {
                worker.give_up();
            }
            let Some(status) = worker.died() else {
                continue;
            };
            worker.give_up();
            if let Some(silence) = worker.hung {
                self.watch.note(Fault::Hung {
                    service,
                    silence,
                    again: false,
                });
            } else if !status.success() {
                let how = status.to_string();
                self.watch.note(Fault::DiedAtEnd { service, how });
            }
        }
    }

    pub(super) fn end_all(&mut self) {
        for worker in &self.workers {
            worker.control.say("exit");
        }
        let begun = Instant::now();
        while self.workers.iter_mut().any(Supervised::is_alive) && begun.elapsed() < EXIT_LIMIT {
            self.wait(QUICK_LOOK);
            self.bury();
        }
        self.bury();
        for worker in &mut self.workers {
            if worker.is_alive() {
                let service = worker.process.name;
                if worker.ready {
                    self.watch.note(Fault::DidNotEnd { service });
                }
                worker.kill_and_wait();
            }
        }
    }

    /// Joins what several loggers wrote.
    pub(super) fn finish_recording(&mut self) {
        if let Err(failure) = parts::finish(&self.plan.recording, self.plan.group) {
            let why = failure.to_string().replace('\n', ";");
            self.watch.note(Fault::NotJoined { why });
        }
    }
}
