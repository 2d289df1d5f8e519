//! The estimates of `heft serve`, published as those of the site under the key of their machine.

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

use super::intake::Intake;
use super::machine::run_of;
use crate::collector::decode;
use crate::error;
use crate::key::{MachineId, SITE_ESTIMATE};
use crate::label::Label;
use crate::schema;

/// Largest estimate, and longest name of a run [bytes].
const LARGEST: usize = 4096;
/// Runs of a machine of which the last estimate is remembered.
const RUNS: usize = 8;
/// Time between two looks for machines that are gone.
const LOOK: Duration = Duration::from_secs(60);

/// Publishes.
pub(super) struct Answers {
    session: Session,
    site: String,
    /// `site/CHANNEL`.
    stream: String,
    encoding: Encoding,
    intake: Arc<Intake>,
    machines: HashMap<String, Relay>,
}

/// What was sent of a machine.
struct Relay {
    publisher: Publisher<'static>,
    /// The runs that were reported last, with the number of the last estimate of each.
    last: VecDeque<(u64, i64)>,
}

impl Relay {
    /// Notes an estimate of a run; returns the number of the one before, -1 before the first.
    fn follow(&mut self, run: u64, number: i64) -> i64 {
        if let Some((_, last)) = self.last.iter_mut().find(|(id, _)| *id == run) {
            return std::mem::replace(last, number);
        }
        if self.last.len() >= RUNS {
            self.last.pop_front();
        }
        self.last.push_back((run, number));
        -1
    }
}

impl Answers {
    pub(super) fn new(
        session: &Session,
        site: &str,
        channel: &'static Channel,
        intake: Arc<Intake>,
    ) -> Self {
        let last = channel.name.rsplit('/').next().unwrap_or_default();
        Self {
            session: session.clone(),
            site: site.to_owned(),
            stream: format!("{SITE_ESTIMATE}/{last}"),
            encoding: Encoding::APPLICATION_PROTOBUF.with_schema(schema::name(channel)),
            intake,
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
                self.put(machine, run, envelope.stamp(), &message)?;
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
        message: &[u8],
    ) -> Result<(), String> {
        let Some(wall_ms) = self.intake.answered(machine, run, stamp.measured_ns) else {
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
            after: Some(relay.follow(run, stamp.sequence as i64)),
            wall_ms,
        };
        let put = relay.publisher.put(message).attachment(label.to_string());
        // A link that is gone shows as a gap where somebody collects.
        let _ = put.wait();
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
