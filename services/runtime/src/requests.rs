//! What a worker is asked for: heard on a thread of its own, looked at by its loop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::control::{Control, ControlWord};
use crate::{Bell, Error};

/// Where a source begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Begin {
    /// First sample to send: not 0 after a restart.
    pub first: u64,
    /// Instant at which sample 0 is (or was) due, on the monotonic clock \[ns\].
    pub start_ns: u64,
    /// Time of the latest sample that was seen, as the data tell it \[ns\]; 0 where there is none.
    pub latest_ns: u64,
}

/// What the supervisor wants, for the loop of a worker to look at.
#[derive(Debug)]
pub struct Requests {
    first: AtomicU64,
    start_ns: AtomicU64,
    latest_ns: AtomicU64,
    /// The largest number: nothing was said of it.
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
    /// Where to begin, once asked to.
    pub fn begin(&self) -> Option<Begin> {
        self.go.load(Ordering::Acquire).then(|| Begin {
            first: self.first.load(Ordering::Relaxed),
            start_ns: self.start_ns.load(Ordering::Relaxed),
            latest_ns: self.latest_ns.load(Ordering::Relaxed),
        })
    }

    /// How many samples the supervisor has seen in every channel; the largest number where it says nothing of it.
    pub fn seen(&self) -> u64 {
        self.seen.load(Ordering::Relaxed)
    }

    /// Whether to answer what is waiting and say so; asked for once.
    pub fn take_drain(&self) -> bool {
        self.drain.load(Ordering::Relaxed) && self.drain.swap(false, Ordering::AcqRel)
    }

    /// Whether a drain is asked for.
    pub fn wants_drain(&self) -> bool {
        self.drain.load(Ordering::Relaxed)
    }

    /// Whether to end.
    pub fn wants_exit(&self) -> bool {
        self.exit.load(Ordering::Relaxed)
    }
}

/// Listens to the supervisor on a thread of its own, so that the loop of the worker waits for its
/// bell alone. Rings the bell on every wish.
///
/// # Errors
/// The system has no thread for it.
pub(crate) fn listen(control: Arc<Control>, bell: Bell) -> Result<Arc<Requests>, Error> {
    let requests = Arc::new(Requests::default());
    let shared = Arc::clone(&requests);
    let body = move || {
        loop {
            // A supervisor that dies closes the socket: there is nothing to look at meanwhile.
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
