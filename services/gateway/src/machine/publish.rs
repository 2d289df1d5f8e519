//! Hands to Zenoh what waits in the queue, and says once a second how the machine is.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rtrb::Consumer;
use zenoh::Wait;
use zenoh::bytes::Encoding;
use zenoh::qos::{CongestionControl, Priority};
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig, MissDetectionConfig};

use super::{Shared, full, store};
use crate::link::{LinkArgs, client_unless};
use crate::schema;
use crate::status::{Counts, Status, Stream};
use crate::thin::Selected;
use crate::wall_ms;

/// Messages of a stream that Zenoh keeps to mend a short gap by itself; a longer one is mended from the recording.
const CACHE: usize = 32;
/// Time between two looks at the queue.
const NAP: Duration = Duration::from_millis(50);
/// Time between two words on the machine itself.
const PERIOD: Duration = Duration::from_secs(1);

pub(super) fn start(
    link: LinkArgs,
    shared: Arc<Shared>,
    queue: Consumer<Selected>,
    samples: Consumer<full::Sample>,
) -> JoinHandle<Result<(), String>> {
    std::thread::spawn(move || publish(&link, &shared, queue, samples))
}

fn publish(
    link: &LinkArgs,
    shared: &Arc<Shared>,
    mut queue: Consumer<Selected>,
    mut samples: Consumer<full::Sample>,
) -> Result<(), String> {
    let Some(session) = client_unless(link, || shared.leave.load(Ordering::Relaxed))? else {
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
    let publishers = shared.streams.iter().map(|stream| {
        session
            .declare_publisher(shared.id.key(&stream.name))
            .encoding(Encoding::APPLICATION_PROTOBUF.with_schema(schema::name(stream.channel)))
            // A link that is slow or full costs messages, never time.
            .congestion_control(CongestionControl::Drop)
            .priority(Priority::Data)
            .cache(CacheConfig::default().max_samples(CACHE))
            .sample_miss_detection(MissDetectionConfig::default().sporadic_heartbeat(PERIOD))
            .publisher_detection()
            .wait()
            .map_err(failed)
    });
    let publishers: Vec<AdvancedPublisher<'_>> = publishers.collect::<Result<_, _>>()?;
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
    let _schemas =
        schema::serve(&session, shared.id.key("").trim_end_matches('/')).map_err(failed)?;
    let full = full::Full::declare(&session, shared).map_err(failed)?;
    let mut told = Instant::now() - PERIOD;
    loop {
        let leaving = shared.leave.load(Ordering::Relaxed);
        while let Ok(selected) = queue.pop() {
            let put = publishers[selected.stream].put(selected.payload);
            let sent = put.attachment(selected.label.to_string()).wait();
            let count = if sent.is_ok() {
                &shared.sent
            } else {
                &shared.dropped
            };
            count.fetch_add(1, Ordering::Relaxed);
        }
        full.send(&mut samples);
        if told.elapsed() >= PERIOD || leaving {
            told = Instant::now();
            // Lost with the link, and said again in a second.
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

fn status(shared: &Shared) -> Vec<u8> {
    let count = |n: &std::sync::atomic::AtomicU64| n.load(Ordering::Relaxed);
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
        epoch: shared.plan.begun_ms,
        wall_ms: wall_ms(),
        ended: shared.ended.load(Ordering::Relaxed),
        streams: streams.collect(),
        counts: Counts {
            since_ms: shared.since_ms,
            overwritten: count(&shared.overwritten),
            sent: count(&shared.sent),
            dropped: count(&shared.dropped),
            served: count(&shared.served),
            lost: count(&shared.lost),
        },
    };
    serde_json::to_vec(&status).unwrap_or_default()
}
