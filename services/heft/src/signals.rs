//! The wish of the user, the terminal or the system that a command ends: SIGINT, SIGTERM, SIGHUP.

use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::failure::Failure;

/// Notes these signals instead of dying of them.
pub struct Signals {
    came: Arc<AtomicBool>,
    wakes: UnixStream,
}

impl Signals {
    /// From now on.
    pub fn catch() -> Result<Self, Failure> {
        let came = Arc::new(AtomicBool::new(false));
        let (wakes, rings) = UnixStream::pair().map_err(Failure::internal)?;
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            signal_hook::flag::register(signal, Arc::clone(&came)).map_err(Failure::internal)?;
            let ring = rings.try_clone().map_err(Failure::internal)?;
            signal_hook::low_level::pipe::register(signal, ring).map_err(Failure::internal)?;
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
