//! Every sample of the estimates, on request and for a limited time.
//!
//! A query on `heft/v1/SITE/MACHINE/control/full?for=60` starts it. The samples are published under
//! `heft/v1/SITE/MACHINE/full/estimate/CHANNEL`, many in one message, each preceded by its length (varint).

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use messages::channels::{Channel, Rate};
use messages::{Carries, Message};
use recording::payload::put_delimited;
use rtrb::{Consumer, Producer};
use zenoh::key_expr::KeyExpr;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::Query;
use zenoh::{Session, Wait};

use super::Shared;

/// Samples that may wait for Zenoh.
pub(super) const QUEUE: usize = 16_384;
/// Longest time that can be requested \[s\].
pub const LONGEST: f64 = 600.0;
/// Size after which a message is closed [bytes].
const BATCH: usize = 60_000;

/// A sample and its channel.
pub(super) type Sample = (&'static Channel, Vec<u8>);

/// Queues a sample of an estimate; a sample that does not fit shows as a gap in the numbers.
pub(super) fn push<M: Message>(
    queue: &mut Producer<Sample>,
    channel: &'static Channel,
    message: &M,
) {
    let is_estimate = channel.payload.carries() == Carries::Estimate;
    if is_estimate && channel.rate == Rate::Sensors && queue.slots() > 0 {
        let mut bytes = Vec::with_capacity(256);
        recording::payload::encode(message, &mut bytes);
        let _ = queue.push((channel, bytes));
    }
}

/// Publishes the queued samples.
pub(super) struct Full {
    session: Session,
    shared: Arc<Shared>,
}

/// Handler of `control/full`; it ignores other queries.
pub(super) fn control(shared: &Arc<Shared>) -> zenoh::Result<impl Fn(&Query) + use<>> {
    let key = KeyExpr::new(shared.id.key("control/full"))?;
    let shared = Arc::clone(shared);
    Ok(move |query: &Query| {
        if !query.key_expr().intersects(&key) {
            return;
        }
        let seconds = query.parameters().get("for");
        let seconds = seconds.and_then(|v| v.parse::<f64>().ok());
        let answer = match seconds.filter(|s| (0.0..=LONGEST).contains(s)) {
            Some(seconds) => {
                let until = runtime::now_ns() + (seconds * 1e9) as u64;
                shared.full_until.store(until, Ordering::Relaxed);
                query.reply(key.clone(), format!("{seconds}")).wait()
            }
            None => query.reply_err(format!("for: 0 to {LONGEST} s")).wait(),
        };
        // The querier may be gone.
        let _ = answer;
    })
}

impl Full {
    pub(super) fn new(session: &Session, shared: &Arc<Shared>) -> Self {
        Self {
            session: session.clone(),
            shared: Arc::clone(shared),
        }
    }

    pub(super) fn send(&self, queue: &mut Consumer<Sample>) {
        let mut batches: BTreeMap<&str, Vec<u8>> = BTreeMap::new();
        while let Ok((channel, sample)) = queue.pop() {
            let name = channel.last_name();
            let batch = batches.entry(name).or_default();
            put_delimited(&sample, batch);
            if batch.len() > BATCH {
                self.put(name, std::mem::take(batch));
            }
        }
        for (name, batch) in batches {
            self.put(name, batch);
        }
    }

    fn put(&self, name: &str, batch: Vec<u8>) {
        if batch.is_empty() {
            return;
        }
        let put = self
            .session
            .put(self.shared.id.key(&format!("full/estimate/{name}")), batch);
        let put = put
            .congestion_control(CongestionControl::Drop)
            .priority(Priority::DataLow);
        // A message lost with the link shows as a gap in the numbers.
        let _ = put.attachment(self.shared.id.machine.as_str()).wait();
    }
}
