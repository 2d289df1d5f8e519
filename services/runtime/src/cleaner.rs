//! Frees resources of dead processes in the channels of a domain.
//!
//! The call into iceoryx2 waits without limit for locks that other processes may hold. It therefore
//! runs on a thread of its own: the supervisor waits for a limited time and continues without it.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use crate::{Error, Ports};

/// The thread that cleans up.
#[derive(Debug)]
pub struct Cleaner {
    // `None` only while dropping: the thread ends when this half is dropped.
    ask: Option<Sender<()>>,
    /// Whether it was done, once per request.
    done: Receiver<bool>,
    /// Time of a request that is not done yet.
    asked_at: Option<Instant>,
}

impl Cleaner {
    /// Starts the thread; the domain must have been entered before.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub fn start() -> Result<Self, Error> {
        let (ask, asked) = channel();
        let (say, done) = channel();
        let body = move || {
            // Created on demand: in most runs no process dies.
            let mut ports = None;
            for () in asked {
                if ports.is_none() {
                    ports = Ports::new("cleaner").ok();
                }
                if let Some(ports) = &ports {
                    ports.clean_up_after_the_dead();
                }
                if say.send(ports.is_some()).is_err() {
                    return;
                }
            }
        };
        let thread = std::thread::Builder::new();
        thread.spawn(body).map_err(Error::thread)?;
        Ok(Self {
            ask: Some(ask),
            done,
            asked_at: None,
        })
    }

    /// Cleans up; false if that is impossible, or not done within `limit` since it was requested, now or by an earlier call.
    /// A thread that hangs therefore delays only the first caller.
    pub fn clean_up(&mut self, limit: Duration) -> bool {
        if self.asked_at.is_none() {
            let asked = self.ask.as_ref().and_then(|ask| ask.send(()).ok());
            self.asked_at = asked.map(|()| Instant::now());
        }
        let waited = self.asked_at.map_or(limit, |at| at.elapsed());
        let done = self.done.recv_timeout(limit.saturating_sub(waited));
        if done.is_ok() {
            self.asked_at = None;
        }
        done.unwrap_or(false)
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
    fn a_cleaner_that_hangs_delays_no_caller_twice_and_gets_one_request() {
        let (ask, asked) = channel();
        let (say, done) = channel();
        let mut cleaner = Cleaner {
            ask: Some(ask),
            done,
            asked_at: None,
        };
        assert!(!cleaner.clean_up(Duration::from_millis(1)));
        assert!(!cleaner.clean_up(Duration::from_millis(1)));
        let (limit, now) = (Duration::from_secs(60), Instant::now());
        cleaner.asked_at = now.checked_sub(limit);
        assert!(!cleaner.clean_up(limit));
        assert!(now.elapsed() < limit, "it waited again");
        assert_eq!(asked.try_iter().count(), 1);
        say.send(true).unwrap();
        assert!(cleaner.clean_up(Duration::from_millis(1)));
        say.send(false).unwrap();
        assert!(!cleaner.clean_up(Duration::from_millis(1)), "it could not");
        assert!(cleaner.asked_at.is_none(), "and is asked again");
    }
}
