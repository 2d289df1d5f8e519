//! Lower bounds of the latency on a computer: chains of processes that only pass a sample on.
//!
//! A latency depends on the computer as much as on the program. So `heft latency` also runs the shortest chain of each mechanism of
//! the kernel, in the same minute and under the same scheduling. Its own figures are ratios to these.
//!
//! ```text
//!  process 0          process 1                process P-1
//!  paces, stamps ──▶  waits, stamps, works ──▶ waits, stamps, records
//!            (a futex word, a pipe, or a spinning cache line per hop)
//! ```
//!
//! | [`Primitive`] | a hop is | what it is the limit of |
//! |---|---|---|
//! | `Futex` | a ring in shared memory and a futex word | every blocking wake between processes |
//! | `Pipe` | one `write`, one blocking `read` | what needs no shared memory |
//! | `Spin` | the same ring, the reader spinning on its word | the hardware: one cache line changing cores |
//!
//! The processes are the current program started again with the hidden first argument [`SUBCOMMAND`]; the program passes what follows it
//! to [`worker_main`]. Workers are killed by the kernel when the process that started them ends.
//!
//! A latency starts when the first process stamps the sample, just before it sends it, and not when the sample was due: a late timer
//! is the pacing's, not the chain's. Time is `CLOCK_MONOTONIC`.

mod assignment;
mod link;
mod schedule;
mod shared;
mod spawn;
mod worker;

use std::io;
use std::time::Duration;

pub use worker::worker_main;

/// The hidden first argument that makes a program a stage of a chain: `heft limits-worker ...`.
pub const SUBCOMMAND: &str = "limits-worker";

/// Samples sent ahead of the measured ones, to fill caches, page tables and branch predictors.
pub const WARM_UP: usize = 64;

/// Mechanism that passes a sample from one process to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Primitive {
    /// A ring in shared memory; the reader sleeps on a futex word.
    Futex,
    /// A pipe; the reader sleeps in `read`.
    Pipe,
    /// A ring in shared memory; the reader spins on the word, on a core of its own.
    Spin,
}

impl Primitive {
    /// Every kind, in the order they are reported.
    pub const ALL: [Primitive; 3] = [Primitive::Futex, Primitive::Pipe, Primitive::Spin];

    /// The name used in tables, JSON and between the processes.
    pub fn name(self) -> &'static str {
        match self {
            Primitive::Futex => "futex",
            Primitive::Pipe => "pipe",
            Primitive::Spin => "spin",
        }
    }

    fn from_name(name: &str) -> Option<Primitive> {
        Primitive::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// A chain to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Processes in the chain, at least 2; hops are one fewer. `Spin` runs with as many as there are cores, see [`Outcome::stages`].
    pub stages: usize,
    /// Samples a second \[Hz\].
    pub rate_hz: f64,
    /// Samples that are measured, after [`WARM_UP`] others.
    pub samples: usize,
    /// Ask for SCHED_FIFO with priorities rising downstream (as `heft run --rt` does). `Spin` ignores it: a spinning real-time process
    /// would lock its core.
    pub fifo: bool,
    /// Cores for the stages, taken in turn: one entry pins all to that core, several spread them. `None` leaves it to the scheduler.
    pub cores: Option<Vec<usize>>,
    /// Size of a sample \[bytes\], rounded up to 8 and to the size of the time stamps. At most 4096, which a pipe writes at once.
    pub payload: usize,
    /// Busy work of every stage but the first, between the stamp of arrival and the sending on.
    pub work: Duration,
}

impl Default for Options {
    /// Four processes, 1 kHz, 4000 samples of 200 bytes, ordinary scheduling, no work.
    fn default() -> Self {
        Self {
            stages: 4,
            rate_hz: 1000.0,
            samples: 4000,
            fifo: false,
            cores: None,
            payload: 200,
            work: Duration::ZERO,
        }
    }
}

/// Measurements of a chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// First stamp to last stamp \[ns\], in the order sent, of the samples that arrived.
    pub latencies_ns: Vec<u64>,
    /// The same for each hop \[ns\]: `per_hop[i]` is from the stamp of process i to that of process i + 1, so it includes the work of i.
    pub per_hop: Vec<Vec<u64>>,
    /// Measured samples that did not arrive, or not in order.
    pub lost: u64,
    /// Whether every process ran under SCHED_FIFO. `false` if it was not requested or is not permitted.
    pub fifo: bool,
    /// Number of processes. Less than requested only for [`Primitive::Spin`], which needs a core for each: then compare hop by hop.
    pub stages: usize,
}

/// Runs a chain of processes and returns when its last sample has arrived.
///
/// # Errors
/// `InvalidInput` for options that make no chain, `TimedOut` if the chain stopped. Otherwise the error of the system for a process
/// or its memory.
pub fn chain(kind: Primitive, options: &Options) -> io::Result<Outcome> {
    let options = checked(kind, options)?;
    let shared =
        shared::Shared::create(options.stages, options.samples + WARM_UP, options.payload)?;
    spawn::run(kind, &options, &shared)?;
    Ok(collect(&shared, options.stages, options.samples))
}

fn checked(kind: Primitive, options: &Options) -> io::Result<Options> {
    let mut options = options.clone();
    let wrong = |what: &str| {
        Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            what.to_string(),
        ))
    };
    if !(2..=16).contains(&options.stages) {
        return wrong("a chain has 2 to 16 stages");
    }
    if !(options.rate_hz >= 0.1 && options.rate_hz <= 1e6) {
        return wrong("the rate lies between 0.1 Hz and 1 MHz");
    }
    if options.samples == 0 || options.samples > 100_000_000 {
        return wrong("a chain measures 1 to 100 million samples");
    }
    if options.payload > 4096 {
        return wrong("a payload has at most 4096 bytes");
    }
    if options.cores.as_ref().is_some_and(Vec::is_empty) {
        return wrong("the list of cores is empty");
    }
    options.payload = options
        .payload
        .max(8 * (1 + options.stages))
        .next_multiple_of(8);
    if kind == Primitive::Spin {
        let cores = schedule::permitted_cores()?;
        options.stages = options.stages.min(cores.len()).max(2);
        options.cores = Some(cores);
        options.fifo = false;
    }
    Ok(options)
}

fn collect(shared: &shared::Shared, stages: usize, samples: usize) -> Outcome {
    let mut outcome = Outcome {
        latencies_ns: Vec::with_capacity(samples),
        per_hop: vec![Vec::with_capacity(samples); stages - 1],
        lost: 0,
        fifo: shared.all_fifo(),
        stages,
    };
    for index in WARM_UP..WARM_UP + samples {
        let stamps = shared.result(index);
        if stamps.contains(&0) {
            outcome.lost += 1;
            continue;
        }
        outcome
            .latencies_ns
            .push(stamps[stages - 1].saturating_sub(stamps[0]));
        for (hop, pair) in stamps.windows(2).enumerate() {
            outcome.per_hop[hop].push(pair[1].saturating_sub(pair[0]));
        }
    }
    outcome
}
