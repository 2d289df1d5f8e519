//! The supervisor creates and holds every channel, and starts each service as a process of its own (with `--threads` as a thread).
//! It restarts services that die or hang, and drains all channels at the end of the run.
//!
//! It sleeps until an event: a message of a worker, the end of a process, a signal, a restart
//! that is due. Only the channels that it shows are polled, five times a second.

mod end;
mod restarts;
mod words;

use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use messages::channels::{Channel, of_machine};
use runtime::{Bell, ChannelOwner, Cleaner, Domain, Owner, Ports, Taps, Window, now_ns};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use steps::stages::{Pipeline, Role};

use crate::failure::Failure;
use crate::fleet::Gateway;
use crate::notify::Notify;
use crate::plan::Plan;
use crate::signals::Signals;
use crate::spare::{self, Spare};
use crate::supervised::Supervised;
use crate::watch::Watch;

/// Time in which a worker must open its ports.
const READY_LIMIT: Duration = Duration::from_secs(20);
/// Longest time between two reads of the channels: health reports show a hanging service.
const LOOK: Duration = Duration::from_millis(200);
/// The same while a service stands still.
const SUSPECT_LOOK: Duration = Duration::from_millis(50);
/// Longest time between two reads in samples: a quarter of the depth of a channel.
const LOOK_SAMPLES: f64 = 128.0;
/// Longest time between two reads where the source is as fast as its readers.
const QUICK_LOOK: Duration = Duration::from_millis(2);

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum End {
    /// The source had no more samples.
    Finished,
    /// A signal asked for it.
    Interrupted,
    /// A service died again and again.
    Failed(String),
    /// The source cannot use its input: what, where, what to do.
    Refused(String),
}

/// A pipeline and its processes.
pub struct Supervisor {
    workers: Vec<Supervised>,
    watch: Watch,
    taps: Taps<Watch>,
    cleaner: Cleaner,
    spare: Spare,
    _channels: Vec<ChannelOwner>,
    _ports: Ports,
    gateway: Option<Gateway>,
    signals: Signals,
    notify: Notify,
    look: Duration,
    start_ns: u64,
    /// Latest sequence number read by this process, as sent to a lossless source.
    said_seen: Option<u64>,
    ended: bool,
    refused: Option<String>,
    plan: Plan,
    owner: Owner,
}

impl Supervisor {
    /// Takes the domain, creates the channels and starts every process of the plan's machine.
    pub fn start(
        domain: &Domain,
        plan: Plan,
        mut watch: Watch,
        signals: Signals,
    ) -> Result<Self, Failure> {
        spare::check_limit(plan.threads)?;
        if plan.lossless {
            watch.unpaced();
        }
        let owner = domain.take()?;
        plan.write(owner.domain())?;
        owner.domain().enter()?;
        let ports = Ports::new("supervisor")?;
        owner.close_to_others()?;
        if let Some(group) = plan.group {
            watch.show_to_group(Window::open(owner.domain(), plan.machine, group)?);
        }
        let channels: Vec<&'static Channel> = of_machine(plan.machine).collect();
        let held = channels
            .iter()
            .map(|c| ports.create(c))
            .collect::<Result<_, _>>()?;
        watch.tell_loads(ports.teller(steps::loads::channel(plan.machine))?);
        let read: Vec<_> = channels
            .iter()
            .copied()
            .filter(|c| watch.reads(c))
            .collect();
        let mut taps = Taps::open(&ports, &read)?;
        // A fast source may have overwritten its first samples before the first read.
        taps.count_from(0);
        let look = if plan.lossless {
            QUICK_LOOK
        } else {
            LOOK.min(Duration::from_secs_f64(LOOK_SAMPLES / plan.rate))
        };
        let mut supervisor = Self {
            workers: Vec::new(),
            watch,
            taps,
            cleaner: Cleaner::start()?,
            spare: Spare::default(),
            _channels: held,
            _ports: ports,
            gateway: None,
            signals,
            notify: Notify::of_environment(),
            look,
            start_ns: 0,
            said_seen: None,
            ended: false,
            refused: None,
            plan,
            owner,
        };
        supervisor.spawn_all()?;
        let fleet = supervisor.plan.fleet.clone();
        supervisor.gateway = fleet.map(|f| Gateway::start(f, supervisor.owner.domain()));
        supervisor.spare.fill();
        Ok(supervisor)
    }

    fn spawn_all(&mut self) -> Result<(), Failure> {
        let table = Pipeline::of(self.plan.machine).stages;
        let wanted = table.iter().filter(|p| match p.role {
            Role::Probe(_) => self.plan.probe.is_some(),
            Role::Sender => self.plan.output.is_some(),
            Role::Source { .. } | Role::Step(_) | Role::Sink => true,
        });
        for process in wanted {
            let worker =
                Supervised::start(process, Bell::new()?, (self.owner.domain(), &self.plan))?;
            self.workers.push(worker);
        }
        for i in 0..self.workers.len() {
            self.hand_over(i);
        }
        Ok(())
    }

    /// Runs until the source ends, a signal comes, or a service cannot be kept alive; then drains
    /// and ends every process. Returns what was seen.
    pub fn run(mut self) -> Result<(End, Watch), Failure> {
        let end = match self.wait_until_ready() {
            Some(end) => end,
            None => {
                self.notify.say("READY=1");
                self.start_ns = now_ns() + 20_000_000;
                // Downstream first: every reader listens before the source begins.
                for i in (0..self.workers.len()).rev() {
                    self.say_go(i);
                }
                self.watch_over()
            }
        };
        self.notify.say("STOPPING=1");
        let stopping = Instant::now();
        // Before `go` there is nothing to drain.
        if self.start_ns != 0 && !matches!(end, End::Failed(_)) {
            self.note_what_was_due();
            self.drain();
        }
        self.end_all();
        self.taps.drain(&mut self.watch);
        self.watch.finish();
        self.finish_recording();
        let (watch, notify) = (
            std::mem::take(&mut self.watch),
            std::mem::take(&mut self.notify),
        );
        // A failed run is restarted at once, and does not wait for its gateway.
        let waits = notify.has_manager() && !matches!(end, End::Failed(_));
        if let (Some(gateway), End::Failed(_)) = (&self.gateway, &end) {
            gateway.gave_up();
        }
        let gateway = self.gateway.take().filter(|_| waits);
        // The gateway detects the end by the domain.
        drop(self);
        if let Some(gateway) = gateway {
            gateway.wait(stopping, notify);
        }
        Ok((end, watch))
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
            if let Some(error) = self.refused.take() {
                return End::Refused(error);
            }
            if self.ended {
                return End::Finished;
            }
        }
    }

    /// Waits for an event and handles it: messages of workers, deaths, signals, channels.
    fn look(&mut self) -> Option<End> {
        self.wait(self.look);
        if self.signals.came() {
            return Some(End::Interrupted);
        }
        for i in 0..self.workers.len() {
            if let Err(reason) = self.keep_alive(i) {
                return Some(End::Failed(reason));
            }
        }
        self.end_hanging();
        // A thread ends only with the run.
        let stuck = |w: &&Supervised| w.hung.is_some() && !w.can_be_killed();
        if let Some(worker) = self.workers.iter().find(stuck) {
            return Some(End::Failed(format!(
                "the thread {} stands still; without --threads it would be started again",
                worker.process.name
            )));
        }
        if let Some(gateway) = &mut self.gateway {
            gateway.keep_alive();
        }
        self.watch.tick();
        None
    }

    /// Sleeps until a worker sends a message or ends, a signal arrives, a restart is due, or `limit` is over. Then
    /// reads all messages of workers and channels.
    fn wait(&mut self, limit: Duration) {
        let due = self.workers.iter().filter_map(Supervised::due).min();
        let until_due = due.map(|due| due.saturating_duration_since(Instant::now()));
        let limit = until_due.map_or(limit, |d| d.min(limit));
        let suspect = self.workers.iter().any(Supervised::is_suspect);
        let limit = if suspect {
            limit.min(SUSPECT_LOOK)
        } else {
            limit
        };
        let timeout = Timespec {
            tv_sec: limit.as_secs() as i64,
            tv_nsec: limit.subsec_nanos().into(),
        };
        // A signal that came already is handled, and would end every wait.
        let signal = (!self.signals.came()).then(|| self.signals.as_fd());
        let signs = self
            .workers
            .iter()
            .flat_map(Supervised::signs)
            .chain(signal);
        let mut fds: Vec<PollFd> = signs
            .map(|fd| PollFd::from_borrowed_fd(fd, PollFlags::IN))
            .collect();
        let _ = poll(&mut fds, Some(&timeout));
        self.hear();
        self.taps.drain(&mut self.watch);
        if self.plan.lossless {
            self.say_seen();
        }
        self.notify.awake();
    }
}

impl Drop for Supervisor {
    /// An early error must not leave processes behind.
    fn drop(&mut self) {
        for worker in &mut self.workers {
            if worker.is_alive() {
                worker.kill_and_wait();
            }
        }
    }
}
