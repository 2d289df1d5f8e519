//! The unmodified samples of the sensors, for a site that estimates by itself (`heft fleet serve`); only on request of the user.
//!
//! They are published under `heft/v1/SITE/MACHINE/sample/CHANNEL`, those of a fifth of a second in one message, each preceded by
//! its length (varint). The label is that of the last sample; its `after` is the last sample of the message before.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use messages::Message;
use messages::channels::Channel;
use recording::payload::{encode, put_delimited};
use rtrb::Consumer;
use zenoh::bytes::Encoding;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};

use super::Shared;
use crate::label::Label;
use crate::schema;

/// Samples that may wait for Zenoh: a second at 10 kHz.
pub(super) const QUEUE: usize = 10_000;
/// Time between two messages.
const PERIOD: Duration = Duration::from_millis(200);
/// Size after which a message is closed [bytes].
const BATCH: usize = 60_000;

/// A queued sample.
pub(super) struct Sample {
    number: u64,
    measured_ns: u64,
    bytes: Vec<u8>,
}

impl Sample {
    pub(super) fn of<M: Message>(message: &M) -> Self {
        let stamp = message.stamp();
        let mut bytes = Vec::with_capacity(160);
        encode(message, &mut bytes);
        Self {
            number: stamp.sequence,
            measured_ns: stamp.measured_ns,
            bytes,
        }
    }
}

/// Publishes the queued samples.
pub(super) struct Samples {
    publisher: Publisher<'static>,
    shared: Arc<Shared>,
    /// Number of the last published sample, -1 before the first.
    last: i64,
    sent: Instant,
}

impl Samples {
    pub(super) fn declare(
        session: &Session,
        shared: &Arc<Shared>,
        channel: &'static Channel,
    ) -> zenoh::Result<Self> {
        let publisher = session
            .declare_publisher(shared.id.key(&format!("sample/{}", channel.name)))
            .encoding(Encoding::APPLICATION_PROTOBUF.with_schema(schema::name(channel)))
            .congestion_control(CongestionControl::Drop)
            .priority(Priority::DataLow)
            .wait()?;
        Ok(Self {
            publisher,
            shared: Arc::clone(shared),
            last: -1,
            sent: Instant::now(),
        })
    }

    /// Publishes the queued samples, if the period is over or at the end.
    pub(super) fn send(&mut self, queue: &mut Consumer<Sample>, is_end: bool) {
        if self.sent.elapsed() < PERIOD && !is_end {
            return;
        }
        self.sent = Instant::now();
        while let Ok(first) = queue.pop() {
            let (mut batch, mut count) = (Vec::with_capacity(4096), 0);
            let mut last = first;
            loop {
                put_delimited(&last.bytes, &mut batch);
                count += 1;
                if batch.len() >= BATCH {
                    break;
                }
                let Ok(next) = queue.pop() else { break };
                last = next;
            }
            self.put(batch, count, (last.number, last.measured_ns));
        }
    }

    fn put(&mut self, batch: Vec<u8>, count: u64, (number, measured_ns): (u64, u64)) {
        let shared = &self.shared;
        // A gateway that joins a running run does not know what was before.
        let (after, whole) = match self.last {
            -1 => ((number + 1 == count).then_some(-1), count),
            last => (Some(last), (number as i64 - last).max(0) as u64),
        };
        let label = Label {
            machine: shared.id.machine.clone(),
            run: shared.plan.run,
            number,
            after,
            wall_ms: shared.wall_ms(measured_ns),
        };
        let put = self.publisher.put(batch).attachment(label.to_string());
        if put.wait().is_err() {
            return;
        }
        let missing = whole.saturating_sub(count);
        shared.samples_sent.fetch_add(count, Ordering::Relaxed);
        shared.samples_lost.fetch_add(missing, Ordering::Relaxed);
        self.last = number as i64;
    }
}
