//! Simulates many machines in one process, to measure the capacity of a router and a collector. Each sends estimates with labels,
//! and a status per second. There are no recordings to answer from: a lost message remains a gap.
//!
//! `swarm ROUTER MACHINES HZ SECONDS [gateways]`; then compare what it sent with `heft fleet query`. All machines share a
//! session, and declare two keys each; `gateways`: each has a session, and everything that a gateway declares.

use std::any::Any;
use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use gateway::downsample::streams;
use gateway::key::MachineId;
use gateway::label::Label;
use gateway::link::{LinkArgs, client};
use gateway::machine::{publisher, publishes};
use gateway::status::{Status, Stream};
use gateway::wall_ms;
use messages::{ExcavatorEstimate, excavator_bits as x};
use steps::stages::Pipeline;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};
use zenoh_ext::AdvancedPublisher;

const STREAM: &str = "estimate/inertia_ukf";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let numbers = args.iter().skip(1).take(3).map(|a| a.parse::<f64>());
    let numbers: Vec<f64> = numbers.flatten().filter(|number| *number > 0.0).collect();
    let (Some(router), &[machines, hz, seconds]) = (args.first(), &numbers[..]) else {
        eprintln!("usage: swarm ROUTER MACHINES HZ SECONDS [gateways]");
        return ExitCode::from(2);
    };
    let link = LinkArgs {
        connect: router.clone(),
        zenoh_config: None,
    };
    simulate(&link, machines as usize, [hz, seconds], &args[4..]);
    ExitCode::SUCCESS
}

fn simulate(link: &LinkArgs, machines: usize, [hz, seconds]: [f64; 2], more: &[String]) {
    let alone = more.first().is_some_and(|a| a == "gateways");
    let open = |publishes: &[&str]| client(link, publishes).expect("a session");
    let shared = (!alone).then(|| open(&["heft/v1/swarm/**"]));
    std::thread::sleep(Duration::from_secs(1));
    let began = Instant::now();
    let all: Vec<Machine> = (0..machines)
        .map(|i| {
            let id = MachineId::new("swarm", &format!("m{i:05}")).expect("a name");
            match &shared {
                Some(session) => Machine::sharing(session, id),
                None => Machine::alone(open(&publishes(&id).each_ref().map(String::as_str)), id),
            }
        })
        .collect();
    println!("declared in {:.1} s", began.elapsed().as_secs_f64());
    let run = wall_ms();
    let (begun, total) = (Instant::now(), (hz * seconds) as u64);
    let step = Duration::from_secs_f64(1.0 / (hz * machines as f64));
    let mut bytes = Vec::new();
    for round in 0..total {
        for (i, machine) in all.iter().enumerate() {
            let due = step.mul_f64((round as usize * machines + i) as f64);
            std::thread::sleep(due.saturating_sub(begun.elapsed()));
            let message = estimate(round, i, hz);
            bytes.clear();
            recording::payload::encode(&message, &mut bytes);
            machine.send(&bytes, run, round);
            if round % (hz.ceil() as u64) == 0 {
                machine.report(run, round);
            }
        }
    }
    println!(
        "sent {} estimates in {:.1} s",
        total * machines as u64,
        begun.elapsed().as_secs_f64()
    );
    std::thread::sleep(Duration::from_secs(1));
}

/// The estimate of machine `i` in this round.
fn estimate(round: u64, i: usize, hz: f64) -> ExcavatorEstimate {
    let value = (round as f64 * 0.1 + i as f64).sin();
    let mut message = ExcavatorEstimate {
        inertia: 5800.0 + 100.0 * value,
        inertia_std: 60.0 + value,
        payload: 400.0 + 30.0 * value,
        payload_std: 25.0 + value,
        damping: 900.0 + value,
        damping_std: 80.0 + value,
        nis: 1.0 + 0.1 * value,
        estimated: x::INERTIA | x::PAYLOAD | x::DAMPING,
        flags: x::TRUSTED,
        ..ExcavatorEstimate::default()
    };
    (message.stamp.sequence, message.stamp.time) = (round, round as f64 / hz);
    message
}

/// A machine and its Zenoh declarations.
struct Machine {
    id: MachineId,
    estimates: Estimates,
    said: Publisher<'static>,
    _more: Option<Box<dyn Any>>,
}

enum Estimates {
    Plain(Publisher<'static>),
    /// Publishers of all streams, that of the estimates first.
    Advanced(Vec<AdvancedPublisher<'static>>),
}

fn plain(session: &Session, key: String) -> Publisher<'static> {
    let publisher = session.declare_publisher(key);
    let publisher = publisher.congestion_control(CongestionControl::Drop);
    publisher.wait().expect("a publisher")
}

impl Machine {
    fn sharing(session: &Session, id: MachineId) -> Self {
        Self {
            estimates: Estimates::Plain(plain(session, id.key(STREAM))),
            said: plain(session, id.key("status")),
            id,
            _more: None,
        }
    }

    /// Sends an encoded estimate with its label.
    fn send(&self, bytes: &[u8], run: u64, round: u64) {
        let label = Label {
            machine: self.id.machine.clone(),
            run,
            number: round,
            after: Some(round as i64 - 1),
            wall_ms: wall_ms(),
        };
        let label = label.to_string();
        let _ = match &self.estimates {
            Estimates::Plain(publisher) => publisher.put(bytes).attachment(label).wait(),
            Estimates::Advanced(publishers) => publishers[0].put(bytes).attachment(label).wait(),
        };
    }

    /// Publishes its status, and the head of its stream.
    fn report(&self, run: u64, round: u64) {
        let head = Stream {
            head: round as i64,
            per_period: 1.0,
        };
        let status = Status {
            machine: self.id.machine.clone(),
            kind: "excavator".into(),
            version: "swarm".into(),
            run,
            wall_ms: wall_ms(),
            streams: BTreeMap::from([(STREAM.to_owned(), head)]),
            ..Status::default()
        };
        let bytes = serde_json::to_vec(&status).unwrap_or_default();
        let _ = self.said.put(bytes).wait();
    }

    fn alone(session: Session, id: MachineId) -> Self {
        let mut streams = streams(Pipeline::of(messages::Machine::Excavator), 1.0, 1.0);
        streams.sort_by_key(|s| s.name != STREAM);
        let publishers = streams.iter();
        let publishers = publishers.map(|s| publisher(&session, &id, s).expect("a publisher"));
        let publishers = publishers.collect();
        let said = plain(&session, id.key("status"));
        let token = session.liveliness().declare_token(id.key("alive"));
        let token = token.wait().expect("a token");
        let answers = session.declare_queryable(id.key("*/*")).callback(drop);
        let answers = answers.wait().expect("a queryable");
        Self {
            id,
            estimates: Estimates::Advanced(publishers),
            said,
            _more: Some(Box::new((session, token, answers))),
        }
    }
}
