//! heft-gateway: sends the results of a machine's pipeline to a fleet. `heft run ... --fleet` starts it.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use gateway::machine::{GatewayArgs, run};

/// Sends what a machine's pipeline finds to a fleet.
///
/// `heft run ... --fleet tcp/HOST:7447 --site S --machine-id M` starts it beside the pipeline.
#[derive(Parser)]
#[command(name = "heft-gateway", version = gateway::VERSION)]
struct Cli {
    #[command(flatten)]
    args: GatewayArgs,
}

fn main() -> ExitCode {
    let _process = gateway::log("heft-gateway");
    let stop = Arc::new(AtomicBool::new(false));
    let gave_up = Arc::new(AtomicBool::new(false));
    let result = gateway::on_signal(&stop)
        .and_then(|()| gateway::on_hang_up(&gave_up))
        .map_err(gateway::Failure::passing)
        .and_then(|()| run(&Cli::parse().args, &stop, &gave_up));
    gateway::exit("heft-gateway", result)
}
