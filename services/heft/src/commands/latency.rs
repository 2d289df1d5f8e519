//! `heft latency`: the latency of the real processes, next to the machine's own limits.
//!
//! The chain is sensor, kalman, rls, and a probe in the place of whoever uses the estimate: four
//! processes, three hops, with the real steps inside. Beside it, interleaved in the same run, the
//! same number of processes pass a message over bare futexes, pipes and a spinning cache line,
//! with no work in between. The last hop is measured twice: to a reader with a bell, and to one that
//! waits for the iceoryx2 event, as a program must that the supervisor did not start.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use hdrhistogram::Histogram;
use limits::{Kind, Options};
use runtime::{Arrival, Wake};
use serde_json::{Value, json};

use crate::cli::LatencyArgs;
use crate::failure::Failure;

/// Processes in a chain.
const STAGES: usize = 4;
/// Rounds per measurement: ours and the limits take turns, so that a noisy minute hits all.
const ROUNDS: usize = 3;
/// Samples at the start of each round that are left out: connections, caches, page faults.
const WARM_UP: usize = 20;

/// One set of conditions.
#[derive(Debug, Clone, Copy)]
struct Conditions {
    rate: f64,
    realtime: bool,
    loaded: bool,
}

/// Latencies under one set of conditions [ns].
struct Measured {
    conditions: Conditions,
    end_to_end: Histogram<u64>,
    hops: [Histogram<u64>; 3],
    /// The last hop, to a user that waits for the iceoryx2 event instead of a bell.
    by_event: Histogram<u64>,
    limits: Vec<(Kind, Histogram<u64>)>,
    lost: u64,
}

/// `heft latency`
pub fn latency(args: &LatencyArgs) -> Result<(), Failure> {
    let too_short = args.duration.is_nan() || args.duration <= 0.0;
    if too_short || args.rate.is_some_and(|r| !(10.0..=10_000.0).contains(&r)) {
        return Err(Failure::input(
            "the rate must be 10 to 10000 Hz and the duration positive",
            "--rate, --duration",
            "give other numbers",
        ));
    }
    let permitted = runtime::realtime::permitted();
    if !permitted {
        println!(
            "SCHED_FIFO is not permitted here (see `heft doctor`): measuring without it only\n"
        );
    }
    print_machine();
    let mut all = Vec::new();
    for conditions in conditions(args, permitted) {
        let _load = conditions.loaded.then(Load::start).transpose()?;
        let measured = measure(conditions, args.duration)?;
        print_measured(&measured);
        all.push(to_json(&measured));
    }
    if let Some(file) = &args.json {
        write_json(file, &all)?;
    }
    Ok(())
}

fn conditions(args: &LatencyArgs, permitted: bool) -> Vec<Conditions> {
    let rates = args
        .rate
        .map_or(vec![100.0, 1_000.0, 10_000.0], |rate| vec![rate]);
    let mut all = Vec::new();
    for loaded in [false, true] {
        for realtime in [true, false] {
            let wanted = if realtime {
                permitted
            } else {
                !args.rt || !permitted
            };
            if wanted && (!loaded || args.load) {
                all.extend(rates.iter().map(|&rate| Conditions {
                    rate,
                    realtime,
                    loaded,
                }));
            }
        }
    }
    all
}

/// Processes that occupy every core until dropped.
struct Load(Vec<std::process::Child>);

impl Load {
    fn start() -> Result<Self, Failure> {
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let spin = || {
            Command::new("sh")
                .args(["-c", "while :; do :; done"])
                .spawn()
        };
        (0..cores)
            .map(|_| spin())
            .collect::<Result<_, _>>()
            .map(Self)
            .map_err(Failure::internal)
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        for child in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Counts times from 1 ns to 100 s at three significant digits.
fn histogram() -> Result<Histogram<u64>, Failure> {
    Histogram::new_with_bounds(1, 100_000_000_000, 3).map_err(Failure::internal)
}

fn measure(conditions: Conditions, duration: f64) -> Result<Measured, Failure> {
    let mut result = Measured {
        conditions,
        end_to_end: histogram()?,
        hops: [histogram()?, histogram()?, histogram()?],
        by_event: histogram()?,
        limits: Kind::ALL
            .into_iter()
            .map(|kind| Ok((kind, histogram()?)))
            .collect::<Result<_, Failure>>()?,
        lost: 0,
    };
    let seconds = duration / ROUNDS as f64;
    for round in 0..ROUNDS {
        let text = run_pipeline(conditions, seconds, round, Wake::Bell)?;
        add_arrivals(&mut result, &text);
        let text = run_pipeline(conditions, seconds, round, Wake::Event)?;
        for arrival in arrivals(&text).skip(WARM_UP) {
            result.by_event.saturating_record(spans(&arrival)[2]);
        }
        for (kind, histogram) in &mut result.limits {
            add_limit(*kind, conditions, seconds, histogram)?;
        }
    }
    Ok(result)
}

/// One round of the real pipeline, as a run of its own; returns what the probe noted.
fn run_pipeline(
    conditions: Conditions,
    seconds: f64,
    round: usize,
    wake: Wake,
) -> Result<String, Failure> {
    let folder = std::env::temp_dir().join(format!("heft-latency-{}-{round}", std::process::id()));
    let probe = folder.join("probe.csv");
    let exe = std::env::current_exe().map_err(Failure::internal)?;
    fs::create_dir_all(&folder).map_err(|e| Failure::file("make the folder", &folder, &e))?;
    let mut command = Command::new(exe);
    command
        .args([
            "run",
            "excavator",
            "--scenario",
            "cycle",
            "--quiet",
            "--no-report",
        ])
        .args(["--rate", &conditions.rate.to_string()])
        .args(["--duration", &seconds.to_string()])
        .args(["--seed", &(round + 1).to_string()])
        .arg("--probe")
        .arg(&probe)
        .arg("--out")
        .arg(&folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null());
    if conditions.realtime {
        command.arg("--rt");
    }
    if wake == Wake::Event {
        command.arg("--probe-listens");
    }
    let status = command.status().map_err(Failure::internal)?;
    let text = fs::read_to_string(&probe);
    let _ = fs::remove_dir_all(&folder);
    text.map_err(|_| Failure::answer_is_no(format!("the pipeline failed ({status})")))
}

/// The lines that a probe wrote.
fn arrivals(text: &str) -> impl Iterator<Item = Arrival> {
    text.lines().skip(1).filter_map(|line| {
        let mut cells = line.split(',').map_while(|cell| cell.parse().ok());
        Some(Arrival {
            sequence: cells.next()?,
            sensor_ns: cells.next()?,
            filter_ns: cells.next()?,
            estimate_ns: cells.next()?,
            received_ns: cells.next()?,
        })
    })
}

/// Times of the three hops [ns].
fn spans(arrival: &Arrival) -> [u64; 3] {
    [
        arrival.filter_ns.saturating_sub(arrival.sensor_ns),
        arrival.estimate_ns.saturating_sub(arrival.filter_ns),
        arrival.received_ns.saturating_sub(arrival.estimate_ns),
    ]
}

fn add_arrivals(result: &mut Measured, text: &str) {
    let mut expected = 0;
    for arrival in arrivals(text) {
        result.lost += arrival.sequence.saturating_sub(expected);
        expected = arrival.sequence + 1;
        if arrival.sequence < WARM_UP as u64 {
            continue;
        }
        result.end_to_end.saturating_record(arrival.received_ns);
        for (histogram, span) in result.hops.iter_mut().zip(spans(&arrival)) {
            histogram.saturating_record(span);
        }
    }
}

/// One round of a bare chain.
fn add_limit(
    kind: Kind,
    conditions: Conditions,
    seconds: f64,
    histogram: &mut Histogram<u64>,
) -> Result<(), Failure> {
    // A chain of spinners needs a core each; two processes show the cache line itself.
    let (stages, fifo) = if kind == Kind::Spin {
        (2, false)
    } else {
        (STAGES, conditions.realtime)
    };
    let last = std::thread::available_parallelism().map_or(0, |n| n.get() - 1);
    let options = Options {
        stages,
        rate_hz: conditions.rate,
        samples: ((seconds * conditions.rate) as usize).max(50),
        fifo,
        cores: fifo.then(|| vec![last]),
        ..Options::default()
    };
    let outcome = limits::chain(kind, &options).map_err(|e| {
        Failure::input(
            format!("the bare chain failed: {e}"),
            kind.name(),
            "run `heft doctor`",
        )
    })?;
    for &ns in outcome.latencies_ns.iter().skip(WARM_UP) {
        histogram.saturating_record(ns.max(1));
    }
    Ok(())
}

const QUANTILES: [(&str, f64); 3] = [("p50", 0.5), ("p99", 0.99), ("p999", 0.999)];

fn us(histogram: &Histogram<u64>, quantile: f64) -> f64 {
    histogram.value_at_quantile(quantile) as f64 / 1e3
}

fn max_us(histogram: &Histogram<u64>) -> f64 {
    histogram.max() as f64 / 1e3
}

fn limit(measured: &Measured, kind: Kind) -> Option<&Histogram<u64>> {
    measured
        .limits
        .iter()
        .find(|(k, h)| *k == kind && !h.is_empty())
        .map(|(_, h)| h)
}

fn ratio(measured: &Measured, quantile: f64) -> Option<f64> {
    let futex = us(limit(measured, Kind::Futex)?, quantile);
    (futex > 0.0).then(|| us(&measured.end_to_end, quantile) / futex)
}

fn print_machine() {
    let system = rustix::system::uname();
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    println!(
        "{} cores, {} {}; µs from measurement to arrival, {STAGES} processes, {ROUNDS} rounds in turn",
        cores,
        system.sysname().to_string_lossy(),
        system.release().to_string_lossy()
    );
}

fn print_measured(m: &Measured) {
    let Conditions {
        rate,
        realtime,
        loaded,
    } = m.conditions;
    println!(
        "\n{rate} Hz, {}, {}",
        if realtime {
            "SCHED_FIFO on one core"
        } else {
            "normal scheduling, free placement"
        },
        if loaded {
            "every core occupied by a spinner"
        } else {
            "idle"
        }
    );
    println!(
        "{:<30}{:>9}{:>9}{:>9}{:>9}{:>9}",
        "", "p50", "p99", "p99.9", "max", "samples"
    );
    let row = |name: &str, h: &Histogram<u64>| {
        println!(
            "{name:<30}{:>9.1}{:>9.1}{:>9.1}{:>9.1}{:>9}",
            us(h, 0.5),
            us(h, 0.99),
            us(h, 0.999),
            max_us(h),
            h.len()
        );
    };
    row("heft, sensor to user", &m.end_to_end);
    for (name, h) in ["  sensor to kalman", "  kalman to rls", "  rls to user"]
        .iter()
        .zip(&m.hops)
    {
        row(name, h);
    }
    row("  rls to user, iceoryx2 event", &m.by_event);
    for (kind, h) in m.limits.iter().filter(|(_, h)| !h.is_empty()) {
        let name = if *kind == Kind::Spin {
            "bare cache line, 1 hop"
        } else {
            &format!("bare {} chain", kind.name())
        };
        row(name, h);
    }
    if let (Some(p50), Some(p999)) = (ratio(m, 0.5), ratio(m, 0.999)) {
        println!(
            "heft over bare futex: p50 {p50:.2} x, p99.9 {p999:.2} x; lost {}",
            m.lost
        );
    }
}

fn percentiles(h: &Histogram<u64>) -> Value {
    let mut object = serde_json::Map::new();
    for (name, quantile) in QUANTILES {
        object.insert(name.into(), json!(us(h, quantile)));
    }
    object.insert("max".into(), json!(max_us(h)));
    Value::Object(object)
}

fn to_json(m: &Measured) -> Value {
    let limits: serde_json::Map<String, Value> = m
        .limits
        .iter()
        .filter(|(_, h)| !h.is_empty())
        .map(|(kind, h)| (kind.name().to_owned(), percentiles(h)))
        .collect();
    let futex = limit(m, Kind::Futex).map(percentiles);
    let bins: Vec<Value> = m
        .end_to_end
        .iter_log(1_000, 1.25)
        .filter(|bin| bin.count_since_last_iteration() > 0)
        .map(|bin| {
            json!([
                bin.value_iterated_to() as f64 / 1e3,
                bin.count_since_last_iteration()
            ])
        })
        .collect();
    json!({
        "rate": m.conditions.rate,
        "rt": m.conditions.realtime,
        "load": m.conditions.loaded,
        "e2e_us": percentiles(&m.end_to_end),
        "last_hop_by_event_us": percentiles(&m.by_event),
        "hops_us": m.hops.iter().map(percentiles).collect::<Vec<_>>(),
        "limit_us": futex,
        "limits_us": limits,
        "ratio_p50": ratio(m, 0.5),
        "ratio_p999": ratio(m, 0.999),
        "lost": m.lost,
        "samples": m.end_to_end.len(),
        "histogram_us": bins,
    })
}

/// The first measurement at the top, all of them below it.
fn write_json(file: &Path, all: &[Value]) -> Result<(), Failure> {
    let mut top = all.first().cloned().unwrap_or_else(|| json!({}));
    if let Some(object) = top.as_object_mut() {
        object.insert("runs".into(), json!(all));
    }
    let text = serde_json::to_string_pretty(&top).map_err(Failure::internal)?;
    fs::write(file, text + "\n").map_err(|e| Failure::file("write", file, &e))
}
