//! The logger: takes every message of a machine and has a thread of its own write the recording.
//!
//! The process drains the channels on a timer and pushes what it finds into a lock-free ring; the
//! writer thread empties the ring into the file and flushes it twice a second. A disk that is slow
//! or full therefore never holds up a channel: what the ring cannot take is counted and said.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use messages::channels::Channel;
use messages::{Envelope, Message, Receiver, fault};
use recording::{Error, Metadata, Writer};
use rtrb::{Consumer, Producer, RingBuffer};
use runtime::Sink;

/// Messages that may wait for the disk: 0.4 s of an excavator at 10 kHz.
const RING: usize = 16_384;
/// Room that one visit to the channels may need.
const VISIT_ROOM: usize = 64;
/// A killed run loses at most this much, plus one visit of the logger.
const FLUSH_PERIOD: Duration = Duration::from_millis(500);
/// How long the end of a run waits for the disk.
const DRAIN_LIMIT: Duration = Duration::from_secs(10);

type Record = (&'static Channel, Envelope);

/// Takes messages and records them.
#[derive(Debug)]
pub struct Logger {
    // `None` only while dropping: the writer thread ends when this half is gone.
    records: Option<Producer<Record>>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    fault: AtomicU32,
    unwritten: AtomicU64,
}

impl Logger {
    /// Begins a recording at `path`.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn create(path: &Path, metadata: &Metadata) -> Result<Self, Error> {
        let writer = Writer::create(path, metadata)?;
        let (records, consumer) = RingBuffer::new(RING);
        let shared = Arc::new(Shared::default());
        let its = Arc::clone(&shared);
        let thread = std::thread::spawn(move || write_all(writer, consumer, &its));
        Ok(Self {
            records: Some(records),
            shared,
            thread: Some(thread),
        })
    }

    fn room(&self) -> usize {
        self.records.as_ref().map_or(0, Producer::slots)
    }
}

impl Sink for Logger {
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        if let Some(records) = &mut self.records
            && records.push((channel, message.envelope())).is_err()
        {
            self.shared.unwritten.fetch_add(1, Ordering::Relaxed);
            self.shared.fault.store(fault::DISK, Ordering::Relaxed);
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
        while self.room() < RING && begun.elapsed() < DRAIN_LIMIT {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Logger {
    fn drop(&mut self) {
        drop(self.records.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        let unwritten = self.shared.unwritten.load(Ordering::Relaxed);
        if unwritten > 0 {
            tracing::error!(unwritten, "messages could not be recorded");
        }
    }
}

struct WriteTo<'a>(&'a mut Writer, &'static Channel);

impl Receiver for WriteTo<'_> {
    type Output = Result<(), Error>;
    fn receive<M: Message>(self, message: &M) -> Self::Output {
        self.0.write(self.1, message)
    }
}

/// Writes until the process has let go of its end of the ring and nothing is left in it. After an
/// error it goes on emptying the ring, so that the process never waits for a dead disk.
fn write_all(mut writer: Writer, mut records: Consumer<Record>, shared: &Shared) {
    let mut failed = false;
    let mut flushed = Instant::now();
    loop {
        let ending = records.is_abandoned();
        while let Ok((channel, envelope)) = records.pop() {
            if failed {
                shared.unwritten.fetch_add(1, Ordering::Relaxed);
            } else if let Err(error) = envelope.open(WriteTo(&mut writer, channel)) {
                failed = tell(shared, &error);
            }
        }
        if !failed && flushed.elapsed() >= FLUSH_PERIOD {
            flushed = Instant::now();
            if let Err(error) = writer.flush() {
                failed = tell(shared, &error);
            }
        }
        if ending {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    if !failed && let Err(error) = writer.finish() {
        tell(shared, &error);
    }
}

fn tell(shared: &Shared, error: &Error) -> bool {
    tracing::error!(%error, "the recording ends here; estimation goes on");
    shared.fault.store(fault::DISK, Ordering::Relaxed);
    true
}
