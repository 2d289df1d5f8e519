//! The logger: takes every message of a machine and writes the recording on a separate thread.
//!
//! The process drains the channels on a timer and pushes the messages into a lock-free ring. The
//! writer thread empties the ring into the file and flushes twice a second, sooner when a quarter of it is full. A slow or full
//! disk therefore never delays a channel: messages that the ring cannot take are counted and reported.

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

mod ages;
mod bus;
mod mark;
mod recorder;

pub use bus::BusWriter;
use mark::{Mark, Next};
pub use recorder::Limits;
use recorder::Recorder;

/// Number of messages that may wait for the disk: 0.4 s of an excavator at 10 kHz.
const RING: usize = 16_384;
/// Number of waiting messages that wakes the writer. Each wake costs more than writing a message.
const WAKE: usize = RING / 4;
/// Largest number of messages of one visit to the channels.
const VISIT_ROOM: usize = 64;
/// Longest time between two flushes. A killed run loses at most this much, plus one visit of the logger. If only the logger is killed,
/// its successor receives the messages that the writers of the channels still hold, and nothing is lost.
const FLUSH_PERIOD: Duration = Duration::from_millis(500);
/// Longest wait for the disk at the end of a run.
const DRAIN_LIMIT: Duration = Duration::from_secs(10);

type Record = (&'static Channel, Envelope);

/// Takes messages and records them.
#[derive(Debug)]
pub struct Logger {
    // `None` only while dropping: the writer thread ends when this half is dropped.
    records: Option<Producer<Record>>,
    /// Contents of the recording at the start.
    recorded: Next,
    /// Whether the first visit to the channels is over: its messages are written at once.
    has_visited: bool,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<(), Error>>>,
}

#[derive(Debug, Default)]
struct Shared {
    fault: AtomicU32,
    unwritten: AtomicU64,
    /// Request to write and flush all messages now; the writer resets it when that is done.
    drain: AtomicBool,
}

impl Logger {
    /// Starts the recording `path`, or its next part where it exists already: the file of a
    /// killed logger stays unchanged. The file `mark` contains its progress.
    ///
    /// # Errors
    /// The file cannot be created.
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
    /// Its end cannot be written; the messages before it are there, and are read as a truncated recording.
    pub fn finish(mut self) -> Result<(), Error> {
        self.end()
    }

    fn end(&mut self) -> Result<(), Error> {
        drop(self.records.take());
        self.wake();
        let ended = self.thread.take().map(JoinHandle::join);
        // A panic of the writer has been printed already.
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

/// Writes until the process has dropped its end of the ring and the ring is empty. While the
/// disk takes nothing it continues to empty the ring, so that the process never waits for a dead disk.
///
/// # Errors
/// The end of the recording cannot be written.
fn write_all(
    mut recorder: Recorder,
    mut records: Consumer<Record>,
    shared: &Shared,
) -> Result<(), Error> {
    // The first messages are flushed at once: a predecessor may have lost them.
    let mut flushed = None::<Instant>;
    loop {
        let ending = records.is_abandoned();
        let draining = shared.drain.load(Ordering::Acquire);
        let mut is_empty = true;
        while let Ok((channel, envelope)) = records.pop() {
            is_empty = false;
            let written = recorder.write(channel, &envelope);
            if !written.unwrap_or_else(|error| report(shared, &error)) {
                shared.unwritten.fetch_add(1, Ordering::Relaxed);
            }
            if recorder.is_full()
                && let Err(error) = recorder.flush()
            {
                report(shared, &error);
            }
        }
        if draining || flushed.map_or(!is_empty, |at| at.elapsed() >= FLUSH_PERIOD) {
            flushed = Some(Instant::now());
            if let Err(error) = recorder.flush() {
                report(shared, &error);
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

/// Reports that the disk takes no more, or that a part is gone; returns false: not recorded.
fn report(shared: &Shared, error: &Error) -> bool {
    tracing::error!(%error, "the recording has a gap; estimation goes on");
    shared.fault.store(fault::DISK, Ordering::Relaxed);
    false
}
