//! Publication of the estimates of `heft serve`: under the key of their machine, as estimates of the site, and stored for
//! requests of lost ones.

use std::collections::{HashMap, VecDeque};
use std::io::BufRead;
use std::sync::Arc;
use std::time::{Duration, Instant};

use messages::Stamp;
use messages::channels::Channel;
use recording::payload::read_delimited;
use zenoh::bytes::Encoding;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};

use super::intake::{Answered, Intake};
use super::kept::{Answer, Kept};
use super::machine::run_of;
use crate::collector::decode;
use crate::error;
use crate::key::{MachineId, SITE_ESTIMATE};
use crate::label::Label;
use crate::schema;

/// Largest estimate, and longest name of a run [bytes].
const LARGEST: usize = 4096;
/// Runs of a machine whose last estimate is remembered.
const RUNS: usize = 8;
/// Period of the check for machines that are gone.
const LOOK: Duration = Duration::from_secs(60);

/// The stream of a site's estimates.
pub(super) fn stream(channel: &Channel) -> String {
    format!("{SITE_ESTIMATE}/{}", channel.last_name())
}

/// Repeats the last answers of runs, which may not have arrived.
pub(super) fn say_again(session: &Session, site: &str, stream: &str, kept: &Kept) {
    for answer in kept.due(Instant::now()) {
        let Some(id) = MachineId::new(site, &answer.label.machine) else {
            continue;
        };
        let put = session.put(id.key(stream), answer.payload.as_slice());
        let put = put.attachment(answer.label.to_string());
        let _ = put.congestion_control(CongestionControl::Drop).wait();
    }
}

/// Publishes the estimates.
pub(super) struct Answers {
    session: Session,
    site: String,
    /// `site/CHANNEL`.
    stream: String,
    encoding: Encoding,
    intake: Arc<Intake>,
    kept: Arc<Kept>,
    machines: HashMap<String, Relay>,
}

/// Publication state of a machine.
struct Relay {
    publisher: Publisher<'static>,
    /// The latest runs, with the number of the last estimate of each.
    last: VecDeque<(u64, i64)>,
}

impl Relay {
    /// Notes an estimate of a run; returns the number of the one before, -1 before the first. Returns `None` if samples are
    /// missing in between, or before the first.
    fn follow(&mut self, run: u64, number: i64, is_after_gap: bool) -> Option<i64> {
        if let Some((_, last)) = self.last.iter_mut().find(|(id, _)| *id == run) {
            let before = std::mem::replace(last, number);
            return (!is_after_gap).then_some(before);
        }
        if self.last.len() >= RUNS {
            self.last.pop_front();
        }
        self.last.push_back((run, number));
        (!is_after_gap).then_some(-1)
    }
}

impl Answers {
    pub(super) fn new(
        session: &Session,
        site: &str,
        channel: &'static Channel,
        intake: Arc<Intake>,
        kept: Arc<Kept>,
    ) -> Self {
        Self {
            session: session.clone(),
            site: site.to_owned(),
            stream: stream(channel),
            encoding: Encoding::APPLICATION_PROTOBUF.with_schema(schema::name(channel)),
            intake,
            kept,
            machines: HashMap::new(),
        }
    }

    /// Publishes until the output of `heft serve` ends.
    pub(super) fn publish(mut self, mut output: impl BufRead) -> Result<(), String> {
        let (mut name, mut message) = (Vec::new(), Vec::new());
        let mut looked = Instant::now();
        let unreadable = |e| {
            error(
                e,
                "the output of `heft serve`",
                "use heft of the same version",
            )
        };
        while read_delimited(&mut output, LARGEST, &mut name).map_err(unreadable)? {
            read_delimited(&mut output, LARGEST, &mut message).map_err(unreadable)?;
            let run = std::str::from_utf8(&name).ok().and_then(run_of);
            let envelope = decode(&self.stream, &message);
            if let (Some((machine, run)), Some(envelope)) = (run, envelope) {
                self.put(machine, run, envelope.stamp(), std::mem::take(&mut message))?;
            }
            if looked.elapsed() >= LOOK {
                looked = Instant::now();
                self.machines.retain(|name, _| self.intake.knows(name));
            }
        }
        Ok(())
    }

    fn put(
        &mut self,
        machine: &str,
        run: u64,
        stamp: &Stamp,
        payload: Vec<u8>,
    ) -> Result<(), String> {
        let Some(Answered {
            wall_ms,
            is_after_gap,
        }) = self.intake.answered(machine, run, stamp)
        else {
            return Ok(());
        };
        if !self.machines.contains_key(machine) {
            let publisher = self.declare(machine)?;
            let relay = Relay {
                publisher,
                last: VecDeque::new(),
            };
            self.machines.insert(machine.to_owned(), relay);
        }
        let Some(relay) = self.machines.get_mut(machine) else {
            return Ok(());
        };
        let label = Label {
            machine: machine.to_owned(),
            run,
            number: stamp.sequence,
            after: relay.follow(run, stamp.sequence as i64, is_after_gap),
            wall_ms,
        };
        let answer = Arc::new(Answer { label, payload });
        // Stored first: a receiver may request it at once.
        self.kept.keep(Arc::clone(&answer), Instant::now());
        let put = relay.publisher.put(answer.payload.as_slice());
        // A message that is lost with the link, or by congestion, is requested later.
        let _ = put.attachment(answer.label.to_string()).wait();
        Ok(())
    }

    fn declare(&self, machine: &str) -> Result<Publisher<'static>, String> {
        let id = MachineId::new(&self.site, machine);
        let id = id.ok_or_else(|| error("no name of a machine", machine, "report this"))?;
        let publisher = self.session.declare_publisher(id.key(&self.stream));
        let publisher = publisher.encoding(self.encoding.clone());
        let publisher = publisher.congestion_control(CongestionControl::Drop);
        let publisher = publisher.priority(Priority::Data).wait();
        publisher.map_err(|e| error(format!("Zenoh refuses a key: {e}"), id, "report this"))
    }
}
