//! The supervisor: creates and holds every channel, starts each service as a process of its own,
//! restarts what dies, and ends the run with everything drained.

use std::os::fd::{AsFd, OwnedFd};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use messages::channels::{Channel, of_machine};
use runtime::{Bell, Control, Domain, Heard, Held, Owner, Ports, Taps, now_ns};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::failure::Failure;
use crate::parts;
use crate::plan::Plan;
use crate::processes::{self, Process};
use crate::watch::Watch;

/// A worker must have its ports open by then.
const READY_LIMIT: Duration = Duration::from_secs(20);
/// A worker must have answered what was waiting by then.
const DRAIN_LIMIT: Duration = Duration::from_secs(15);
/// A worker must have ended by then.
const EXIT_LIMIT: Duration = Duration::from_secs(12);
/// A worker that lives no longer than this after its start died quickly.
const QUICK: Duration = Duration::from_millis(300);
/// So many quick deaths in a row end the run.
const MAX_QUICK_DEATHS: u32 = 5;
const FIRST_BACK_OFF: Duration = Duration::from_millis(5);
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

struct Worker {
    process: &'static Process,
    bell: Bell,
    control: Control,
    child: Child,
    started: Instant,
    ready: bool,
    drained: bool,
    restarts: u32,
    quick_deaths: u32,
    due: Option<Instant>,
}

/// A pipeline and its processes.
pub struct Supervisor {
    workers: Vec<Worker>,
    watch: Watch,
    taps: Taps<Watch>,
    ports: Ports,
    _channels: Vec<Held>,
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
        plan.write(domain)?;
        domain.enter()?;
        let ports = Ports::new("supervisor")?;
        let channels: Vec<&'static Channel> = of_machine(&plan.machine).collect();
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
            ports,
            _channels: held,
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
        let table = processes::of_machine(self.plan.kind());
        let wanted = table
            .iter()
            .enumerate()
            .filter(|(_, p)| p.name != "probe" || self.plan.probe.is_some());
        let bells = table
            .iter()
            .map(|_| Bell::new())
            .collect::<Result<Vec<_>, _>>()?;
        for (index, process) in wanted {
            let (control, child) = self.spawn(process, 0)?;
            self.workers.push(Worker {
                process,
                bell: bells[index].try_clone()?,
                control,
                child,
                started: Instant::now(),
                ready: false,
                drained: false,
                restarts: 0,
                quick_deaths: 0,
                due: None,
            });
        }
        (0..self.workers.len()).try_for_each(|i| self.hand_over(i))
    }

    fn spawn(&self, process: &Process, restarts: u32) -> Result<(Control, Child), Failure> {
        use std::os::unix::process::CommandExt;
        let (control, theirs): (Control, OwnedFd) = Control::pair()?;
        let exe = std::env::current_exe().map_err(Failure::internal)?;
        let child = Command::new(exe)
            .args([
                "service",
                process.name,
                "--domain",
                self.owner.domain().name(),
            ])
            .args(["--restarts", &restarts.to_string()])
            .stdin(Stdio::from(theirs))
            // A group of its own: Ctrl-C reaches the supervisor alone, which ends the run in order.
            .process_group(0)
            .spawn()
            .map_err(|e| {
                Failure::input(
                    format!("cannot start the service {}: {e}", process.name),
                    "the supervisor",
                    "check the limits on processes and memory",
                )
            })?;
        Ok((control, child))
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
        let logger = self.workers.iter().find(|w| w.process.name == "logger");
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
            .filter(|w| w.due.is_none())
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
        if let Some(due) = self.workers[i].due {
            return if Instant::now() < due {
                Ok(())
            } else {
                self.restart(i)
            };
        }
        let Ok(Some(status)) = self.workers[i].child.try_wait() else {
            return Ok(());
        };
        let worker = &mut self.workers[i];
        let name = worker.process.name;
        worker.quick_deaths = if worker.started.elapsed() < QUICK {
            worker.quick_deaths + 1
        } else {
            0
        };
        if worker.quick_deaths >= MAX_QUICK_DEATHS || (status.code() == Some(2) && !worker.ready) {
            return Err(format!("the service {name} does not stay alive ({status})"));
        }
        worker.due = Some(Instant::now() + FIRST_BACK_OFF * 2u32.pow(worker.quick_deaths));
        worker.ready = false;
        tracing::warn!(service = name, %status, "a service died; it is started again");
        self.watch.note_death(name, &status.to_string());
        Ok(())
    }

    fn restart(&mut self, i: usize) -> Result<(), String> {
        // What the dead process held in the channels would otherwise count against their limits.
        self.ports.clean_up_after_the_dead();
        self.taps.drain(&mut self.watch);
        let restarts = self.workers[i].restarts + 1;
        let (control, child) = self
            .spawn(self.workers[i].process, restarts)
            .map_err(|e| e.to_string())?;
        let worker = &mut self.workers[i];
        worker.control = control;
        worker.child = child;
        worker.restarts = restarts;
        worker.started = Instant::now();
        worker.due = None;
        self.hand_over(i).map_err(|e| e.to_string())
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
                if !matches!(self.workers[i].child.try_wait(), Ok(None)) {
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
            while matches!(worker.child.try_wait(), Ok(None)) {
                if begun.elapsed() > EXIT_LIMIT {
                    tracing::error!(service = worker.process.name, "did not end; killed");
                    let _ = worker.child.kill();
                    let _ = worker.child.wait();
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
            if matches!(worker.child.try_wait(), Ok(None)) {
                let _ = worker.child.kill();
                let _ = worker.child.wait();
            }
        }
    }
}
