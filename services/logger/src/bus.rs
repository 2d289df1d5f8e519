//! Sends estimates on a CAN bus, as a node of J1939 that claims, defends and gives up an address. A bus that is absent or
//! full costs frames, never an estimate.

use std::io;
use std::time::{Duration, Instant};

use messages::channels::Channel;
use messages::{Envelope, Message, fault};
use recording::can::node::{HEARS, Node};
use recording::can::{Frame, Outgoing};
use runtime::{Sink, now_ns};
use socketcan::{
    CanFilter, CanFrame, CanSocket, EmbeddedFrame, ExtendedId, Id, Socket, SocketOptions,
    StandardId,
};

/// Time between two attempts to open the interface.
const RETRY: Duration = Duration::from_millis(200);
/// Longest delay of frames after their estimate.
const VISIT: Duration = Duration::from_millis(10);

/// Sends estimates as frames.
#[derive(Debug)]
pub struct BusWriter {
    interface: String,
    outgoing: Outgoing,
    socket: Option<CanSocket>,
    tried: Option<Instant>,
    /// The last message of each channel, for requests; its time is that of the last frames sent.
    latest: Vec<Envelope>,
    /// Whether the last attempt failed: reported once.
    has_failed: bool,
    /// The node; `None` without J1939 frames.
    node: Option<Node>,
    /// Last reported address.
    address: Option<u8>,
    /// The outgoing frames with that address.
    addressed: Outgoing,
    /// Whether the loss of the address, and another node with the same NAME, have been reported.
    has_lost: bool,
    has_double: bool,
}

/// Largest number of received frames per visit: a bus that floods the node does not delay the estimates.
const MOST_HEARD: usize = 64;

impl BusWriter {
    /// Sends `outgoing` on `interface`, which is opened once it exists.
    pub fn new(interface: &str, outgoing: Outgoing) -> Self {
        let node = outgoing.node(rustix::system::uname().nodename().to_bytes());
        Self {
            interface: interface.to_owned(),
            addressed: outgoing.clone(),
            node,
            address: None,
            latest: Vec::new(),
            has_lost: false,
            has_double: false,
            outgoing,
            socket: None,
            tried: None,
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
            match &mut self.node {
                None => socket.set_filter_drop_all()?,
                Some(node) => {
                    let only = HEARS
                        .map(|(id, mask)| CanFilter::new(id | EXTENDED, mask | EXTENDED | REMOTE));
                    socket.set_filters(&only)?;
                    // The nodes on the bus may have changed while it was absent.
                    node.begin(now_ns());
                }
            }
            tracing::info!(interface = self.interface, "connected");
            self.socket = Some(socket);
        }
        self.socket
            .as_ref()
            .ok_or_else(|| io::ErrorKind::NotConnected.into())
    }

    /// Processes the claims and requests of other nodes, and sends the node's own messages.
    fn talk(&mut self) -> io::Result<()> {
        self.open()?;
        let (Some(node), Some(socket)) = (&mut self.node, &self.socket) else {
            return Ok(());
        };
        for _ in 0..MOST_HEARD {
            match socket.read_frame() {
                Ok(CanFrame::Data(frame)) => {
                    if let Id::Extended(id) = frame.id() {
                        node.take(id.as_raw(), frame.data(), now_ns());
                    }
                }
                Ok(_) => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) => return Err(error),
            }
        }
        while let Some(sent) = node.say(now_ns()) {
            let id = ExtendedId::new(sent.id);
            if let Some(frame) = id.and_then(|id| CanFrame::new(id, &sent.data)) {
                socket.write_frame(&frame)?;
            }
        }
        let address = node.address(now_ns());
        let requested = node.take_asked();
        let (has_lost, has_double) = (node.has_lost(), node.has_double());
        self.report_address(address, has_lost, has_double);
        if requested.is_empty() {
            return Ok(());
        }
        let latest = self.latest.iter();
        let frames = latest.flat_map(|message| self.addressed.frames(message, 0, ""));
        let requested: Vec<CanFrame> = frames
            .filter(|f| f.extended && requested.contains(&(f.id >> 8 & 0x3_ffff)))
            .filter_map(|f| out(&f))
            .collect();
        self.send(&requested)
    }

    /// Uses the node's present address, and reports each change of it once.
    fn report_address(&mut self, address: Option<u8>, has_lost: bool, has_double: bool) {
        let interface = &self.interface;
        if address != self.address {
            self.address = address;
            if let Some(address) = address {
                self.addressed = self.outgoing.from(address);
                tracing::info!(interface, address, "address claimed");
            }
        }
        if has_lost && !self.has_lost {
            tracing::warn!(
                "{interface}: no address: another node has it, by its NAME; nothing is sent"
            );
        }
        if has_double && !self.has_double {
            tracing::warn!(
                "{interface}: another node has the NAME of this one; give each its own `identity` in [can.name] of --output-map"
            );
        }
        (self.has_lost, self.has_double) = (has_lost, has_double);
    }

    /// The frames of an estimate that may be sent now; those of J1939 need an address.
    fn frames(&self, estimate: &Envelope) -> Vec<CanFrame> {
        let has_address = self.address.is_some();
        let frames = self.addressed.frames(estimate, 0, "");
        let frames = frames.filter(|f| has_address || !f.extended);
        frames.filter_map(|f| out(&f)).collect()
    }

    fn send(&mut self, frames: &[CanFrame]) -> io::Result<()> {
        let socket = self.open()?;
        frames
            .iter()
            .try_for_each(|frame| socket.write_frame(frame))
    }

    fn report(&mut self, sent: &io::Result<()>) {
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
        // A full queue empties by itself; any other error may concern this socket.
        let is_full = |e: &io::Error| {
            e.kind() == io::ErrorKind::WouldBlock || e.raw_os_error() == Some(NO_BUFFERS)
        };
        if sent.as_ref().is_err_and(|e| !is_full(e)) {
            (self.socket, self.address) = (None, None);
        }
    }
}

/// Flags beside an identifier.
const EXTENDED: u32 = 1 << 31;
const REMOTE: u32 = 1 << 30;

/// ENOBUFS: the interface's queue is full.
const NO_BUFFERS: i32 = rustix::io::Errno::NOBUFS.raw_os_error();

/// The frame in the form of the socket.
fn out(frame: &Frame) -> Option<CanFrame> {
    let id: Id = if frame.extended {
        ExtendedId::new(frame.id)?.into()
    } else {
        StandardId::new(u16::try_from(frame.id).ok()?)?.into()
    };
    CanFrame::new(id, frame.data())
}

impl Sink for BusWriter {
    fn accept<M: Message>(&mut self, _: &'static Channel, message: &M) {
        let time = message.stamp().time;
        let envelope = message.envelope();
        let payload = envelope.payload();
        let known = self.latest.iter().position(|m| m.payload() == payload);
        match known.map(|i| &mut self.latest[i]) {
            Some(latest) => {
                let last = latest.stamp().time;
                // Slightly early counts as due: the times of samples are sums of rounded steps.
                if time - last < self.outgoing.period * 0.999 && time >= last {
                    return;
                }
                *latest = envelope;
            }
            None => self.latest.push(envelope),
        }
        let sent = self.talk().and_then(|()| {
            let frames = self.frames(&envelope);
            self.send(&frames)
        });
        self.report(&sent);
    }

    fn look(&mut self) {
        if self.node.is_some() {
            let sent = self.talk();
            if sent.is_err() {
                self.report(&sent);
            }
        }
    }

    fn fault(&self) -> u32 {
        if self.has_failed {
            fault::SEND
        } else {
            fault::NONE
        }
    }

    fn visit(&self) -> Duration {
        VISIT
    }
}
