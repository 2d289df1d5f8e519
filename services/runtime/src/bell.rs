//! The bell that wakes a reader: one eventfd per reader process.
//!
//! Data pass through iceoryx2; the bell only signals that there are some. A reader with several inputs has one bell
//! and drains them all. Measured against the iceoryx2 event listener it halves the latency of a
//! chain of four processes. Programs that the supervisor did not start use
//! the listener (see `Output::notify`).

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::time::Duration;

use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll};

use crate::Error;

/// A bell, shared by the reader that waits on it and by the writers that ring it.
#[derive(Debug)]
pub struct Bell(OwnedFd);

impl Bell {
    /// Creates a bell; the supervisor holds it, so that it outlives any worker.
    ///
    /// # Errors
    /// The limit of open files is reached.
    pub fn new() -> Result<Self, Error> {
        eventfd(0, EventfdFlags::CLOEXEC)
            .map(Self)
            .map_err(|e| Error::os("make a bell", "eventfd, limit of open files", e))
    }

    /// A bell received from the supervisor.
    pub fn from_fd(fd: OwnedFd) -> Self {
        Self(fd)
    }

    /// Wakes the reader. Never blocks: the counter would have to reach 2^64 - 2 first.
    pub fn ring(&self) {
        let _ = rustix::io::write(&self.0, &1u64.to_ne_bytes());
    }

    /// Blocks until the bell has been rung since the last wait. Wakes may be spurious.
    pub fn wait(&self) {
        let _ = rustix::io::read(&self.0, &mut [0u8; 8]);
    }

    /// Like [`wait`](Self::wait), for at most `limit`.
    pub fn wait_at_most(&self, limit: Duration) {
        if comes(&self.0, limit) {
            self.wait();
        }
    }

    /// Another handle on the same bell.
    ///
    /// # Errors
    /// The limit of open files is reached.
    pub fn try_clone(&self) -> Result<Self, Error> {
        self.0
            .try_clone()
            .map(Self)
            .map_err(|e| Error::os("copy a bell", "eventfd, limit of open files", e))
    }
}

/// Whether data become readable within this time.
pub(crate) fn comes(fd: &impl AsFd, limit: Duration) -> bool {
    // No duration that is waited here exceeds its range.
    let limit = Timespec::try_from(limit).ok();
    poll(&mut [PollFd::new(fd, PollFlags::IN)], limit.as_ref()).is_ok_and(|n| n > 0)
}

impl AsFd for Bell {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}
