//! Publication of the queued messages, and once a second of the machine's status.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use messages::channels::Channel;
use rtrb::Consumer;
use zenoh::bytes::Encoding;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig, MissDetectionConfig};

use super::samples::{self, Samples};
use super::{Shared, full, store};
use crate::downsample::{Selection, StreamInfo};
use crate::key::MachineId;
use crate::link::{LinkArgs, client_unless};
use crate::schema;
use crate::status::{Counts, Status, Stream};

/// Messages of a stream in Zenoh's cache, which closes a short gap by itself; a longer one is closed from the recording.
const CACHE: usize = 32;
/// Period of the check of the queue.
const NAP: Duration = Duration::from_millis(50);
/// Period of the machine's status.
const PERIOD: Duration = Duration::from_secs(1);

/// The consumers of the queues to Zenoh.
pub(super) struct Outbox {
    pub selected: Consumer<Selection>,
    pub full: Consumer<full::Sample>,
    pub samples: Consumer<samples::Sample>,
}

pub(super) fn start(
    link: LinkArgs,
    shared: Arc<Shared>,
    waiting: Outbox,
    sensors: Option<&'static Channel>,
) -> JoinHandle<Result<(), String>> {
    std::thread::spawn(move || publish(&link, &shared, waiting, sensors))
}

fn publish(
    link: &LinkArgs,
    shared: &Arc<Shared>,
    mut waiting: Outbox,
    sensors: Option<&'static Channel>,
) -> Result<(), String> {
    let publishes = publishes(&shared.id);
    let publishes = publishes.each_ref().map(String::as_str);
    let leaves = || shared.leave.load(Ordering::Relaxed);
    let Some(session) = client_unless(link, &publishes, leaves)? else {
        tracing::warn!("the router was never there: everything stays in the recording");
        return Ok(());
    };
    let failed = |e: zenoh::Error| {
        crate::error(
            format!("Zenoh refuses a key: {e}"),
            &shared.id,
            "please report this",
        )
    };
    let publishers = shared.streams.iter();
    let publishers = publishers.map(|s| publisher(&session, &shared.id, s).map_err(failed));
    let publishers: Vec<_> = publishers.collect::<Result<_, _>>()?;
    let said = session
        .declare_publisher(shared.id.key("status"))
        .encoding(Encoding::APPLICATION_JSON)
        .congestion_control(CongestionControl::Drop)
        .priority(Priority::DataHigh)
        .wait()
        .map_err(failed)?;
    let token = session.liveliness().declare_token(shared.id.key("alive"));
    let token = token.wait().map_err(failed)?;
    let _answers = store::declare(&session, shared).map_err(failed)?;
    let full = full::Full::new(&session, shared);
    let samples = sensors.map(|s| Samples::declare(&session, shared, s));
    let mut samples = samples.transpose().map_err(failed)?;
    let mut last_report = Instant::now() - PERIOD;
    loop {
        let leaving = shared.leave.load(Ordering::Relaxed);
        while let Ok(selected) = waiting.selected.pop() {
            let put = publishers[selected.stream].put(selected.payload);
            let sent = put.attachment(selected.label.to_string()).wait();
            let count = if sent.is_ok() {
                &shared.sent
            } else {
                &shared.dropped
            };
            count.fetch_add(1, Ordering::Relaxed);
        }
        full.send(&mut waiting.full);
        if let Some(samples) = &mut samples {
            samples.send(&mut waiting.samples, leaving);
        }
        if last_report.elapsed() >= PERIOD || leaving {
            last_report = Instant::now();
            // A status that is lost with the link is replaced a second later.
            let _ = said.put(status(shared)).wait();
        }
        if leaving {
            break;
        }
        std::thread::sleep(NAP);
    }
    drop(token);
    let _ = session.close().wait();
    Ok(())
}

/// The keys below which a machine publishes.
pub fn publishes(id: &MachineId) -> [String; 2] {
    // A wild card does not match the keys of advanced publishers, so these are stated separately.
    ["**", "*/*/@adv/**"].map(|keys| id.key(keys))
}

/// The publisher of a stream of a machine. Zenoh closes short gaps of the estimates; the recording closes all others. Zenoh's
/// repair costs a queryable and a token for each stream, which a router announces to each machine's session.
///
/// # Errors
/// Zenoh refuses the key.
pub fn publisher(
    session: &Session,
    id: &MachineId,
    stream: &StreamInfo,
) -> zenoh::Result<AdvancedPublisher<'static>> {
    let publisher = session
        .declare_publisher(id.key(&stream.name))
        .encoding(Encoding::APPLICATION_PROTOBUF.with_schema(schema::name(stream.channel)))
        // A slow or full link costs messages, never time.
        .congestion_control(CongestionControl::Drop)
        .priority(Priority::Data)
        .advanced();
    if !stream.is_estimate() {
        return publisher.wait();
    }
    publisher
        .cache(CacheConfig::default().max_samples(CACHE))
        .sample_miss_detection(MissDetectionConfig::default().sporadic_heartbeat(PERIOD))
        .publisher_detection()
        .wait()
}

fn status(shared: &Shared) -> Vec<u8> {
    let count = |n: &std::sync::atomic::AtomicU64| n.load(Ordering::Relaxed);
    let is_over = shared.over.load(Ordering::Acquire);
    let broke_off = is_over && shared.broke_off.load(Ordering::Relaxed);
    let streams = shared
        .streams
        .iter()
        .zip(&shared.heads)
        .map(|(stream, head)| {
            let stream_now = Stream {
                head: head.load(Ordering::Relaxed),
                per_period: stream.per_period,
            };
            (stream.name.clone(), stream_now)
        });
    let status = Status {
        machine: shared.id.machine.clone(),
        kind: shared.plan.machine.clone(),
        version: shared.plan.version.clone(),
        run: shared.plan.run,
        count: shared.plan.run_count,
        // Not the host's clock at this moment: it may have been set since this process began.
        wall_ms: shared.wall_ms(runtime::now_ns()),
        ended: is_over && !broke_off,
        broke_off,
        streams: streams.collect(),
        counts: Counts {
            since_ms: shared.since_ms,
            overwritten: count(&shared.overwritten),
            sent: count(&shared.sent),
            dropped: count(&shared.dropped),
            served: count(&shared.served),
            lost: count(&shared.lost),
            samples_sent: count(&shared.samples_sent),
            samples_lost: count(&shared.samples_lost),
        },
    };
    serde_json::to_vec(&status).unwrap_or_default()
}
