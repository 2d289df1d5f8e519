//! Detects whether a thread hangs, by observing it periodically. The cost is one store
//! before and after each piece of work.

use std::fs;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::clock::thread_ns;

/// Processor time between two observations below which a thread that wants to run is delayed by
/// other threads and does not hang [ns].
const SHARE: u64 = 100_000_000;
/// Number of observations of the same piece of work after which the thread hangs in any case.
const PATIENCE: u32 = 12;

/// Counter of the working thread: odd while it works.
#[derive(Debug, Default)]
pub(crate) struct Turn(AtomicU64);

impl Turn {
    /// Marks the start of a piece of work.
    pub(crate) fn begin(&self) {
        self.0
            .store(self.0.load(Ordering::Relaxed) | 1, Ordering::Relaxed);
    }

    /// Marks its end.
    pub(crate) fn end(&self) {
        let turn = self.0.load(Ordering::Relaxed);
        self.0.store((turn | 1) + 1, Ordering::Relaxed);
    }
}

/// State of the observing thread.
#[derive(Debug)]
pub(crate) struct Pulse {
    thread: String,
    seen: u64,
    looks: u32,
    ran: u64,
}

impl Pulse {
    /// Observer of `thread` of this process.
    pub(crate) fn of(thread: rustix::process::Pid) -> Self {
        Self {
            thread: format!("/proc/self/task/{}", thread.as_raw_nonzero()),
            seen: 0,
            looks: 0,
            ran: 0,
        }
    }

    /// Makes one observation: whether the thread has been at the same piece of work since an earlier one, though
    /// it had the time to end it.
    pub(crate) fn hangs(&mut self, turn: &Turn) -> bool {
        let now = turn.0.load(Ordering::Relaxed);
        if now.is_multiple_of(2) || now != self.seen {
            (self.seen, self.looks) = (now, 0);
            self.ran = if now.is_multiple_of(2) {
                0
            } else {
                self.processor_ns()
            };
            return false;
        }
        self.looks += 1;
        let held_up = self.wants_to_run() && self.processor_ns().saturating_sub(self.ran) < SHARE;
        !held_up || self.looks > PATIENCE
    }

    /// Processor time of the thread so far [ns].
    fn processor_ns(&self) -> u64 {
        thread_ns(&self.thread)
    }

    /// Whether the thread waits for a processor or for the disk.
    fn wants_to_run(&self) -> bool {
        matches!(state(&format!("{}/stat", self.thread)), Some('R' | 'D'))
    }
}

/// State of a process or thread, as the kernel names it in the `stat` file at `path`.
pub(crate) fn state(path: &str) -> Option<char> {
    let text = fs::read_to_string(path).ok()?;
    // The preceding name is in parentheses and may contain any character.
    text.rsplit_once(") ")?.1.chars().next()
}

/// Whether a process is stopped, by a signal or a debugger.
pub fn is_stopped(pid: u32) -> bool {
    matches!(state(&format!("/proc/{pid}/stat")), Some('T' | 't'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    fn looks_at(work: impl FnOnce(Arc<Turn>) + Send + 'static) -> bool {
        let turn = Arc::new(Turn::default());
        let its = Arc::clone(&turn);
        let (sender, receiver) = channel();
        std::thread::spawn(move || {
            sender.send(rustix::thread::gettid()).unwrap();
            work(its);
        });
        let mut pulse = Pulse::of(receiver.recv().unwrap());
        (0..3).any(|_| {
            std::thread::sleep(Duration::from_millis(150));
            pulse.hangs(&turn)
        })
    }

    #[test]
    fn a_step_that_never_ends_is_found_whether_it_spins_or_sleeps() {
        assert!(looks_at(|turn| {
            turn.begin();
            let begun = std::time::Instant::now();
            while begun.elapsed() < Duration::from_secs(2) {
                std::hint::spin_loop();
            }
        }));
        assert!(looks_at(|turn| {
            turn.begin();
            std::thread::sleep(Duration::from_secs(2));
        }));
    }

    #[test]
    fn a_thread_that_waits_for_work_or_goes_on_with_it_does_not_hang() {
        assert!(!looks_at(|turn| {
            turn.begin();
            turn.end();
            std::thread::sleep(Duration::from_secs(2));
        }));
        assert!(!looks_at(|turn| for _ in 0..200 {
            turn.begin();
            std::thread::sleep(Duration::from_millis(5));
            turn.end();
        }));
    }
}
