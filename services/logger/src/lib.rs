//! The logger: takes every message of a machine and has a thread of its own write the recording.
//!
//! The process drains the channels on a timer and pushes what it finds into a lock-free ring; the
//! writer thread empties it into the file and flushes twice a second, sooner when a quarter of it is full. A disk that is slow
//! or full therefore never holds up a channel: what the ring cannot take is counted and said.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use messages::channels::Channel;
use messages::{Envelope, Message, fault};
use recording::{Error, Metadata};
use rtrb::{Consumer, Producer, RingBuffer};
use runtime::Sink;

mod bus;
mod mark;
mod recorder;

pub use bus::BusWriter;
use mark::{Mark, Next};
pub use recorder::Limits;
use recorder::Recorder;

/// Messages that may wait for the disk: 0.4 s of an excavator at 10 kHz.
const RING: usize = 16_384;
/// The writer is woken when so many wait. Each wake costs more than the writing of a message.
const WAKE: usize = RING / 4;
/// Room that one visit to the channels may need.
const VISIT_ROOM: usize = 64;
/// A killed run loses at most this much, plus one visit of the logger. A logger that is killed alone loses nothing: its
/// successor is handed what the writers of the channels still hold.
const FLUSH_PERIOD: Duration = Duration::from_millis(500);
/// How long the end of a run waits for the disk.
const DRAIN_LIMIT: Duration = Duration::from_secs(10);

type Record = (&'static Channel, Envelope);

/// Takes messages and records them.
#[derive(Debug)]
pub struct Logger {
    // `None` only while dropping: the writer thread ends when this half is gone.
    records: Option<Producer<Record>>,
    /// What the recording held at the start.
    recorded: Next,
    /// The first visit to the channels is over: its messages are written at once.
    has_visited: bool,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<(), Error>>>,
}

#[derive(Debug, Default)]
struct Shared {
    fault: AtomicU32,
    unwritten: AtomicU64,
    /// Everything is to be written and flushed now; the writer takes it back when that is done.
    drain: AtomicBool,
}

impl Logger {
    /// Begins the recording `path`, or its next part where there is something in it already: what a
    /// logger that was killed has written stays as it is. In the file `mark` it says how far it is.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn create(
        path: &Path,
        metadata: &Metadata,
        limits: Limits,
        mark: &Path,
    ) -> Result<Self, Error> {
        let mark = Mark::open(mark, path);
        let recorded = mark.recorded().clone();
        let recorder = Recorder::create(path, metadata, limits, mark)?;
        let (records, consumer) = RingBuffer::new(RING);
        let shared = Arc::new(Shared::default());
        let its = Arc::clone(&shared);
        let span = tracing::Span::current();
        let body = move || span.in_scope(|| write_all(recorder, consumer, &its));
        let thread = std::thread::Builder::new().spawn(body);
        let thread = thread.map_err(|error| Error {
            what: format!("cannot start the thread that writes: {error}"),
            place: path.display().to_string(),
            remedy: "check the limits on processes (ulimit -u) and memory".into(),
            io: Some(error.kind()),
        })?;
        Ok(Self {
            records: Some(records),
            recorded,
            has_visited: false,
            shared,
            thread: Some(thread),
        })
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// Its end cannot be written: everything before it is there, and read as a recording that was cut off.
    pub fn finish(mut self) -> Result<(), Error> {
        self.end()
    }

    fn end(&mut self) -> Result<(), Error> {
        drop(self.records.take());
        self.wake();
        let ended = self.thread.take().map(JoinHandle::join);
        // A panic of the writer is on the terminal already.
        ended.and_then(Result::ok).unwrap_or(Ok(()))
    }

    /// Wakes the writer, if it sleeps.
    fn wake(&self) {
        if let Some(thread) = &self.thread {
            thread.thread().unpark();
        }
    }

    fn room(&self) -> usize {
        self.records.as_ref().map_or(0, Producer::slots)
    }
}

impl Sink for Logger {
    fn lacks_from(&self, channel: &Channel) -> Option<u64> {
        Some(self.recorded.get(channel.name).copied().unwrap_or(0))
    }

    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        if let Some(records) = &mut self.records
            && records.push((channel, message.envelope())).is_err()
        {
            self.shared.unwritten.fetch_add(1, Ordering::Relaxed);
            self.shared.fault.store(fault::DISK, Ordering::Relaxed);
        }
    }

    fn visited(&mut self) {
        let is_first = !std::mem::replace(&mut self.has_visited, true);
        if is_first || RING - self.room() >= WAKE {
            self.wake();
        }
    }

    fn has_room(&self) -> bool {
        self.room() > VISIT_ROOM
    }

    fn fault(&self) -> u32 {
        self.shared.fault.load(Ordering::Relaxed)
    }

    fn drain(&mut self) {
        let begun = Instant::now();
        self.shared.drain.store(true, Ordering::Release);
        self.wake();
        while self.shared.drain.load(Ordering::Acquire) && begun.elapsed() < DRAIN_LIMIT {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Logger {
    fn drop(&mut self) {
        let _ = self.end();
        let unwritten = self.shared.unwritten.load(Ordering::Relaxed);
        if unwritten > 0 {
            tracing::error!(unwritten, "messages could not be recorded");
        }
    }
}

/// Writes until the process has let go of its end of the ring and nothing is left in it. While the
/// disk takes nothing it goes on emptying the ring, so that the process never waits for a dead disk.
///
/// # Errors
/// The end of the recording cannot be written.
fn write_all(
    mut recorder: Recorder,
    mut records: Consumer<Record>,
    shared: &Shared,
) -> Result<(), Error> {
    // What comes first is flushed at once: it may be what a predecessor took along.
    let mut flushed = None::<Instant>;
    loop {
        let ending = records.is_abandoned();
        let draining = shared.drain.load(Ordering::Acquire);
        let mut is_empty = true;
        while let Ok((channel, envelope)) = records.pop() {
            is_empty = false;
            let written = recorder.write(channel, &envelope);
            if !written.unwrap_or_else(|error| tell(shared, &error)) {
                shared.unwritten.fetch_add(1, Ordering::Relaxed);
            }
            if recorder.is_full()
                && let Err(error) = recorder.flush()
            {
                tell(shared, &error);
            }
        }
        if draining || flushed.map_or(!is_empty, |at| at.elapsed() >= FLUSH_PERIOD) {
            flushed = Some(Instant::now());
            if let Err(error) = recorder.flush() {
                tell(shared, &error);
            }
        }
        if draining {
            shared.drain.store(false, Ordering::Release);
        }
        if ending {
            break;
        }
        let since = flushed.map_or(Duration::ZERO, |at| at.elapsed());
        std::thread::park_timeout(FLUSH_PERIOD.saturating_sub(since));
    }
    recorder.finish()
}

/// Says that the disk takes no more, or that a part is gone: not recorded.
fn tell(shared: &Shared, error: &Error) -> bool {
    tracing::error!(%error, "the recording has a gap; estimation goes on");
    shared.fault.store(fault::DISK, Ordering::Relaxed);
    false
}
