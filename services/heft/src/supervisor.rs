//! The supervisor: creates and holds every channel, starts each service as a process of its own,
//! restarts what dies, and ends the run with everything drained.

use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use messages::channels::{Channel, of_machine};
use runtime::{Bell, Cleaner, Domain, Heard, Held, Owner, Ports, Taps, now_ns};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use steps::stages::{Pipeline, Role};

use crate::failure::Failure;
use crate::parts;
use crate::plan::Plan;
use crate::watch::Watch;
use crate::worker::Worker;

/// A worker must have its ports open by then.
const READY_LIMIT: Duration = Duration::from_secs(20);
/// A worker must have answered what was waiting by then.
const DRAIN_LIMIT: Duration = Duration::from_secs(15);
/// A worker must have ended by then.
const EXIT_LIMIT: Duration = Duration::from_secs(12);
/// What dead processes held is usually freed within a millisecond.
const CLEAN_UP_LIMIT: Duration = Duration::from_millis(200);
/// Time between two looks at signals, and at the channels that the terminal and the page show.
const LOOK: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 10_000_000,
};

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum End {
    /// The source had no more samples.
    Finished,
    /// A signal asked for it.
    Interrupted,
    /// A service died again and again.
    Failed(String),
}

/// A pipeline and its processes.
pub struct Supervisor {
    workers: Vec<Worker>,
    watch: Watch,
    taps: Taps<Watch>,
    cleaner: Cleaner,
    _channels: Vec<Held>,
    _ports: Ports,
    signal: Arc<AtomicBool>,
    start_ns: u64,
    ended: bool,
    plan: Plan,
    owner: Owner,
}

impl Supervisor {
    /// Takes the domain, creates the channels and starts every process of the plan's machine.
    pub fn start(
        domain: &Domain,
        plan: Plan,
        watch: Watch,
        signal: Arc<AtomicBool>,
    ) -> Result<Self, Failure> {
        let owner = domain.take()?;
        plan.write(owner.domain())?;
        owner.domain().enter()?;
        let ports = Ports::new("supervisor")?;
        owner.close_to_others()?;
        let channels: Vec<&'static Channel> = of_machine(plan.machine).collect();
        let held = channels
            .iter()
            .map(|c| ports.create(c))
            .collect::<Result<_, _>>()?;
        let read: Vec<_> = channels
            .iter()
            .copied()
            .filter(|c| watch.reads(c))
            .collect();
        let taps = Taps::open(&ports, &read)?;
        let mut supervisor = Self {
            workers: Vec::new(),
            watch,
            taps,
            cleaner: Cleaner::start(),
            _channels: held,
            _ports: ports,
            signal,
            start_ns: 0,
            ended: false,
            plan,
            owner,
        };
        supervisor.spawn_all()?;
        Ok(supervisor)
    }

    fn spawn_all(&mut self) -> Result<(), Failure> {
        let table = Pipeline::of(self.plan.machine).stages;
        let wanted = table
            .iter()
            .enumerate()
            .filter(|(_, p)| !matches!(p.role, Role::Probe(_)) || self.plan.probe.is_some());
        let bells = table
            .iter()
            .map(|_| Bell::new())
            .collect::<Result<Vec<_>, _>>()?;
        for (index, process) in wanted {
            let bell = bells[index].try_clone()?;
            let worker = Worker::start(process, bell, self.owner.domain())?;
            self.workers.push(worker);
        }
        (0..self.workers.len()).try_for_each(|i| self.hand_over(i))
    }

    /// Gives a worker its own bell and those of the processes that it wakes.
    fn hand_over(&self, index: usize) -> Result<(), Failure> {
        let worker = &self.workers[index];
        let mut bells = vec![&worker.bell];
        for name in worker.process.wakes {
            bells.extend(
                self.workers
                    .iter()
                    .filter(|w| w.process.name == *name)
                    .map(|w| &w.bell),
            );
        }
        Ok(worker.control.hand_over(&bells)?)
    }

    /// Runs until the source ends, a signal comes, or a service cannot be kept alive; then drains
    /// and ends every process. Returns what was seen.
    pub fn run(mut self) -> Result<(End, Watch), Failure> {
        let end = match self.wait_until_ready() {
            Some(end) => end,
            None => {
                self.start_ns = now_ns() + 20_000_000;
                // Downstream first: everyone listens before the source begins.
                for i in (0..self.workers.len()).rev() {
                    self.say_go(i);
                }
                self.watch_over()
            }
        };
        // Before `go` there is nothing to drain.
        if self.start_ns != 0 && !matches!(end, End::Failed(_)) {
            self.drain();
        }
        self.end_all();
        self.taps.drain(&mut self.watch);
        self.watch.finish();
        let is_sink = |w: &&Worker| matches!(w.process.role, Role::Sink);
        let logger = self.workers.iter().find(is_sink);
        parts::join(&self.plan.recording, logger.map_or(0, |w| w.restarts))?;
        Ok((end, std::mem::take(&mut self.watch)))
    }

    fn wait_until_ready(&mut self) -> Option<End> {
        let begun = Instant::now();
        while !self.workers.iter().all(|w| w.ready) {
            if let Some(end) = self.look() {
                return Some(end);
            }
            if let Some(late) = self.workers.iter().find(|w| !w.ready)
                && begun.elapsed() > READY_LIMIT
            {
                return Some(End::Failed(format!(
                    "{} did not get ready",
                    late.process.name
                )));
            }
        }
        None
    }

    fn watch_over(&mut self) -> End {
        loop {
            if let Some(end) = self.look() {
                return end;
            }
            if self.ended {
                return End::Finished;
            }
        }
    }

    /// One look at everything: words of the workers, deaths, signals, channels.
    fn look(&mut self) -> Option<End> {
        self.wait_for_words();
        if self.signal.load(Ordering::Relaxed) {
            return Some(End::Interrupted);
        }
        for i in 0..self.workers.len() {
            if let Err(reason) = self.keep_alive(i) {
                return Some(End::Failed(reason));
            }
        }
        self.taps.drain(&mut self.watch);
        self.watch.tick();
        None
    }

    fn wait_for_words(&mut self) {
        let mut fds: Vec<PollFd> = self
            .workers
            .iter()
            .filter(|w| !w.is_to_be_restarted())
            .map(|w| PollFd::from_borrowed_fd(w.control.as_fd(), PollFlags::IN))
            .collect();
        let _ = poll(&mut fds, Some(&LOOK));
        drop(fds);
        for i in 0..self.workers.len() {
            while let Heard::Word(word) = self.workers[i].control.hear(0) {
                match word.as_str() {
                    "ready" => self.is_ready(i),
                    "ended" => self.ended = true,
                    "drained" => self.workers[i].drained = true,
                    _ => {}
                }
            }
        }
    }

    fn is_ready(&mut self, i: usize) {
        self.workers[i].ready = true;
        if self.start_ns != 0 {
            self.say_go(i);
        }
    }

    /// A source begins after the last sample that was seen: 0, unless it has been restarted.
    fn say_go(&self, i: usize) {
        let first = self.watch.next_sequence();
        self.workers[i]
            .control
            .say(&format!("go {first} {}", self.start_ns));
    }

    /// Notices a death and restarts; `Err` with the reason when there is no point in it.
    fn keep_alive(&mut self, i: usize) -> Result<(), String> {
        let worker = &mut self.workers[i];
        if worker.is_to_be_restarted() {
            return if worker.is_due() {
                self.restart(i)
            } else {
                Ok(())
            };
        }
        let Some(status) = worker.died() else {
            return Ok(());
        };
        worker.plan_restart(status)?;
        let name = worker.process.name;
        tracing::warn!(service = name, %status, "a service died; it is started again");
        self.watch.note_death(name, &status.to_string());
        Ok(())
    }

    fn restart(&mut self, i: usize) -> Result<(), String> {
        // What the dead process held in the channels would otherwise count against their limits.
        if !self.cleaner.clean_up(CLEAN_UP_LIMIT) {
            tracing::warn!(
                "what the dead held is not free yet; the service is started all the same"
            );
        }
        self.taps.drain(&mut self.watch);
        self.workers[i]
            .restart(self.owner.domain())
            .and_then(|()| self.hand_over(i))
            .map_err(|e| e.to_string())
    }

    /// Upstream first, so that nobody is asked before its writer has said its last word.
    fn drain(&mut self) {
        for i in 0..self.workers.len() {
            self.workers[i].drained = false;
            if !self.workers[i].control.say("drain") {
                continue;
            }
            let begun = Instant::now();
            while !self.workers[i].drained && begun.elapsed() < DRAIN_LIMIT {
                self.wait_for_words();
                self.taps.drain(&mut self.watch);
                if !self.workers[i].is_alive() {
                    break;
                }
            }
        }
    }

    fn end_all(&mut self) {
        for worker in &self.workers {
            worker.control.say("exit");
        }
        let begun = Instant::now();
        for worker in &mut self.workers {
            while worker.is_alive() {
                if begun.elapsed() > EXIT_LIMIT {
                    tracing::error!(service = worker.process.name, "did not end; killed");
                    worker.kill();
                    break;
                }
                self.taps.drain(&mut self.watch);
                std::thread::sleep(Duration::from_millis(2));
            }
        }
    }
}

impl Drop for Supervisor {
    /// An error on the way must not leave processes behind.
    fn drop(&mut self) {
        for worker in &mut self.workers {
            if worker.is_alive() {
                worker.kill();
            }
        }
    }
}
