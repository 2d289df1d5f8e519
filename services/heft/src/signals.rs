//! Signals by which the user, the terminal or the system ends a command: SIGINT, SIGTERM, SIGHUP.

use std::collections::BTreeSet;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rustix::process::{Pid, Signal};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::failure::Failure;

/// Removes unfinished files if a signal ends the process. A signal that is ignored stays ignored.
pub fn leave_nothing() -> Result<(), Failure> {
    before_the_end(&[SIGINT, SIGTERM, SIGHUP], |signal| {
        recording::output::abandon(|| {
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        });
    })
}

/// Process ids of children that end with this process.
pub type Children = Arc<Mutex<BTreeSet<u32>>>;

/// Ends the children when SIGTERM ends this process. A terminal interrupts all of them itself.
pub fn end_together(children: &Children) -> Result<(), Failure> {
    let children = Arc::clone(children);
    before_the_end(&[SIGTERM], move |signal| {
        // The lock is also taken to start a child: none starts while the list is read.
        let children = children.lock().unwrap_or_else(PoisonError::into_inner);
        let pids = children.iter().filter_map(|pid| i32::try_from(*pid).ok());
        for pid in pids.filter_map(Pid::from_raw) {
            let _ = rustix::process::kill_process(pid, Signal::TERM);
        }
        let _ = signal_hook::low_level::emulate_default_handler(signal);
    })
}

/// Runs `act` when one of these signals comes, unless it is ignored.
fn before_the_end(signals: &[i32], act: impl Fn(i32) + Send + 'static) -> Result<(), Failure> {
    let wanted = signals.iter().filter(|s| !is_ignored(**s));
    let mut signals = signal_hook::iterator::Signals::new(wanted).map_err(Failure::signals)?;
    let body = move || {
        for signal in &mut signals {
            act(signal);
        }
    };
    let thread = std::thread::Builder::new();
    thread.spawn(body).map(drop).map_err(Failure::thread)
}

/// Whether the parent has set this signal to be ignored (`nohup`, `&` in a script).
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Records these signals, which no longer end the process.
pub struct Signals {
    came: Arc<AtomicBool>,
    wakes: UnixStream,
}

impl Signals {
    /// Installs the handlers. A hang-up that is ignored stays ignored: `nohup heft run` outlives its terminal. An ignored SIGINT is
    /// caught all the same, since scripts start a run by `&`, which ignores it, and end it so.
    pub fn catch() -> Result<Self, Failure> {
        Self::take(false)
    }

    /// As [`Signals::catch`]; the second signal ends the process, as if nobody caught it.
    pub fn catch_first() -> Result<Self, Failure> {
        Self::take(true)
    }

    fn take(only_first: bool) -> Result<Self, Failure> {
        let came = Arc::new(AtomicBool::new(false));
        let (wakes, rings) = UnixStream::pair().map_err(Failure::signals)?;
        let stays_ignored = |signal: &i32| *signal == SIGHUP && is_ignored(SIGHUP);
        let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter();
        for signal in wanted.filter(|signal| !stays_ignored(signal)) {
            if only_first {
                // Before the flag is registered: the first signal does not see it set by itself.
                signal_hook::flag::register_conditional_default(signal, Arc::clone(&came))
                    .map_err(Failure::signals)?;
            }
            signal_hook::flag::register(signal, Arc::clone(&came)).map_err(Failure::signals)?;
            let ring = rings.try_clone().map_err(Failure::signals)?;
            signal_hook::low_level::pipe::register(signal, ring).map_err(Failure::signals)?;
        }
        Ok(Self { came, wakes })
    }

    /// Whether one of them came.
    pub fn came(&self) -> bool {
        self.came.load(Ordering::Relaxed)
    }
}

impl AsFd for Signals {
    /// Becomes readable when a signal comes, and stays so.
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.wakes.as_fd()
    }
}
