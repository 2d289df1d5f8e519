//! Estimates onto a CAN bus. A bus that is away or full costs frames, never an estimate.

use std::io;
use std::time::{Duration, Instant};

use messages::channels::Channel;
use messages::{Message, fault};
use recording::can::{Frame, Outgoing};
use runtime::Sink;
use socketcan::{CanFrame, CanSocket, EmbeddedFrame, ExtendedId, Id, Socket, StandardId};

/// From one attempt to open the interface to the next.
const RETRY: Duration = Duration::from_millis(200);
/// Frames are sent so soon after their estimate.
const VISIT: Duration = Duration::from_millis(10);

/// Sends estimates as frames.
#[derive(Debug)]
pub struct BusWriter {
    interface: String,
    outgoing: Outgoing,
    socket: Option<CanSocket>,
    tried: Option<Instant>,
    /// Time of the data at which the last frames were sent [s].
    last: f64,
    /// Whether the last attempt failed: told once.
    has_failed: bool,
}

impl BusWriter {
    /// Sends `outgoing` on `interface`, which is opened when it is there.
    #[must_use]
    pub fn new(interface: &str, outgoing: Outgoing) -> Self {
        Self {
            interface: interface.to_owned(),
            outgoing,
            socket: None,
            tried: None,
            last: f64::NEG_INFINITY,
            has_failed: false,
        }
    }

    fn open(&mut self) -> io::Result<&CanSocket> {
        if self.socket.is_none() {
            if self.tried.is_some_and(|t| t.elapsed() < RETRY) {
                return Err(io::ErrorKind::NotConnected.into());
            }
            self.tried = Some(Instant::now());
            let socket = CanSocket::open(&self.interface)?;
            socket.set_nonblocking(true)?;
            self.socket = Some(socket);
        }
        self.socket
            .as_ref()
            .ok_or_else(|| io::ErrorKind::NotConnected.into())
    }

    fn send(&mut self, frames: &[CanFrame]) -> io::Result<()> {
        let socket = self.open()?;
        frames
            .iter()
            .try_for_each(|frame| socket.write_frame(frame))
    }

    fn tell(&mut self, sent: &io::Result<()>) {
        match sent {
            Ok(()) if self.has_failed => tracing::warn!("{} takes frames again", self.interface),
            Err(error) if !self.has_failed => {
                tracing::warn!(
                    "{}: {error}; estimates are not sent meanwhile",
                    self.interface
                );
            }
            _ => {}
        }
        self.has_failed = sent.is_err();
        // A full queue empties by itself; any other error may be of this socket.
        let is_full = |e: &io::Error| {
            e.kind() == io::ErrorKind::WouldBlock || e.raw_os_error() == Some(NO_BUFFERS)
        };
        if sent.as_ref().is_err_and(|e| !is_full(e)) {
            self.socket = None;
        }
    }
}

/// ENOBUFS: the interface's queue is full.
const NO_BUFFERS: i32 = rustix::io::Errno::NOBUFS.raw_os_error();

/// The frame as the socket takes it.
fn out(frame: &Frame) -> Option<CanFrame> {
    let id: Id = if frame.extended {
        ExtendedId::new(frame.id)?.into()
    } else {
        StandardId::new(u16::try_from(frame.id).ok()?)?.into()
    };
    CanFrame::new(id, frame.data())
}

impl Sink for BusWriter {
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        let time = message.stamp().time;
        // A little early counts as due: the times of samples are sums of rounded steps.
        let is_early = time - self.last < self.outgoing.period * 0.999 && time >= self.last;
        if channel.name != self.outgoing.channel.name || is_early {
            return;
        }
        self.last = time;
        let envelope = message.envelope();
        let frames = self.outgoing.frames(&envelope, 0, "");
        let frames: Vec<CanFrame> = frames.filter_map(|f| out(&f)).collect();
        let sent = self.send(&frames);
        self.tell(&sent);
    }

    fn has_room(&self) -> bool {
        true
    }

    fn fault(&self) -> u32 {
        if self.has_failed {
            fault::SEND
        } else {
            fault::NONE
        }
    }

    fn drain(&mut self) {}

    fn visit(&self) -> Duration {
        VISIT
    }
}
