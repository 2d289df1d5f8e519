//! `heft latency`: the latency of the real processes, next to the machine's own limits.
//!
//! The chain leads from the sensor to a probe in the place of a user of the estimate (excavator: sensor, kalman,
//! rls, probe, three hops), with the real steps inside. Interleaved in the same run, the
//! same number of processes pass a message over bare futexes, pipes and a spinning cache line,
//! without work in between. The last hop is measured twice: to a reader with a bell, and to one that
//! waits for the iceoryx2 event, as a program must that the supervisor did not start. With `--spin` the chain is
//! measured twice, in turn: with processes that spin, and by bells.

mod chain;
mod conditions;
mod json;
mod measure;
mod print;
pub mod worker;

use std::path::PathBuf;

use clap::Args;
use messages::Machine;

use crate::args::machine;
use crate::failure::Failure;
use crate::spin;
use chain::Chain;
use conditions::{Load, conditions};
use measure::measure;
use steps::stages::Pipeline;

/// Rounds per measurement: the real chain and the bare chains take turns, so that a disturbance of the host affects all.
const ROUNDS: usize = 3;

/// `heft latency`
#[derive(Debug, Args)]
pub struct LatencyArgs {
    /// The machine whose processes are measured
    #[arg(value_parser = machine(), default_value = Machine::Excavator.name())]
    pub machine: Machine,
    /// One sampling rate, in Hz; 100, 1000 and 10000 if absent
    #[arg(long, value_name = "HZ")]
    pub rate: Option<f64>,
    /// Length of a measurement, such as 5 (s) or 1m
    #[arg(long, value_name = "TIME", default_value_t = 5.0, value_parser = view::duration::positive, allow_negative_numbers = true)]
    pub duration: f64,
    /// Real-time scheduling only; with and without if absent
    #[arg(long)]
    pub rt: bool,
    /// Spread the processes over the last N cores, in turn along the chain (bare chains alike);
    /// with --rt only, because nothing is pinned without
    #[arg(long, value_name = "N", default_value_t = 1, requires = "rt")]
    pub cores: usize,
    /// These processes spin instead of sleeping, as with `heft run --spin`, in turn with the same by bells
    #[arg(long, value_name = "PROCESS,...", num_args = 0..=1, require_equals = true, default_missing_value = crate::spin::ALL,
        conflicts_with_all = ["rt", "load"])]
    pub spin: Option<String>,
    /// Also under a load that occupies every core
    #[arg(long)]
    pub load: bool,
    /// Write the numbers as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// `heft latency`
pub fn latency(args: &LatencyArgs) -> Result<(), Failure> {
    if args.rate.is_some_and(|r| !(10.0..=10_000.0).contains(&r)) {
        return Err(Failure::input(
            "the rate must be 10 to 10000 Hz",
            "--rate",
            "give other numbers",
        ));
    }
    let permitted = runtime::realtime::permitted();
    if !permitted {
        println!(
            "SCHED_FIFO is not permitted here (see `heft doctor`): measuring without it only, nothing pinned\n"
        );
    }
    let chain = Chain::of(args.machine);
    if let Some(wanted) = &args.spin {
        // An impossible choice is reported once, here.
        spin::spinners(Pipeline::of(args.machine), wanted, true)?;
    }
    let conditions = conditions(args, permitted, chain.processes())?;
    print::machine(&chain);
    let mut all = Vec::new();
    let runs = conditions.len();
    eprintln!(
        "{runs} measurements of some {:.0} s each",
        measure::expected(args.duration, args.spin.is_some())
    );
    for (done, conditions) in conditions.into_iter().enumerate() {
        eprintln!(
            "measurement {} of {runs}: {:.0} Hz, {} scheduling",
            done + 1,
            conditions.rate,
            if conditions.realtime {
                "real-time"
            } else {
                "normal"
            }
        );
        let _load = conditions.loaded.then(Load::start).transpose()?;
        let measured = measure(&chain, &conditions, args.duration)?;
        print::measured(&measured);
        all.push(json::record(&measured));
    }
    if let Some(file) = &args.json {
        json::write(file, &all)?;
    }
    Ok(())
}
