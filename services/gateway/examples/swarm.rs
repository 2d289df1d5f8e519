//! Many machines from one process, to see what a router and a collector can take: estimates with labels, and a
//! status a second each. Nothing is answered from a recording: what is lost on the way stays a gap.
//!
//! `swarm ROUTER MACHINES HZ SECONDS`; then compare what it sent with `heft fleet query`.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use gateway::key::MachineId;
use gateway::label::Label;
use gateway::link::{LinkArgs, client};
use gateway::status::{Status, Stream};
use gateway::wall_ms;
use messages::{ExcavatorEstimate, excavator_bits as x};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

const STREAM: &str = "estimate/inertia_ukf";

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let number = |i: usize| {
        args.get(i)
            .and_then(|a| a.parse::<f64>().ok())
            .expect("a number")
    };
    let (machines, hz, seconds) = (number(2) as usize, number(3), number(4));
    let link = LinkArgs {
        connect: args[1].clone(),
        zenoh_config: None,
    };
    let session = client(&link).expect("a session");
    std::thread::sleep(Duration::from_secs(1));
    let declare = |key: String| {
        let publisher = session.declare_publisher(key);
        publisher
            .congestion_control(CongestionControl::Drop)
            .wait()
            .expect("a publisher")
    };
    let all: Vec<_> = (0..machines)
        .map(|i| {
            let id = MachineId::new("swarm", &format!("m{i:05}")).expect("a name");
            let (estimates, said) = (declare(id.key(STREAM)), declare(id.key("status")));
            (id, estimates, said)
        })
        .collect();
    let epoch = wall_ms();
    let (begun, total) = (Instant::now(), (hz * seconds) as u64);
    let step = Duration::from_secs_f64(1.0 / (hz * machines as f64));
    let mut bytes = Vec::new();
    for round in 0..total {
        for (i, (id, estimates, said)) in all.iter().enumerate() {
            let due = step.mul_f64((round as usize * machines + i) as f64);
            std::thread::sleep(due.saturating_sub(begun.elapsed()));
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
            bytes.clear();
            recording::payload::encode(&message, &mut bytes);
            let label = Label {
                machine: id.machine.clone(),
                epoch,
                number: round,
                after: Some(round as i64 - 1),
                wall_ms: wall_ms(),
            };
            let _ = estimates
                .put(bytes.as_slice())
                .attachment(label.to_string())
                .wait();
            if round % (hz.ceil() as u64) == 0 {
                let head = Stream {
                    head: round as i64,
                    per_period: 1.0,
                };
                let status = Status {
                    machine: id.machine.clone(),
                    kind: "excavator".into(),
                    version: "swarm".into(),
                    epoch,
                    wall_ms: wall_ms(),
                    streams: BTreeMap::from([(STREAM.to_owned(), head)]),
                    ..Status::default()
                };
                let _ = said
                    .put(serde_json::to_vec(&status).unwrap_or_default())
                    .wait();
            }
        }
    }
    println!(
        "sent {} estimates in {:.1} s",
        total * machines as u64,
        begun.elapsed().as_secs_f64()
    );
    std::thread::sleep(Duration::from_secs(1));
    let _ = session.close().wait();
}
