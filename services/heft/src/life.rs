//! The process of a service, or with `--threads` its thread in the supervisor.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use runtime::{Control, Domain};
use rustix::process::{Pid, PidfdFlags, pidfd_open};
use steps::stages::Stage;

use crate::failure::Failure;
use crate::image;
use crate::plan::Plan;
use crate::service;

/// Time in which a killed process must be gone: usually a millisecond, unless the kernel itself holds it.
const KILL_LIMIT: Duration = Duration::from_millis(200);
/// The status of a process that panicked; initial status of a thread.
const PANICKED: u8 = 101;

/// One life of a service.
pub enum Life {
    /// A process, and a descriptor that becomes readable when it ends; missing on old kernels.
    Process(Child, Option<OwnedFd>),
    /// A thread, and the status that a process would have ended with.
    Thread(JoinHandle<()>, Arc<AtomicU8>),
}

impl Life {
    /// Starts a service by the plan, after this number of restarts; returns it with its control channel.
    pub fn begin(
        stage: &'static Stage,
        restarts: u32,
        (domain, plan): (&Domain, &Plan),
    ) -> Result<(Control, Self), Failure> {
        let (control, theirs) = Control::pair()?;
        let life = if plan.threads {
            thread(stage, restarts, Control::from(theirs), domain, plan)?
        } else {
            process(stage, restarts, theirs, domain)?
        };
        Ok((control, life))
    }

    /// How it ended, if it did.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        match self {
            Self::Process(child, _) => child.try_wait().ok().flatten(),
            Self::Thread(thread, status) => thread
                .is_finished()
                .then(|| ExitStatus::from_raw(i32::from(status.load(Ordering::Acquire)) << 8)),
        }
    }

    /// Descriptor that becomes readable when it ends.
    pub fn end(&self) -> Option<BorrowedFd<'_>> {
        match self {
            Self::Process(_, end) => end.as_ref().map(AsFd::as_fd),
            Self::Thread(..) => None,
        }
    }

    /// The process that it is or belongs to.
    pub fn pid(&self) -> u32 {
        match self {
            Self::Process(child, _) => child.id(),
            Self::Thread(..) => std::process::id(),
        }
    }

    /// Whether it can be ended by force: a thread cannot.
    pub fn can_be_killed(&self) -> bool {
        matches!(self, Self::Process(..))
    }

    /// Ends it by force, where that is possible, without waiting.
    pub fn kill(&mut self) {
        if let Self::Process(child, _) = self {
            let _ = child.kill();
        }
    }

    /// Ends it by force and waits for its end, up to a limit.
    pub fn kill_and_wait(&mut self) {
        self.kill();
        let begun = Instant::now();
        while self.ended().is_none() && begun.elapsed() < KILL_LIMIT {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

fn cannot_start(stage: &Stage, error: &std::io::Error) -> Failure {
    Failure::input(
        format!("cannot start the service {}: {error}", stage.name),
        "the supervisor",
        "check the limits on processes, open files (ulimit -n 4096) and memory",
    )
}

fn process(
    stage: &Stage,
    restarts: u32,
    control: OwnedFd,
    domain: &Domain,
) -> Result<Life, Failure> {
    let child = image::command()
        .args(["service", stage.name, "--domain", domain.name()])
        .args(["--restarts", &restarts.to_string()])
        .stdin(Stdio::from(control))
        // A group of its own: Ctrl-C reaches the supervisor alone, which ends the run in order.
        .process_group(0)
        // These are for the supervisor alone.
        .env_remove("NOTIFY_SOCKET")
        .env_remove("WATCHDOG_USEC")
        .spawn()
        .map_err(|e| cannot_start(stage, &e))?;
    let end = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    let end = end.and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
    Ok(Life::Process(child, end))
}

fn thread(
    stage: &'static Stage,
    restarts: u32,
    control: Control,
    domain: &Domain,
    plan: &Plan,
) -> Result<Life, Failure> {
    let (domain, plan) = (domain.clone(), plan.clone());
    // Span that identifies the process in its log lines.
    let span = tracing::error_span!(
        "process",
        pid = std::process::id(),
        process = stage.name,
        machine = plan.machine.name(),
        domain = domain.name(),
        restarts
    );
    let body = move || {
        let _process = span.entered();
        // As the main function of a process does.
        match service::run(stage, restarts, control, &domain, &plan) {
            Ok(()) => 0,
            Err(failure) => {
                eprintln!("heft: {failure}");
                failure.status
            }
        }
    };
    spawned(stage.name, body).map_err(|e| cannot_start(stage, &e))
}

/// Runs a body on a thread, and stores the status that it returns.
fn spawned(name: &str, body: impl FnOnce() -> u8 + Send + 'static) -> std::io::Result<Life> {
    let status = Arc::new(AtomicU8::new(PANICKED));
    let its = Arc::clone(&status);
    let thread = std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(move || its.store(body(), Ordering::Release))?;
    Ok(Life::Thread(thread, status))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(body: impl FnOnce() -> u8 + Send + 'static) -> Option<i32> {
        let mut life = spawned("test", body).expect("a thread");
        // A thread that panics first writes the place, which takes a loaded machine longer than a kill.
        loop {
            match life.ended() {
                Some(end) => return end.code(),
                None => std::thread::sleep(Duration::from_millis(1)),
            }
        }
    }

    #[test]
    fn a_thread_that_panics_did_not_end_well() {
        assert_eq!(status(|| panic!("a fault")), Some(i32::from(PANICKED)));
        assert_eq!(status(|| 0), Some(0));
        assert_eq!(status(|| 2), Some(2));
    }
}
