//! A CAN bus as a source: frames from SocketCAN, with the times at which the kernel received them.

use std::io::ErrorKind;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use recording::can::{Decoder, Frame};
use recording::{Error, Machine, Map};
use runtime::{Live, Polled, now_ns};
use socketcan::{CanAnyFrame, CanFdSocket, EmbeddedFrame, Frame as _, Socket, SocketOptions};

/// Longest wait for a frame.
const PATIENCE: Duration = Duration::from_millis(20);
/// A frame that the kernel has received is here after this time at the latest [ns]: only then is
/// silence silence.
const UNDER_WAY: i64 = 100_000_000;
/// From one attempt to open the interface to the next.
const RETRY: Duration = Duration::from_millis(200);
/// The clocks drift apart by this if the time of day was set [ns].
const STEP: i64 = 10_000_000;

/// The samples of a machine's bus.
#[derive(Debug)]
pub struct CanBus<M: Machine> {
    interface: String,
    socket: Option<CanFdSocket>,
    tried: Option<Instant>,
    /// Whether the last word was that the interface is gone.
    is_down: bool,
    decoder: Decoder<M>,
    /// Monotonic clock less time of day [ns].
    offset: i64,
}

impl<M: Machine> CanBus<M> {
    /// Frames of `interface`, decoded as the map says. The interface is opened when it is there.
    ///
    /// # Errors
    /// The map does not fit.
    pub fn new(interface: &str, map: &Map) -> Result<Self, Error> {
        Ok(Self {
            interface: interface.to_owned(),
            socket: None,
            tried: None,
            is_down: false,
            decoder: Decoder::new(map)?,
            offset: offset(),
        })
    }

    /// The first frame gets the time `seconds` instead of 0.
    pub fn begin_at(&mut self, seconds: f64) {
        self.decoder.begin_at(seconds);
    }

    /// Opens the interface; false while it cannot be.
    fn open(&mut self) -> bool {
        if self.socket.is_some() {
            return true;
        }
        if self.tried.is_some_and(|t| t.elapsed() < RETRY) {
            return false;
        }
        self.tried = Some(Instant::now());
        let opened = CanFdSocket::open(&self.interface).and_then(|socket| {
            socket.set_recv_timestamp(true)?;
            socket.set_error_filter_drop_all()?;
            socket.set_read_timeout(PATIENCE)?;
            Ok(socket)
        });
        match opened {
            Ok(socket) => {
                if self.is_down {
                    tracing::info!("{} is back", self.interface);
                }
                self.is_down = false;
                self.socket = Some(socket);
            }
            Err(error) => self.gone(&error),
        }
        self.socket.is_some()
    }

    fn gone(&mut self, error: &std::io::Error) {
        if !self.is_down {
            tracing::warn!("{}: {error}; waiting for it", self.interface);
        }
        (self.is_down, self.socket) = (true, None);
    }

    /// A time of day on the monotonic clock [ns], in whole microseconds of the day as candump
    /// writes them: a log taken beside the run gives the same bits.
    fn monotonic(&mut self, time: SystemTime) -> i64 {
        let now = offset();
        if (now - self.offset).abs() > STEP {
            self.offset = now;
        }
        since_epoch(time) / 1000 * 1000 + self.offset
    }

    fn silence(&mut self) {
        self.decoder.pass(signed(now_ns()) - UNDER_WAY);
    }

    fn read(&mut self) {
        let Some(socket) = &self.socket else { return };
        match socket.read_frame_with_timestamp() {
            Ok((frame, time)) => {
                let time = self.monotonic(time);
                if let Some(frame) = ours(&frame, time, &self.interface) {
                    self.decoder.take(&frame);
                }
            }
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                self.silence();
            }
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => self.gone(&e),
        }
    }
}

impl<M: Machine> Live for CanBus<M> {
    type Sensors = M::Sensors;
    type Truth = M::Truth;

    fn poll(&mut self) -> Polled<M::Sensors, M::Truth> {
        if let Some((sensors, truth)) = self.decoder.row() {
            return Polled::Sample(sensors, truth);
        }
        if self.open() {
            self.read();
        } else {
            std::thread::sleep(PATIENCE);
            self.silence();
        }
        for remark in self.decoder.take_remarks() {
            tracing::warn!("{}: {remark}", self.interface);
        }
        match self.decoder.row() {
            Some((sensors, truth)) => Polled::Sample(sensors, truth),
            None => Polled::Nothing,
        }
    }
}

/// A data frame as the decoder takes it.
fn ours<'a>(frame: &CanAnyFrame, time: i64, interface: &'a str) -> Option<Frame<'a>> {
    match frame {
        CanAnyFrame::Normal(f) => {
            Frame::new(time, interface, f.raw_id(), f.is_extended(), f.data())
        }
        CanAnyFrame::Fd(f) => Frame::new(time, interface, f.raw_id(), f.is_extended(), f.data()),
        _ => None,
    }
}

/// Monotonic clock less time of day [ns]; read twice, for the case that something came between.
fn offset() -> i64 {
    let read = || {
        let before = now_ns();
        let day = since_epoch(SystemTime::now());
        let after = now_ns();
        (after - before, signed(before) - day)
    };
    read().min(read()).1
}

fn since_epoch(time: SystemTime) -> i64 {
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(0)
}

fn signed(ns: u64) -> i64 {
    i64::try_from(ns).unwrap_or(i64::MAX)
}
