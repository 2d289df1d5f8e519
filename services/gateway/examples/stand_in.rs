//! A stand-in for a pipeline: the channels and the recording of an excavator, with estimates whose number and
//! verdicts are known. Tests attach a gateway to it, and count the messages.
//!
//! `stand_in DOMAIN FOLDER RATE SECONDS [BYTES_A_PART BYTES_KEPT] [samples=FILE]`: those of a file are sent from the
//! [`WAIT`]th second on, when the subscribers are connected.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use logger::{Limits, Logger};
use messages::channels::{
    EXCAVATOR_INERTIA_RLS, EXCAVATOR_INERTIA_UKF, EXCAVATOR_SENSORS, HEALTH, of_machine,
};
use messages::{
    ExcavatorEstimate, ExcavatorSensors, Health, Machine, Message, excavator_bits as x,
};
use recording::Metadata;
use runtime::{Domain, Ports, Sink, now_ns};

/// Time of the first samples [s].
const WAIT: f64 = 6.0;

const USAGE: &str =
    "usage: stand_in DOMAIN FOLDER RATE SECONDS [BYTES_A_PART BYTES_KEPT] [samples=FILE]";

fn main() -> ExitCode {
    let (named, args): (Vec<String>, Vec<String>) =
        std::env::args().partition(|a| a.starts_with("samples="));
    let file = named.first().and_then(|a| a.strip_prefix("samples="));
    let rows = file.map(|f| recording::load::<ExcavatorSensors>(f, None).expect("samples"));
    let mut rows = rows.into_iter().flatten();
    let number = |i: usize| args.get(i).and_then(|a| a.parse::<f64>().ok());
    let (Some(rate), Some(seconds)) = (number(3), number(4)) else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let run = gateway::wall_ms() + u64::from(std::process::id());
    let owner = Domain::new(&args[1])
        .and_then(|d| d.take())
        .expect("a free domain");
    let file = recording::reserve(std::path::Path::new(&args[2])).expect("a folder");
    let plan = serde_json::json!({
        "machine": "excavator", "rate": rate, "recording": file, "run": run, "run_count": 0, "version": "stand-in",
    });
    owner.domain().enter().expect("the domain");
    let ports = Ports::new("stand-in").expect("ports");
    let channels: Vec<_> = of_machine(Machine::Excavator).collect();
    let _held: Vec<_> = channels
        .iter()
        .map(|c| ports.create(c).expect("a channel"))
        .collect();
    let mut ukf = ports
        .output::<ExcavatorEstimate>(&EXCAVATOR_INERTIA_UKF)
        .expect("a channel");
    let mut rls = ports
        .output::<ExcavatorEstimate>(&EXCAVATOR_INERTIA_RLS)
        .expect("a channel");
    let mut sensors = ports
        .output::<ExcavatorSensors>(&EXCAVATOR_SENSORS)
        .expect("a channel");
    let mut health = ports.output::<Health>(&HEALTH).expect("a channel");
    let limits = Limits {
        split_bytes: number(5).map(|n| n as u64),
        keep_bytes: number(6).map(|n| n as u64),
        ..Limits::default()
    };
    let mark = owner.domain().mark_file();
    let mut logger = Logger::create(&file, &Metadata::new(), limits, &mark).expect("a recording");
    // The file gets its name when it is complete, because a gateway may wait for it.
    let plan_file = owner.domain().plan_file();
    let part = plan_file.with_extension("part");
    std::fs::write(&part, plan.to_string()).expect("a plan");
    std::fs::rename(&part, &plan_file).expect("a plan");
    println!("ready");
    let begun = Instant::now();
    for i in 0..(rate * seconds) as u64 {
        let due = Duration::from_secs_f64(i as f64 / rate);
        std::thread::sleep(due.saturating_sub(begun.elapsed()));
        let estimate = estimate(i, rate);
        ukf.send(&estimate);
        logger.accept(&EXCAVATOR_INERTIA_UKF, &estimate);
        rls.send(&estimate);
        logger.accept(&EXCAVATOR_INERTIA_RLS, &estimate);
        let is_time = i as f64 >= WAIT * rate;
        if let Some((mut sample, _)) = is_time.then(|| rows.next()).flatten() {
            sample.stamp.measured_ns = now_ns();
            sensors.send(&sample);
            logger.accept(&EXCAVATOR_SENSORS, &sample);
        }
        if i % (rate * 0.3).max(1.0) as u64 == 0 {
            let mut message = Health {
                process: 3,
                state: 1,
                ..Health::default()
            };
            message.stamp.sequence = i / (rate * 0.3).max(1.0) as u64;
            message.stamp.time = message.stamp.sequence as f64 * 0.3;
            message.stamp.measured_ns = now_ns();
            health.send(&message);
            logger.accept(&HEALTH, &message);
        }
    }
    drop(logger);
    ExitCode::SUCCESS
}

/// An estimate that is trusted in every second half of 10 s, with a swing of 3 s in every 10 s.
fn estimate(i: u64, rate: f64) -> ExcavatorEstimate {
    let time = i as f64 / rate;
    let phase = time % 10.0;
    let moves = (2.0..5.0).contains(&phase);
    let mut estimate = ExcavatorEstimate {
        inertia: 5800.0 + 10.0 * (0.1 * time).sin(),
        inertia_std: 60.0,
        payload: 400.0 + time,
        payload_std: 25.0,
        velocity: if moves { 0.5 } else { 0.0 },
        estimated: x::INERTIA | x::PAYLOAD,
        flags: if phase >= 5.0 { x::TRUSTED } else { 0 },
        ..ExcavatorEstimate::default()
    };
    estimate.mark_simulated();
    estimate.stamp.sequence = i;
    estimate.stamp.time = time;
    estimate.stamp.measured_ns = now_ns();
    estimate
}
