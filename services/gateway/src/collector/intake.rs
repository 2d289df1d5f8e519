//! Checks of incoming messages before they are queued: size, rate, and that a message belongs to the machine in its key. A
//! hostile machine can falsify only its own data, at a limited rate.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{LazyLock, Mutex};
use std::time::Instant;

use messages::channels::{Channel, Visitor};
use messages::{Envelope, Machine, Message, Value};
use steps::stages::Pipeline;
use zenoh::sample::Sample;

use super::strangers::{Contact, leave};
use crate::downsample::{health_number, streams};
use crate::key::{ESTIMATE, MachineId, SITE_ESTIMATE};
use crate::label::Label;
use crate::question::AnswerSummary;
use crate::status::Status;
use crate::{MACHINES, lock};

/// Largest message [bytes].
pub const LARGEST: usize = 2048;
/// Message rate of a machine [1/s]: sustained here, burst below.
const RATE: f64 = 200.0;
const BURST: f64 = 1000.0;

/// A message that has passed the checks.
#[derive(Debug, Clone)]
pub struct StreamMessage {
    /// The machine.
    pub id: MachineId,
    /// `KIND/NAME`.
    pub stream: String,
    /// Its label.
    pub label: Label,
    /// The payload as received.
    pub payload: Vec<u8>,
    /// The payload, decoded.
    pub envelope: Envelope,
}

/// An input of the collector's thread.
#[derive(Debug)]
pub enum Event {
    /// A message of a stream.
    Message(Box<StreamMessage>),
    /// The status of a machine.
    Status(MachineId, Box<Status>),
    /// The token of a machine appeared or disappeared.
    Token(MachineId, bool),
    /// A message under a machine's keys was refused, with the reason.
    Refused(MachineId, &'static str),
    /// A request for the stream of this number has ended.
    Answered(i64, Answer),
}

/// Outcome of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// The answering side has reported how far its messages go.
    Whole(AnswerSummary),
    /// The answering side has nothing more of that run.
    Over,
    /// No reply, or an incomplete one.
    None,
}

/// Checks messages and queues them.
pub struct Intake {
    events: SyncSender<Event>,
    rates: Mutex<HashMap<MachineId, Bucket>>,
    turned_away: AtomicU64,
}

struct Bucket {
    left: f64,
    seen: Instant,
    heard: Contact,
    reported: Option<Instant>,
}

impl Intake {
    pub(super) fn new(events: SyncSender<Event>) -> Self {
        Self {
            events,
            rates: Mutex::default(),
            turned_away: AtomicU64::new(0),
        }
    }

    /// Takes a live message of a stream.
    pub(super) fn message(&self, sample: &Sample) {
        let Some((id, stream)) = MachineId::of(sample.key_expr().as_str()) else {
            return;
        };
        if let Some(event) = self.admitted(&id, |id| check(id, stream, sample)) {
            // A message that does not fit is requested later.
            let _ = self.events.try_send(event);
        }
    }

    /// Takes a live message of a stream without Zenoh's numbers; numbered streams arrive at [`Self::message`].
    pub(super) fn message_without_number(&self, sample: &Sample) {
        let stream = MachineId::of(sample.key_expr().as_str()).map(|(_, stream)| stream);
        if stream.is_some_and(|s| kind(s) != ESTIMATE) {
            self.message(sample);
        }
    }

    /// Takes a message that was requested. Blocks until the queue has room.
    pub(super) fn answer(&self, sample: &Sample) {
        let Some((id, stream)) = MachineId::of(sample.key_expr().as_str()) else {
            return;
        };
        let _ = self.events.send(match check(&id, stream, sample) {
            Ok(event) => event,
            Err(why) => Event::Refused(id, why),
        });
    }

    /// Takes a machine's status.
    pub(super) fn status(&self, sample: &Sample) {
        let Some((id, _)) = MachineId::of(sample.key_expr().as_str()) else {
            return;
        };
        let event = self.admitted(&id, |id| {
            let status = Status::parse(&sample.payload().to_bytes()).ok_or("no status")?;
            if status.machine != id.machine {
                return Err("speaks for another machine");
            }
            Ok(Event::Status(id.clone(), Box::new(status)))
        });
        if let Some(event) = event {
            let _ = self.events.try_send(event);
        }
    }

    /// Takes the appearance or disappearance of a token.
    pub(super) fn token(&self, sample: &Sample, is_there: bool) {
        if let Some((id, _)) = MachineId::of(sample.key_expr().as_str())
            && let Some(event) = self.admitted(&id, |id| Ok(Event::Token(id.clone(), is_there)))
        {
            let _ = self.events.try_send(event);
        }
    }

    /// Number of messages refused because the table of machines is full.
    pub(super) fn turned_away(&self) -> u64 {
        self.turned_away.load(Ordering::Relaxed)
    }

    pub(super) fn say(&self, event: Event) {
        let _ = self.events.send(event);
    }

    /// Applies the rate limit, then the check; returns the resulting event.
    fn admitted(
        &self,
        id: &MachineId,
        check: impl FnOnce(&MachineId) -> Result<Event, &'static str>,
    ) -> Option<Event> {
        {
            let mut rates = lock(&self.rates);
            if !rates.contains_key(id) && rates.len() >= MACHINES {
                for other in leave(rates.iter().map(|(id, b)| (id, b.heard)), MACHINES) {
                    rates.remove(&other);
                }
                if rates.len() >= MACHINES {
                    self.turned_away.fetch_add(1, Ordering::Relaxed);
                    return None;
                }
            }
            let now = Instant::now();
            let bucket = rates.entry(id.clone()).or_insert(Bucket {
                left: BURST,
                seen: now,
                heard: Contact::now(),
                reported: None,
            });
            bucket.heard.again();
            let earned = now.duration_since(bucket.seen).as_secs_f64() * RATE;
            bucket.left = (bucket.left + earned).min(BURST);
            bucket.seen = now;
            if bucket.left < 1.0 {
                // Reported once a second: a report per message would be a flood of its own.
                let is_due = bucket.reported.is_none_or(|t| t.elapsed().as_secs() >= 1);
                return is_due.then(|| {
                    bucket.reported = Some(now);
                    Event::Refused(id.clone(), "too many messages")
                });
            }
            bucket.left -= 1.0;
        }
        Some(match check(id) {
            Ok(event) => event,
            Err(why) => Event::Refused(id.clone(), why),
        })
    }
}

/// The message of a sample, if it agrees with its key and label.
fn check(id: &MachineId, stream: &str, sample: &Sample) -> Result<Event, &'static str> {
    if sample.payload().len() > LARGEST {
        return Err("too large");
    }
    let label = sample
        .attachment()
        .and_then(|a| Label::parse(&a.to_bytes()));
    let label = label.ok_or("no label")?;
    if label.machine != id.machine {
        return Err("speaks for another machine");
    }
    let payload = sample.payload().to_bytes().into_owned();
    let envelope = decode(stream, &payload).ok_or("no message of its stream")?;
    let number = match &envelope {
        Envelope::Health(health) => health_number(health),
        other => other.stamp().sequence,
    };
    if number != label.number {
        return Err("a label of another message");
    }
    Ok(Event::Message(Box::new(StreamMessage {
        id: id.clone(),
        stream: stream.to_owned(),
        label,
        payload,
        envelope,
    })))
}

/// The message of a stream, if every number in it is finite.
pub fn decode(stream: &str, payload: &[u8]) -> Option<Envelope> {
    struct Decode<'a>(&'a [u8]);
    impl Visitor for Decode<'_> {
        type Output = Option<Envelope>;
        fn visit<M: Message>(self) -> Self::Output {
            let message = recording::payload::decode::<M>(self.0)?;
            let is_finite = |i| !matches!(message.get(i), Some(Value::F64(x)) if !x.is_finite());
            (0..M::FIELDS.len())
                .all(is_finite)
                .then(|| message.envelope())
        }
    }
    channel(stream)?.payload.visit(Decode(payload))
}

/// Whether a machine can have a stream of this name.
pub fn is_stream(name: &str) -> bool {
    channel(name).is_some()
}

/// Whether a site makes the stream: then the site answers requests for it, not the machine.
pub fn is_of_site(name: &str) -> bool {
    kind(name) == SITE_ESTIMATE
}

/// The kind of a stream: what its name begins with.
fn kind(stream: &str) -> &str {
    stream.split_once('/').map_or(stream, |(kind, _)| kind)
}

/// The channel that a stream is selected from.
fn channel(stream: &str) -> Option<&'static Channel> {
    static ALL: LazyLock<HashMap<String, &'static Channel>> = LazyLock::new(|| {
        let machines = Machine::ALL.into_iter().map(Pipeline::of);
        let streams = machines.flat_map(|pipeline| {
            // A site's estimates have the same channels as those of the machine itself.
            let site = pipeline.estimates();
            let site = site.map(move |c| (format!("{SITE_ESTIMATE}/{}", c.last_name()), c));
            let own = streams(pipeline, 1.0, 1.0).into_iter();
            own.map(|s| (s.name, s.channel)).chain(site)
        });
        streams.collect()
    });
    ALL.get(stream).copied()
}
