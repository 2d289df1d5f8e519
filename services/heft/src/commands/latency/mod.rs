//! `heft latency`: the latency of the real processes, next to the machine's own limits.
//!
//! The chain leads from the sensor to a probe in the place of whoever uses the estimate (excavator: sensor, kalman,
//! rls, probe, three hops), with the real steps inside. Beside it, interleaved in the same run, the
//! same number of processes pass a message over bare futexes, pipes and a spinning cache line,
//! with no work in between. The last hop is measured twice: to a reader with a bell, and to one that
//! waits for the iceoryx2 event, as a program must that the supervisor did not start. With `--spin` the chain is
//! measured twice, in turn: with processes that spin, and by bells.

mod chain;
mod conditions;
mod json;
mod measure;
mod print;

use crate::cli::LatencyArgs;
use crate::failure::Failure;
use crate::spin;
use chain::Chain;
use conditions::{Load, conditions};
use measure::measure;
use steps::stages::Pipeline;

/// Rounds per measurement: ours and the limits take turns, so that a noisy minute hits all.
const ROUNDS: usize = 3;

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
            "SCHED_FIFO is not permitted here (see `heft doctor`): measuring without it only, nothing pinned\n"
        );
    }
    let chain = Chain::of(args.machine);
    if let Some(wanted) = &args.spin {
        // What cannot work is said once, here.
        spin::spinners(Pipeline::of(args.machine), wanted, true)?;
    }
    let conditions = conditions(args, permitted, chain.processes())?;
    print::machine(&chain);
    let mut all = Vec::new();
    for conditions in conditions {
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
