//! CAN bus as a source: frames from SocketCAN, with the times at which the kernel received them.

use std::time::{Duration, Instant};

use recording::can::Decoder;
use recording::{Error, Map, Sensors};
use runtime::{Live, Polled, now_ns, since_1970};

use crate::socket::{BusRead, CanSocket};

/// Longest wait for a frame.
const PATIENCE: Duration = Duration::from_millis(20);
/// Longest delay of a frame after its reception by the kernel [ns]: only after it is
/// silence certain.
const UNDER_WAY: i64 = 100_000_000;
/// Time between two attempts to open the interface.
const RETRY: Duration = Duration::from_millis(200);
/// Time after which a missing signal is reported.
const SILENT: Duration = Duration::from_secs(5);
/// Change of the offset between the clocks that means that the time of day was set [ns].
const STEP: i64 = 10_000_000;

/// Samples from a machine's bus.
#[derive(Debug)]
pub struct CanBus<S: Sensors> {
    interface: String,
    socket: Option<CanSocket>,
    tried: Option<Instant>,
    /// Whether the loss of the interface was reported last.
    is_down: bool,
    decoder: Decoder<S>,
    /// Time at which missing signals are reported.
    check: Option<Instant>,
    /// Frames that the kernel dropped since the last call of `take_lost`.
    dropped: u64,
    /// Monotonic clock minus time of day [ns].
    offset: i64,
}

impl<S: Sensors> CanBus<S> {
    /// Frames of `interface`, decoded by the map. The interface is opened once it exists.
    ///
    /// # Errors
    /// The map does not fit the machine.
    pub fn new(interface: &str, map: &Map) -> Result<Self, Error> {
        Ok(Self {
            interface: interface.to_owned(),
            socket: None,
            tried: None,
            is_down: false,
            decoder: Decoder::new(map)?,
            check: Some(Instant::now() + SILENT),
            dropped: 0,
            offset: offset().1,
        })
    }

    /// Sets the time of the first frame to `seconds` instead of 0.
    pub fn begin_at(&mut self, seconds: f64) {
        self.decoder.begin_at(seconds);
    }

    /// Opens the interface; false while that fails.
    fn open(&mut self) -> bool {
        if self.socket.is_some() {
            return true;
        }
        if self.tried.is_some_and(|t| t.elapsed() < RETRY) {
            return false;
        }
        self.tried = Some(Instant::now());
        match CanSocket::open(&self.interface, PATIENCE) {
            Ok(socket) => {
                tracing::info!(interface = self.interface, "connected");
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

    /// Converts a time of day to the monotonic clock [ns], in whole microseconds of the day as candump
    /// writes them: a log taken in parallel gives the same bits.
    fn monotonic(&mut self, time_of_day: i64) -> i64 {
        let (doubt, now) = offset();
        if (now - self.offset).abs() > STEP + doubt {
            self.offset = now;
        }
        time_of_day / 1000 * 1000 + self.offset
    }

    fn silence(&mut self, until: i64) {
        self.decoder.pass(until - UNDER_WAY);
    }

    fn read(&mut self) {
        let Some(socket) = &mut self.socket else {
            return;
        };
        // If the queue is empty later, no frame was received before this moment.
        let before = signed(now_ns());
        let interface = self.interface.clone();
        let input = match socket.read(&interface) {
            Ok((input, dropped)) => {
                self.dropped += dropped;
                input
            }
            Err(error) => return self.gone(&error),
        };
        if std::mem::take(&mut self.is_down) {
            tracing::warn!("{interface} is back");
        }
        match input {
            BusRead::Frame(mut frame) => {
                frame.time_ns = self.monotonic(frame.time_ns);
                self.decoder.take(&frame);
            }
            BusRead::Other => {}
            BusRead::Nothing => self.silence(before),
        }
    }
}

impl<S: Sensors> Live for CanBus<S> {
    type Sensors = S;
    type Truth = S::Truth;

    fn take_lost(&mut self) -> u64 {
        std::mem::take(&mut self.dropped)
    }

    fn poll(&mut self) -> Polled<S, S::Truth> {
        if let Some((sensors, truth)) = self.decoder.row() {
            return Polled::Sample(sensors, truth);
        }
        if self.open() {
            self.read();
        } else {
            std::thread::sleep(PATIENCE);
            self.silence(signed(now_ns()));
        }
        if self.check.take_if(|due| Instant::now() > *due).is_some()
            && let Err(error) = self.decoder.check_senders(&self.interface)
        {
            tracing::warn!("{} in {} s: {}", error.what, SILENT.as_secs(), error.place);
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

/// Monotonic clock minus time of day [ns], after its uncertainty, which is the time between
/// the readings; the better of two attempts.
fn offset() -> (i64, i64) {
    let read = || {
        let before = now_ns();
        let day = i64::try_from(since_1970().as_nanos()).unwrap_or(0);
        let after = now_ns();
        (signed(after - before), signed(before) - day)
    };
    read().min(read())
}

fn signed(ns: u64) -> i64 {
    i64::try_from(ns).unwrap_or(i64::MAX)
}
