//! Control messages between the supervisor and its workers.

use runtime::ControlWord;

use super::Supervisor;
use crate::sources::{self, LiveInput};

impl Supervisor {
    /// Gives a worker its own bell and those of the processes that it wakes, unless they spin. A worker that cannot take
    /// them is dead, or is ended: its death is noticed as any other.
    pub(super) fn hand_over(&mut self, index: usize) {
        let worker = &self.workers[index];
        let mut bells = vec![&worker.bell];
        for name in worker.process.wakes {
            bells.extend(
                self.workers
                    .iter()
                    .filter(|w| w.process.name == *name && !self.plan.spinners.contains_key(*name))
                    .map(|w| &w.bell),
            );
        }
        // A worker that dies soon after its start may die of its state: it gets none.
        let before = (worker.restarts > 0 && !worker.died_quickly())
            .then(|| self.watch.processes().state(worker.process.name));
        // The run's own standard input belongs to the source that was asked to read it.
        let reads = worker.is_source() && sources::live(&self.plan) == Some(LiveInput::Lines);
        let input = reads.then(rustix::stdio::stdin);
        let handed = worker.control.hand_over(&bells, before.flatten(), input);
        if handed.is_err() {
            self.workers[index].kill();
        }
    }

    /// A lossless source waits for this process too: a sample that it missed would be neither shown nor counted. Sent only when the
    /// number has changed, so that few messages wait for a stopped source.
    pub(super) fn say_seen(&mut self) {
        let seen = self.taps.through();
        if self.said_seen != Some(seen)
            && let Some(source) = self.workers.iter().find(|w| w.is_source())
        {
            source.control.say(&format!("seen {seen}"));
            self.said_seen = Some(seen);
        }
    }

    pub(super) fn hear(&mut self) {
        for i in 0..self.workers.len() {
            while let ControlWord::Word(word) = self.workers[i].control.hear(0) {
                match word.as_str() {
                    "ready" => self.is_ready(i),
                    "ended" => self.ended = true,
                    "drained" => self.workers[i].drained = true,
                    other => {
                        if let Some(error) = other.strip_prefix("refused ") {
                            self.refused = Some(error.to_owned());
                        }
                    }
                }
            }
        }
    }

    fn is_ready(&mut self, i: usize) {
        self.workers[i].ready = true;
        tracing::info!(service = self.workers[i].process.name, "ready");
        self.taps.drain(&mut self.watch);
        self.watch.is_there(self.workers[i].process.name);
        if self.start_ns != 0 {
            self.say_go(i);
        }
    }

    /// A source begins after the last sample that was seen: 0, unless it has been restarted.
    pub(super) fn say_go(&self, i: usize) {
        let (first, latest) = (self.watch.next_sequence(), self.watch.latest_time());
        let latest_ns = (latest.max(0.0) * 1e9) as u64;
        self.workers[i]
            .control
            .say(&format!("go {first} {} {latest_ns}", self.start_ns));
    }
}
