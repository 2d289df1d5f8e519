//! Requests of the supervisor: received on a thread of its own, read by the worker's loop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::control::{Control, ControlWord};
use crate::{Bell, Error};

/// Start of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Begin {
    /// First sample to send: not 0 after a restart.
    pub first: u64,
    /// Instant at which sample 0 is (or was) due, on the monotonic clock \[ns\].
    pub start_ns: u64,
    /// Time of the latest sample received, in the time of the data \[ns\]; 0 where there is none.
    pub latest_ns: u64,
}

/// Requests of the supervisor for the loop of a worker.
#[derive(Debug)]
pub struct Requests {
    first: AtomicU64,
    start_ns: AtomicU64,
    latest_ns: AtomicU64,
    /// Number of samples that the supervisor has received in every channel; the maximum means not stated.
    seen: AtomicU64,
    go: AtomicBool,
    drain: AtomicBool,
    exit: AtomicBool,
}

impl Default for Requests {
    fn default() -> Self {
        Self {
            first: AtomicU64::default(),
            start_ns: AtomicU64::default(),
            latest_ns: AtomicU64::default(),
            seen: AtomicU64::new(u64::MAX),
            go: AtomicBool::default(),
            drain: AtomicBool::default(),
            exit: AtomicBool::default(),
        }
    }
}

impl Requests {
    /// Start of the source, once requested.
    pub fn begin(&self) -> Option<Begin> {
        self.go.load(Ordering::Acquire).then(|| Begin {
            first: self.first.load(Ordering::Relaxed),
            start_ns: self.start_ns.load(Ordering::Relaxed),
            latest_ns: self.latest_ns.load(Ordering::Relaxed),
        })
    }

    /// Number of samples that the supervisor has received in every channel; the maximum where it does not state it.
    pub fn seen(&self) -> u64 {
        self.seen.load(Ordering::Relaxed)
    }

    /// Whether to answer all waiting messages and confirm; true once per request.
    pub fn take_drain(&self) -> bool {
        self.drain.load(Ordering::Relaxed) && self.drain.swap(false, Ordering::AcqRel)
    }

    /// Whether a drain is requested.
    pub fn wants_drain(&self) -> bool {
        self.drain.load(Ordering::Relaxed)
    }

    /// Whether an exit is requested.
    pub fn wants_exit(&self) -> bool {
        self.exit.load(Ordering::Relaxed)
    }
}

/// Listens to the supervisor on a thread of its own, so that the loop of the worker waits for its
/// bell only. Rings the bell on every request.
///
/// # Errors
/// The system cannot start a thread.
pub(crate) fn listen(control: Arc<Control>, bell: Bell) -> Result<Arc<Requests>, Error> {
    let requests = Arc::new(Requests::default());
    let shared = Arc::clone(&requests);
    let body = move || {
        loop {
            // A supervisor that dies closes the socket, so no time limit is needed.
            match control.hear(u32::MAX) {
                ControlWord::Word(word) => obey(&shared, &word),
                ControlWord::Nothing => continue,
                ControlWord::Gone => shared.exit.store(true, Ordering::Release),
            }
            bell.ring();
            if shared.wants_exit() {
                return;
            }
        }
    };
    let thread = std::thread::Builder::new();
    thread.spawn(body).map_err(Error::thread)?;
    Ok(requests)
}

fn obey(requests: &Requests, word: &str) {
    match word.split_once(' ').unwrap_or((word, "")) {
        ("go", numbers) => {
            let mut numbers = numbers.split(' ').map(|n| n.parse().unwrap_or(0));
            for number in [&requests.first, &requests.start_ns, &requests.latest_ns] {
                number.store(numbers.next().unwrap_or(0), Ordering::Relaxed);
            }
            requests.go.store(true, Ordering::Release);
        }
        ("seen", number) => requests
            .seen
            .store(number.parse().unwrap_or(u64::MAX), Ordering::Relaxed),
        ("drain", _) => requests.drain.store(true, Ordering::Release),
        ("exit", _) => requests.exit.store(true, Ordering::Release),
        _ => {}
    }
}
