//! Measures the real chain and the bare chains in turn.

use std::fs;
use std::os::unix::fs::DirBuilderExt;
use std::process::Stdio;

use hdrhistogram::Histogram;
use limits::{Options, Primitive};
use runtime::{Arrival, Wake};

use super::ROUNDS;
use super::chain::Chain;
use super::conditions::Conditions;
use crate::failure::Failure;
use crate::image;
use crate::machines;

/// Samples at the start of each round that are left out: connections, caches, page faults.
const WARM_UP: usize = 20;

/// Latencies of the real chain \[ns\].
pub struct Passage {
    /// From measurement to arrival.
    pub end_to_end: Histogram<u64>,
    /// Of each hop.
    pub hops: Vec<Histogram<u64>>,
    /// Samples that did not arrive.
    pub lost: u64,
}

/// Latencies under one set of conditions \[ns\].
pub struct Measured {
    /// The conditions.
    pub conditions: Conditions,
    /// The chain of processes.
    pub chain: Chain,
    /// The real chain under the conditions.
    pub ours: Passage,
    /// The real chain woken by bells, if processes spin under these conditions.
    pub by_bell: Passage,
    /// The last hop, to a user that waits for the iceoryx2 event instead of a bell.
    pub by_event: Histogram<u64>,
    /// The bare chains.
    pub limits: Vec<(Primitive, Histogram<u64>)>,
}

impl Passage {
    fn new(chain: &Chain) -> Result<Self, Failure> {
        let hops = chain.hops().into_iter().map(|_| histogram());
        Ok(Self {
            end_to_end: histogram()?,
            hops: hops.collect::<Result<_, _>>()?,
            lost: 0,
        })
    }

    /// Adds the notes of a probe for a round of this many samples.
    fn add(&mut self, chain: &Chain, text: &str, samples: u64) {
        let mut expected = 0;
        for arrival in arrivals(text) {
            self.lost += arrival.sequence.saturating_sub(expected);
            expected = arrival.sequence + 1;
            if arrival.sequence < WARM_UP as u64 {
                continue;
            }
            self.end_to_end.saturating_record(arrival.received_ns);
            for (histogram, span) in self.hops.iter_mut().zip(chain.spans(&arrival)) {
                histogram.saturating_record(span);
            }
        }
        self.lost += samples.saturating_sub(expected);
    }
}

impl Measured {
    /// Nothing yet.
    pub fn new(chain: &Chain, conditions: &Conditions) -> Result<Self, Failure> {
        Ok(Self {
            conditions: conditions.clone(),
            chain: chain.clone(),
            ours: Passage::new(chain)?,
            by_bell: Passage::new(chain)?,
            by_event: histogram()?,
            limits: Primitive::ALL
                .into_iter()
                .map(|kind| Ok((kind, histogram()?)))
                .collect::<Result<_, Failure>>()?,
        })
    }

    /// Latencies of a bare chain, if it was measured.
    pub fn limit(&self, kind: Primitive) -> Option<&Histogram<u64>> {
        self.limits
            .iter()
            .find(|(k, h)| *k == kind && !h.is_empty())
            .map(|(_, h)| h)
    }

    /// Ratio of the real chain to the chain of bare futexes.
    pub fn ratio(&self, quantile: f64) -> Option<f64> {
        let futex = us(self.limit(Primitive::Futex)?, quantile);
        (futex > 0.0).then(|| us(&self.ours.end_to_end, quantile) / futex)
    }
}

/// A quantile \[µs\].
pub fn us(histogram: &Histogram<u64>, quantile: f64) -> f64 {
    histogram.value_at_quantile(quantile) as f64 / 1e3
}

/// The largest value \[µs\].
pub fn max_us(histogram: &Histogram<u64>) -> f64 {
    histogram.max() as f64 / 1e3
}

/// Counts times from 1 ns to 100 s at three significant digits.
fn histogram() -> Result<Histogram<u64>, Failure> {
    Histogram::new_with_bounds(1, 100_000_000_000, 3).map_err(Failure::internal)
}

/// Time that [`measure`] takes, without the starts of the processes \[s\].
pub fn expected(duration: f64, spins: bool) -> f64 {
    let chains = 2 + usize::from(spins) + Primitive::ALL.len();
    duration * chains as f64
}

/// Measures under some conditions for `duration` \[s\].
pub fn measure(chain: &Chain, conditions: &Conditions, duration: f64) -> Result<Measured, Failure> {
    let mut result = Measured::new(chain, conditions)?;
    let seconds = duration / ROUNDS as f64;
    let samples = (seconds * conditions.rate) as u64;
    let by_bells = Conditions {
        spin: None,
        ..conditions.clone()
    };
    for round in 0..ROUNDS {
        let text = run_pipeline(chain, conditions, seconds, round, Wake::Bell)?;
        result.ours.add(chain, &text, samples);
        if conditions.spin.is_some() {
            let text = run_pipeline(chain, &by_bells, seconds, round, Wake::Bell)?;
            result.by_bell.add(chain, &text, samples);
        }
        let text = run_pipeline(chain, &by_bells, seconds, round, Wake::Event)?;
        for arrival in arrivals(&text).skip(WARM_UP) {
            let last = chain.spans(&arrival).pop();
            result.by_event.saturating_record(last.unwrap_or(0));
        }
        for (kind, histogram) in &mut result.limits {
            add_limit(*kind, chain, conditions, seconds, histogram)?;
        }
    }
    Ok(result)
}

/// One round of the real pipeline, as a run of its own; returns what the probe noted.
fn run_pipeline(
    chain: &Chain,
    conditions: &Conditions,
    seconds: f64,
    round: usize,
    wake: Wake,
) -> Result<String, Failure> {
    let folder = std::env::temp_dir().join(format!("heft-latency-{}-{round}", std::process::id()));
    let probe = folder.join("probe.csv");
    // Must be a new folder: another user may have put a link under this name.
    let made = fs::DirBuilder::new().mode(0o700).create(&folder);
    made.map_err(|e| Failure::folder(&folder, &e))?;
    let mut command = image::command();
    command
        .args(["run", chain.machine.name(), "--quiet", "--no-report"])
        .args(["--scenario", machines::entry(chain.machine).shown_scenario])
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
        let cores: Vec<String> = conditions.pinned.iter().map(usize::to_string).collect();
        command.args(["--rt", "--spread", &cores.join(",")]);
    }
    if let Some(spinning) = &conditions.spin {
        command.arg(format!("--spin={spinning}"));
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

/// One round of a bare chain.
fn add_limit(
    kind: Primitive,
    chain: &Chain,
    conditions: &Conditions,
    seconds: f64,
    histogram: &mut Histogram<u64>,
) -> Result<(), Failure> {
    // A chain of spinning processes needs a core each; two processes show the cache line itself.
    let (stages, fifo) = if kind == Primitive::Spin {
        (2, false)
    } else {
        (chain.processes(), conditions.realtime)
    };
    let options = Options {
        stages,
        rate_hz: conditions.rate,
        samples: ((seconds * conditions.rate) as usize).max(50),
        fifo,
        cores: fifo.then(|| conditions.pinned.clone()),
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
