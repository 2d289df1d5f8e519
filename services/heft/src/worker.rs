//! One service of a run as its supervisor sees it: a process, the way to talk to it, its deaths.

use std::os::fd::OwnedFd;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use runtime::{Bell, Control, Domain};
use steps::stages::Stage;

use crate::failure::Failure;

/// A worker that lives no longer than this after its start died quickly.
const QUICK: Duration = Duration::from_millis(300);
/// So many quick deaths in a row end the run.
const MAX_QUICK_DEATHS: u32 = 5;
const FIRST_BACK_OFF: Duration = Duration::from_millis(5);

/// A service and its process.
pub struct Worker {
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
    child: Child,
    started: Instant,
    quick_deaths: u32,
    /// When to start it again, after a death.
    due: Option<Instant>,
}

impl Worker {
    /// Starts the process.
    pub fn start(process: &'static Stage, bell: Bell, domain: &Domain) -> Result<Self, Failure> {
        let (control, child) = spawn(process, 0, domain)?;
        Ok(Self {
            process,
            bell,
            control,
            ready: false,
            drained: false,
            restarts: 0,
            child,
            started: Instant::now(),
            quick_deaths: 0,
            due: None,
        })
    }

    /// Starts the process again.
    pub fn restart(&mut self, domain: &Domain) -> Result<(), Failure> {
        let restarts = self.restarts + 1;
        (self.control, self.child) = spawn(self.process, restarts, domain)?;
        self.restarts = restarts;
        self.started = Instant::now();
        self.due = None;
        Ok(())
    }

    /// Whether the process lives.
    pub fn is_alive(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// How the process ended, if it did.
    pub fn died(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().ok().flatten()
    }

    /// Plans the restart after a death; `Err` with the reason when there is no point in it.
    pub fn plan_restart(&mut self, status: ExitStatus) -> Result<(), String> {
        self.quick_deaths = if self.started.elapsed() < QUICK {
            self.quick_deaths + 1
        } else {
            0
        };
        if self.quick_deaths >= MAX_QUICK_DEATHS || (status.code() == Some(2) && !self.ready) {
            let name = self.process.name;
            return Err(format!("the service {name} does not stay alive ({status})"));
        }
        self.due = Some(Instant::now() + FIRST_BACK_OFF * 2u32.pow(self.quick_deaths));
        self.ready = false;
        Ok(())
    }

    /// Whether it died and is not yet started again.
    pub fn is_to_be_restarted(&self) -> bool {
        self.due.is_some()
    }

    /// Whether the time to start it again has come.
    pub fn is_due(&self) -> bool {
        self.due.is_some_and(|due| Instant::now() >= due)
    }

    /// Ends the process by force.
    pub fn kill(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn spawn(process: &Stage, restarts: u32, domain: &Domain) -> Result<(Control, Child), Failure> {
    let (control, theirs): (Control, OwnedFd) = Control::pair()?;
    let exe = std::env::current_exe().map_err(Failure::internal)?;
    let child = Command::new(exe)
        .args(["service", process.name, "--domain", domain.name()])
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
