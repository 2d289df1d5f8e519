//! One service of a run as its supervisor sees it: its life, its control channel, its deaths.

use std::os::fd::{AsFd, BorrowedFd};
use std::process::ExitStatus;
use std::time::{Duration, Instant};

use messages::{Health, State};
use runtime::{Bell, Control, Domain, Needs, is_stopped, now_ns};
use steps::stages::{Role, Stage};

use crate::failure::Failure;
use crate::life::Life;
use crate::plan::Plan;

/// Life after a start below which a death is a quick one.
const QUICK: Duration = Duration::from_millis(300);
/// Number of consecutive quick deaths that ends the run.
const MAX_QUICK_DEATHS: u32 = 5;
const FIRST_BACK_OFF: Duration = Duration::from_millis(5);
/// Number of consecutive starts refused by the system that ends the run: five seconds.
const MAX_REFUSALS: u32 = 50;
const REFUSAL_PAUSE: Duration = Duration::from_millis(100);
/// Time for which a lack of memory is waited out: other programs may free it.
const STARVED_LIMIT: Duration = Duration::from_secs(5);
/// Age of a health report above which a process is checked: reports come three times a second.
const LATE: Duration = Duration::from_millis(350);
/// Time after which a stopped process is ended.
const STOPPED_LIMIT: Duration = Duration::from_millis(350);
/// Silence after which a process that has reported its health is ended, though not stopped: longer than any load explains.
const SILENT_LIMIT: Duration = Duration::from_secs(5);

/// A service and its life.
pub struct Supervised {
    /// Its row in the table of processes.
    pub process: &'static Stage,
    /// Wakes it.
    pub bell: Bell,
    /// Control channel.
    pub control: Control,
    /// It has its ports open.
    pub ready: bool,
    /// It has answered all waiting samples.
    pub drained: bool,
    /// Number of restarts.
    pub restarts: u32,
    /// Its silence when it was ended for hanging.
    pub hung: Option<Duration>,
    life: Life,
    started: Instant,
    started_ns: u64,
    /// Since when it was found stopped.
    stopped: Option<Instant>,
    quick_deaths: u32,
    refusals: u32,
    /// Since when it finds no memory to start with.
    starved: Option<Instant>,
    next: Next,
}

/// What happens to a process next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// It lives, as far as is known.
    Lives,
    /// It died, and is started again then.
    Starts(Instant),
    /// It died, and is not restarted.
    Nothing,
}

impl Supervised {
    /// Whether it makes the samples.
    pub fn is_source(&self) -> bool {
        matches!(self.process.role, Role::Source { .. })
    }

    /// Starts it.
    pub fn start(
        process: &'static Stage,
        bell: Bell,
        run: (&Domain, &Plan),
    ) -> Result<Self, Failure> {
        let (control, life) = Life::begin(process, 0, run)?;
        Ok(Self {
            process,
            bell,
            control,
            ready: false,
            drained: false,
            restarts: 0,
            hung: None,
            life,
            started: Instant::now(),
            started_ns: now_ns(),
            stopped: None,
            quick_deaths: 0,
            refusals: 0,
            starved: None,
            next: Next::Lives,
        })
    }

    /// Starts it again. Where the system refuses, another try is planned; `Err` with the
    /// reason when there were too many.
    pub fn restart(&mut self, run: (&Domain, &Plan)) -> Result<(), String> {
        match Life::begin(self.process, self.restarts + 1, run) {
            Ok((control, life)) => {
                (self.control, self.life) = (control, life);
                self.restarts += 1;
                self.refusals = 0;
                self.hung = None;
                self.stopped = None;
                (self.started, self.started_ns) = (Instant::now(), now_ns());
                self.next = Next::Lives;
            }
            Err(refusal) => {
                self.refusals += 1;
                if self.refusals >= MAX_REFUSALS {
                    return Err(refusal.to_string());
                }
                tracing::warn!(service = self.process.name, %refusal, "tried again soon");
                self.next = Next::Starts(Instant::now() + REFUSAL_PAUSE);
            }
        }
        Ok(())
    }

    /// Whether its last death was a quick one.
    pub fn died_quickly(&self) -> bool {
        self.quick_deaths > 0
    }

    /// Whether it lives.
    pub fn is_alive(&mut self) -> bool {
        self.next == Next::Lives && self.life.ended().is_none()
    }

    /// How it ended, unless it lives or its end was handled already.
    pub fn died(&mut self) -> Option<ExitStatus> {
        match self.next {
            Next::Lives => self.life.ended(),
            _ => None,
        }
    }

    /// Marks it as dead for good.
    pub fn give_up(&mut self) {
        self.next = Next::Nothing;
    }

    /// Plans the restart after a death; `Err` with the reason when a restart is pointless.
    pub fn plan_restart(&mut self, status: ExitStatus, domain: &Domain) -> Result<(), String> {
        let is_quick = self.started.elapsed() < QUICK;
        let lack = is_quick.then(|| runtime::lack(&domain.folder(), Needs::Service));
        if let Some(lack) = lack.flatten() {
            return self.wait_for_memory(&format!("{} ({})", lack.what, lack.place));
        }
        self.starved = None;
        self.quick_deaths = if is_quick { self.quick_deaths + 1 } else { 0 };
        // Status 2 at the first start: it refused its task. After a restart, status 2 may mean that its predecessor is not gone yet.
        let refused = status.code() == Some(2) && !self.ready && self.restarts == 0;
        if self.quick_deaths >= MAX_QUICK_DEATHS || refused {
            let name = self.process.name;
            return Err(format!("the service {name} does not stay alive ({status})"));
        }
        self.next = Next::Starts(Instant::now() + FIRST_BACK_OFF * 2u32.pow(self.quick_deaths));
        self.ready = false;
        Ok(())
    }

    /// Plans another start of a service that found no memory; `Err` when the lack lasts.
    fn wait_for_memory(&mut self, lack: &str) -> Result<(), String> {
        let name = self.process.name;
        let since = *self.starved.get_or_insert_with(|| {
            tracing::warn!(service = name, "{lack}; tried again soon");
            Instant::now()
        });
        if since.elapsed() >= STARVED_LIMIT {
            return Err(format!("the service {name} cannot start: {lack}"));
        }
        self.next = Next::Starts(Instant::now() + REFUSAL_PAUSE);
        self.ready = false;
        Ok(())
    }

    /// When to start it again, if it died.
    pub fn due(&self) -> Option<Instant> {
        match self.next {
            Next::Starts(due) => Some(due),
            _ => None,
        }
    }

    /// Descriptors that become readable when it sends a message or ends.
    pub fn signs(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        let lives = self.next == Next::Lives;
        let control = lives.then(|| self.control.as_fd());
        let end = lives.then(|| self.life.end()).flatten();
        control.into_iter().chain(end)
    }

    /// Its silence, if too long: it is stopped, silent, or still at the same
    /// sample though it had the processor. `health` is the latest report under its name.
    pub fn hangs(&mut self, health: Option<&Health>) -> Option<Duration> {
        if self.next != Next::Lives || self.hung.is_some() {
            return None;
        }
        let pid = self.life.pid();
        let health = health.filter(|h| h.pid == pid);
        let last = health.map_or(self.started_ns, |h| h.stamp.measured_ns);
        let silence = Duration::from_nanos(now_ns().saturating_sub(last));
        let stuck = health.is_some_and(|h| h.state == State::Hanging as u32);
        let silent = health.is_some() && silence > SILENT_LIMIT;
        self.stopped =
            (silence > LATE && is_stopped(pid)).then(|| self.stopped.unwrap_or_else(Instant::now));
        let stopped = self.stopped.is_some_and(|s| s.elapsed() >= STOPPED_LIMIT);
        // Threads are stopped together with their supervisor: a single silent thread is stuck.
        let held = (silent || stopped) && self.can_be_killed();
        (stuck || held).then_some(silence)
    }

    /// Whether it is found stopped, and not yet ended for that.
    pub fn is_suspect(&self) -> bool {
        self.stopped.is_some() && self.hung.is_none()
    }

    /// Whether it can be ended by force.
    pub fn can_be_killed(&self) -> bool {
        self.life.can_be_killed()
    }

    /// Ends it by force, without waiting.
    pub fn kill(&mut self) {
        self.life.kill();
    }

    /// Ends it by force and waits for its end, up to a limit.
    pub fn kill_and_wait(&mut self) {
        self.life.kill_and_wait();
        self.give_up();
    }
}
