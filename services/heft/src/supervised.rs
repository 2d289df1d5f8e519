//! One service of a run as its supervisor sees it: its life, the way to talk to it, its deaths.

use std::os::fd::{AsFd, BorrowedFd};
use std::process::ExitStatus;
use std::time::{Duration, Instant};

use messages::{Health, State};
use runtime::{Bell, Control, Domain, is_stopped, now_ns};
use steps::stages::{Role, Stage};

use crate::failure::Failure;
use crate::life::Life;
use crate::plan::Plan;

/// A worker that lives no longer than this after its start died quickly.
const QUICK: Duration = Duration::from_millis(300);
/// So many quick deaths in a row end the run.
const MAX_QUICK_DEATHS: u32 = 5;
const FIRST_BACK_OFF: Duration = Duration::from_millis(5);
/// So many starts in a row that the system refused end the run: five seconds.
const MAX_REFUSALS: u32 = 50;
const REFUSAL_PAUSE: Duration = Duration::from_millis(100);
/// A service that starts needs so much shared memory, and so many names there; what others took of it may come back in so long.
const SERVICE_BYTES: u64 = 16 << 20;
const SERVICE_NAMES: u64 = 64;
const STARVED_LIMIT: Duration = Duration::from_secs(5);
/// A process tells its health three times a second; one that is later is looked at.
const LATE: Duration = Duration::from_millis(350);
/// One that is found stopped is left alone for so long.
const STOPPED_LIMIT: Duration = Duration::from_millis(350);
/// One that has reported its health and falls silent, though not stopped: longer than any load explains.
const SILENT_LIMIT: Duration = Duration::from_secs(5);

/// What shared memory lacks for a service to start.
fn lack_of_shared_memory() -> Option<String> {
    let about = rustix::fs::statvfs("/dev/shm").ok()?;
    if about.f_bavail.saturating_mul(about.f_frsize) < SERVICE_BYTES {
        return Some("shared memory (/dev/shm) is full".into());
    }
    // Where names are not counted there are none.
    let is_short = about.f_files > 0 && about.f_favail < SERVICE_NAMES;
    is_short.then(|| "shared memory (/dev/shm) takes no more names".into())
}

/// A service and its life.
pub struct Supervised {
    /// Its row in the table of processes.
    pub process: &'static Stage,
    /// Wakes it.
    pub bell: Bell,
    /// Talks to it.
    pub control: Control,
    /// It has its ports open.
    pub ready: bool,
    /// It has answered what was waiting.
    pub drained: bool,
    /// How often it was started again.
    pub restarts: u32,
    /// How long it had given no sign of life when it was ended for that.
    pub hung: Option<Duration>,
    life: Life,
    started: Instant,
    started_ns: u64,
    /// Since when it was found stopped.
    stopped: Option<Instant>,
    quick_deaths: u32,
    refusals: u32,
    /// Since when it finds no shared memory to start with.
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
    /// It died, and that is all.
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

    /// Whether its last life was a short one.
    pub fn died_quickly(&self) -> bool {
        self.quick_deaths > 0
    }

    /// Whether it lives.
    pub fn is_alive(&mut self) -> bool {
        self.next == Next::Lives && self.life.ended().is_none()
    }

    /// How it ended, if it did and that was not dealt with yet.
    pub fn died(&mut self) -> Option<ExitStatus> {
        match self.next {
            Next::Lives => self.life.ended(),
            _ => None,
        }
    }

    /// Leaves it dead.
    pub fn give_up(&mut self) {
        self.next = Next::Nothing;
    }

    /// Plans the restart after a death; `Err` with the reason when there is no point in it.
    pub fn plan_restart(&mut self, status: ExitStatus) -> Result<(), String> {
        let is_quick = self.started.elapsed() < QUICK;
        if let Some(lack) = is_quick.then(lack_of_shared_memory).flatten() {
            return self.wait_for_memory(&lack);
        }
        self.starved = None;
        self.quick_deaths = if is_quick { self.quick_deaths + 1 } else { 0 };
        // Refused what it was to do; later the reason may be that its predecessor is not gone yet.
        let refused = status.code() == Some(2) && !self.ready && self.restarts == 0;
        if self.quick_deaths >= MAX_QUICK_DEATHS || refused {
            let name = self.process.name;
            return Err(format!("the service {name} does not stay alive ({status})"));
        }
        self.next = Next::Starts(Instant::now() + FIRST_BACK_OFF * 2u32.pow(self.quick_deaths));
        self.ready = false;
        Ok(())
    }

    /// Plans another start of a service that found no shared memory; `Err` when that lasts.
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

    /// What becomes readable when it says something or ends.
    pub fn signs(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        let lives = self.next == Next::Lives;
        let control = lives.then(|| self.control.as_fd());
        let end = lives.then(|| self.life.end()).flatten();
        control.into_iter().chain(end)
    }

    /// How long it has given no sign of life, if too long: it is stopped, silent, or at the same
    /// sample though it had the processor. `health` is the latest that was reported under its name.
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
        // Threads are stopped with their supervisor: one that stands alone is stuck.
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

    /// Ends it by force, and does not wait for that.
    pub fn kill(&mut self) {
        self.life.kill();
    }

    /// Ends it by force and waits until it is gone, but not for ever.
    pub fn kill_and_wait(&mut self) {
        self.life.kill_and_wait();
        self.give_up();
    }
}
