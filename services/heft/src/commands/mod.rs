//! The command line. Every command has a file with its arguments and code, and a row here with its help.

use clap::{Parser, Subcommand};

use crate::failure::Failure;

pub mod calibrate;
pub mod check;
pub mod completions;
pub mod demo;
pub mod doctor;
pub mod estimate;
pub mod evaluate;
pub mod export;
pub mod latency;
pub mod loads;
pub mod map;
pub mod package;
pub mod recover;
pub mod replay;
pub mod report;
pub mod run;
pub mod schema;
pub mod serve;
pub mod tail;
pub mod top;
pub mod weigh;

/// Weighs every bucket of an excavator or wheel loader, and estimates swing inertia and centre of gravity, while it works.
///
/// Each number has a 95 % interval and a verdict: trusted, or not and why. Without a command: the
/// demonstration. Both machines are simulated in real time for 28 s, and every load is printed beside the truth.
#[derive(Debug, Parser)]
#[command(name = "heft", version = crate::build::IDENTITY, max_term_width = 100)]
#[command(
    after_help = "Exit status: 0 done, 1 ran but the answer is no, 2 wrong use or bad input; 141 the reader of standard output left.\n\n\
        Environment:\n  \
        HEFT_LOG         what is logged to standard error, such as info or heft=debug (else RUST_LOG; else warnings)\n  \
        HEFT_LOG_FORMAT  text or json: a line each, with time, level, source, fields and process\n  \
        XDG_RUNTIME_DIR  a folder of this user in memory, for what a run shares (else /dev/shm)"
)]
pub struct Cli {
    /// What to do; the demonstration if absent.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The demonstration: process statistics too
    #[arg(long)]
    pub verbose: bool,
}

macro_rules! commands {
    ($( $(#[$help:meta])+ $name:ident($args:ty) => $run:path; )+) => {
        /// Commands.
        #[derive(Debug, Subcommand)]
        pub enum Command {
            $( $(#[$help])+ $name(Box<$args>), )+
        }

        impl Command {
            /// Runs it.
            pub fn run(&self) -> Result<(), Failure> {
                match self {
                    $( Self::$name(args) => $run(args), )+
                }
            }
        }
    };
}

commands! {
    /// Write a first signal map for a table or a CAN log, each line with its reason
    Map(map::MapArgs) => map::map;
    /// Estimate from recorded data: a table (CSV), a CAN log or a recording
    Estimate(estimate::EstimateArgs) => estimate::estimate;
    /// Count loads, trucks and days in recordings: kilograms with intervals, one row a load
    Loads(loads::LoadsArgs) => loads::loads;
    /// Validate a machine file, or print one with every key
    Check(check::CheckArgs) => check::check;
    /// Find the machine's own parameters from recordings, with intervals
    Calibrate(calibrate::CalibrateArgs) => calibrate::calibrate;
    /// Centre of gravity of a loader from its axle weights on level and tilted ground
    Weigh(weigh::WeighArgs) => weigh::weigh;
    /// Estimate live, as separate processes: from a CAN bus, the simulator or recorded data
    Run(run::RunArgs) => run::run;
    /// Dashboard of a run in the terminal
    Top(top::TopArgs) => top::top;
    /// Follow a channel of a run, a line per sample
    Tail(tail::TailArgs) => tail::tail;
    /// Make one HTML page of a recording, which needs no network
    Report(report::ReportArgs) => report::report;
    /// Write every channel of a recording as CSV
    Export(export::ExportArgs) => export::export;
    /// Compute every estimate of a recording again, and compare
    Replay(replay::ReplayArgs) => replay::replay;
    /// Write a whole copy of a recording that was cut off, damaged or left in parts
    Recover(recover::RecoverArgs) => recover::recover;
    /// Estimate for many machines at once: a table with a column `machine` in, estimates out
    Serve(serve::ServeArgs) => serve::serve;
    /// Keep and show what many machines send (needs heft-fleet)
    #[command(disable_help_flag = true)]
    Fleet(crate::fleet::PassedArgs) => crate::fleet::fleet;
    /// Say what this computer lacks for real-time work, and what killed runs left behind
    Doctor(doctor::DoctorArgs) => doctor::doctor;
    /// Measure the latency of the real processes next to the limits of this computer
    Latency(latency::LatencyArgs) => latency::latency;
    /// Evaluate the estimators by Monte-Carlo simulation, next to the published figures
    Evaluate(evaluate::EvaluateArgs) => evaluate::evaluate;
    /// Print the messages as types of another language
    Schema(schema::SchemaArgs) => schema::schema;
    /// Print a completion script for a shell
    Completions(completions::CompletionsArgs) => completions::completions;
    /// Write manual pages and completion scripts into a folder (for packages)
    #[command(hide = true)]
    Package(package::PackageArgs) => package::package;
    /// Be one service of a pipeline (started by the supervisor)
    #[command(hide = true)]
    Service(crate::service::ServiceArgs) => crate::service::serve;
    /// Be one link of a bare chain (started by `heft latency`)
    #[command(hide = true, name = "limits-worker")]
    LimitsWorker(latency::worker::WorkerArgs) => latency::worker::worker;
}
