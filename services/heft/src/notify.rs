//! What systemd is given: that the pipeline runs, that its supervisor is awake, that it ends.
//!
//! A datagram to the socket that the unit's environment names (`sd_notify(3)`); nothing without one.

use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant};

/// The way to the service manager.
#[derive(Default)]
pub struct Notify {
    socket: Option<(UnixDatagram, SocketAddr)>,
    period: Option<Duration>,
    sent: Option<Instant>,
}

impl Notify {
    /// The manager that started this process, if one did.
    pub fn of_environment() -> Self {
        let socket = std::env::var("NOTIFY_SOCKET").ok().and_then(|name| {
            let address = match name.strip_prefix('@') {
                Some(name) => SocketAddr::from_abstract_name(name),
                None => SocketAddr::from_pathname(&name),
            };
            let socket = UnixDatagram::unbound().ok()?;
            // A manager that does not listen must not hold up a pipeline.
            socket.set_nonblocking(true).ok()?;
            Some((socket, address.ok()?))
        });
        let limit = std::env::var("WATCHDOG_USEC").ok();
        let limit = limit.and_then(|us| us.parse().ok());
        Self {
            socket,
            period: limit.map(|us: u64| Duration::from_micros(us / 3)),
            sent: None,
        }
    }

    /// Whether a service manager has started this process.
    pub fn has_manager(&self) -> bool {
        self.socket.is_some()
    }

    /// Says a word, such as `READY=1`.
    pub fn say(&self, word: &str) {
        if let Some((socket, address)) = &self.socket {
            let _ = socket.send_to_addr(word.as_bytes(), address);
        }
    }

    /// Says often enough that the supervisor is awake.
    pub fn awake(&mut self) {
        let Some(period) = self.period else {
            return;
        };
        if self.sent.is_none_or(|sent| sent.elapsed() >= period) {
            self.sent = Some(Instant::now());
            self.say("WATCHDOG=1");
        }
    }
}
