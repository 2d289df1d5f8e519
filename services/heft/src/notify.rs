//! Notifications to systemd: the pipeline runs, its supervisor is awake, it ends.
//!
//! A datagram to the socket named by the unit's environment (`sd_notify(3)`); none without such a socket.

use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant};

/// Connection to the service manager.
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
            // A manager that does not read must not block a pipeline.
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

    /// Sends a message, such as `READY=1`.
    pub fn say(&self, word: &str) {
        if let Some((socket, address)) = &self.socket {
            let _ = socket.send_to_addr(word.as_bytes(), address);
        }
    }

    /// Sends the watchdog message at the required rate.
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
