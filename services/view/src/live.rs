//! The live page: the report's plots while the run goes on, over server-sent events.
//!
//! The supervisor pushes messages into a [`Feed`]; that costs a short lock and never waits for a viewer. A task takes a frame 30
//! times a second and puts it into a ring. Each viewer reads the ring at its own pace; one that falls behind skips the oldest
//! frames, which are counted. A stalled viewer costs a socket and 64 frames that all viewers share, nothing else.

mod address;
mod connections;
mod frame;
mod loads;
mod metrics;
mod page;
mod server;

#[cfg(test)]
mod tests;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use messages::Message;
use messages::channels::Channel;

use crate::monitor::Monitor;

pub use address::address;
pub use loads::SharedLoads;
pub use server::{MAX_VIEWERS, Server, ServerThread, names_this_host, serve};

/// Default address of `--view`: this host only.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:8440";

/// Input of the page; clones share the same page.
#[derive(Debug, Clone, Default)]
pub struct Feed {
    monitor: Arc<Mutex<Monitor>>,
    loads: Option<SharedLoads>,
}

impl Feed {
    /// A feed with the processes' `names`, in the order of the table of processes.
    pub fn new(names: Vec<String>) -> Self {
        Self {
            monitor: Arc::new(Mutex::new(Monitor::new(names))),
            loads: None,
        }
    }

    /// Adds the loads of the run, which are counted elsewhere.
    #[must_use]
    pub fn with_loads(self, loads: SharedLoads) -> Self {
        Self {
            loads: Some(loads),
            ..self
        }
    }

    /// Shows `message`. Not for a real-time thread: it takes a lock, which the page holds for some tens of microseconds 30 times
    /// a second.
    pub fn push<M: Message>(&self, channel: &Channel, message: &M) {
        self.lock().push(channel, message, Instant::now());
    }

    fn lock(&self) -> MutexGuard<'_, Monitor> {
        self.monitor.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
