//! Frees what dead processes held in the channels of a domain.
//!
//! The call into iceoryx2 waits for locks that others may hold, for as long as they like. So it is
//! made on a thread of its own: the supervisor waits for a limited time and goes on without.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use crate::Ports;

/// The thread that cleans up.
#[derive(Debug)]
pub struct Cleaner {
    // `None` only while dropping: the thread ends when this half is gone.
    ask: Option<Sender<()>>,
    done: Receiver<()>,
    waiting: bool,
}

impl Cleaner {
    /// Starts the thread; the domain has been entered before.
    #[must_use]
    pub fn start() -> Self {
        let (ask, asked) = channel();
        let (say, done) = channel();
        std::thread::spawn(move || {
            // Made on demand: most runs see no death.
            let mut ports = None;
            for () in asked {
                if ports.is_none() {
                    ports = Ports::new("cleaner").ok();
                }
                if let Some(ports) = &ports {
                    ports.clean_up_after_the_dead();
                }
                if say.send(()).is_err() {
                    return;
                }
            }
        });
        Self {
            ask: Some(ask),
            done,
            waiting: false,
        }
    }

    /// Cleans up; false if that is not done within `limit`, now or since an earlier call.
    pub fn clean_up(&mut self, limit: Duration) -> bool {
        if !self.waiting {
            let asked = self.ask.as_ref().map(|ask| ask.send(()));
            self.waiting = asked.is_some_and(|result| result.is_ok());
        }
        if self.done.recv_timeout(limit).is_ok() {
            self.waiting = false;
        }
        !self.waiting
    }
}

impl Drop for Cleaner {
    fn drop(&mut self) {
        self.ask = None;
        // Its files are removed with the domain; a thread that hangs ends with the process.
        let _ = self.done.recv_timeout(Duration::from_millis(200));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cleaner_that_hangs_holds_nobody_up_and_is_not_asked_twice() {
        let (ask, asked) = channel();
        let (say, done) = channel();
        let mut cleaner = Cleaner {
            ask: Some(ask),
            done,
            waiting: false,
        };
        assert!(!cleaner.clean_up(Duration::from_millis(1)));
        assert!(!cleaner.clean_up(Duration::from_millis(1)));
        assert_eq!(asked.try_iter().count(), 1);
        say.send(()).unwrap();
        assert!(cleaner.clean_up(Duration::from_millis(1)));
    }
}
