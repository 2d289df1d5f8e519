//! What comes is checked before it is queued: size, rate, and that a message speaks for the machine that its
//! key names. A hostile machine can lie about itself only, and not loudly.

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
/// Messages a second that a machine may send over some time, and at once.
const RATE: f64 = 200.0;
const BURST: f64 = 1000.0;

/// A message that was checked.
#[derive(Debug, Clone)]
pub struct StreamMessage {
    /// Whose.
    pub id: MachineId,
    /// `KIND/NAME`.
    pub stream: String,
    /// Which.
    pub label: Label,
    /// As it came.
    pub payload: Vec<u8>,
    /// The message.
    pub envelope: Envelope,
}

/// What the collector's thread is given.
#[derive(Debug)]
pub enum Event {
    /// A message of a stream.
    Message(Box<StreamMessage>),
    /// A machine on itself.
    Status(MachineId, Box<Status>),
    /// A machine's token came or went.
    Token(MachineId, bool),
    /// Something under a machine's keys was not taken, and why.
    Refused(MachineId, &'static str),
    /// A question about the stream of this number has ended.
    Answered(i64, Answer),
}

/// How a question ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// Who answers has reported what it has.
    Whole(AnswerSummary),
    /// Who answers has nothing more of that run.
    Over,
    /// Nothing came, or not all of it.
    None,
}

/// Checks and queues.
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

    /// A message of a stream, live.
    pub(super) fn message(&self, sample: &Sample) {
        let Some((id, stream)) = MachineId::of(sample.key_expr().as_str()) else {
            return;
        };
        if let Some(event) = self.admitted(&id, |id| check(id, stream, sample)) {
            // What finds no place is asked for again.
            let _ = self.events.try_send(event);
        }
    }

    /// A message of a stream that Zenoh does not number, live; those that it numbers come to [`Self::message`].
    pub(super) fn message_without_number(&self, sample: &Sample) {
        let stream = MachineId::of(sample.key_expr().as_str()).map(|(_, stream)| stream);
        if stream.is_some_and(|s| kind(s) != ESTIMATE) {
            self.message(sample);
        }
    }

    /// A message of a stream that was asked for. Waits for a place.
    pub(super) fn answer(&self, sample: &Sample) {
        let Some((id, stream)) = MachineId::of(sample.key_expr().as_str()) else {
            return;
        };
        let _ = self.events.send(match check(&id, stream, sample) {
            Ok(event) => event,
            Err(why) => Event::Refused(id, why),
        });
    }

    /// What a machine says of itself.
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

    /// A token came or went.
    pub(super) fn token(&self, sample: &Sample, is_there: bool) {
        if let Some((id, _)) = MachineId::of(sample.key_expr().as_str())
            && let Some(event) = self.admitted(&id, |id| Ok(Event::Token(id.clone(), is_there)))
        {
            let _ = self.events.try_send(event);
        }
    }

    /// Messages of machines for which there was no room.
    pub(super) fn turned_away(&self) -> u64 {
        self.turned_away.load(Ordering::Relaxed)
    }

    pub(super) fn say(&self, event: Event) {
        let _ = self.events.send(event);
    }

    /// The event of what a machine may send now.
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
                // Said once a second: saying it each time would be a flood too.
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

/// The message of a sample, if it is what its key says.
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

/// Whether a stream is what a site makes: the site answers for it, not the machine.
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
            // What a site makes of a machine's samples has the names of what the machine makes itself.
            let site = pipeline.estimates();
            let site = site.map(move |c| (format!("{SITE_ESTIMATE}/{}", c.last_name()), c));
            let own = streams(pipeline, 1.0, 1.0).into_iter();
            own.map(|s| (s.name, s.channel)).chain(site)
        });
        streams.collect()
    });
    ALL.get(stream).copied()
}
