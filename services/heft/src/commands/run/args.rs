//! What `heft run` is given.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use messages::Machine;

use crate::args::{DescriptionArgs, kilograms, machine};
use crate::bounds::LimitArgs;
use crate::fleet::FleetArgs;
use crate::serve::MOST_MACHINES;

/// How fast a run goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Pace {
    /// At the times of the samples.
    Realtime,
    /// As fast as the processes take it, without losing a sample.
    Max,
}

/// What a simulated machine has, unless it is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Equipment {
    /// Pressure sensors at the cylinders, and what belongs to them.
    Pressure,
}

/// Address of the live page.
fn page(text: &str) -> Result<SocketAddr, String> {
    view::live::address(text, view::live::DEFAULT_ADDRESS)
}

/// `heft run`
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  heft run excavator --scenario cycle --view                          # simulated, with a live page
  heft run loader --input can:can0 --map map.toml --config loader.toml --view")]
pub struct RunArgs {
    /// The machine
    #[arg(value_parser = machine())]
    pub machine: Machine,
    /// Scenario of the simulator; `--scenario list` names them
    #[arg(long)]
    pub scenario: Option<String>,
    /// Payload of the simulator, in kg
    #[arg(long, value_name = "KG", value_parser = kilograms, allow_negative_numbers = true)]
    pub payload: Option<f64>,
    /// Leave out a kind of sensors that simulated machines have
    #[arg(long, value_enum, value_name = "KIND", conflicts_with = "input")]
    pub without: Vec<Equipment>,
    /// Take the samples from a recording (.csv, .mcap, .log), a CAN bus (can:can0) or standard input
    /// (-: lines of candump or CSV) instead of the simulator
    #[arg(long, value_name = "FILE|can:IF|-", conflicts_with_all = ["scenario", "payload"])]
    pub input: Option<PathBuf>,
    /// Signal map of an input with foreign names and units (TOML)
    #[arg(long, requires = "input")]
    pub map: Option<PathBuf>,
    /// Send the estimates to a CAN bus, as `heft schema --lang dbc` describes them
    #[arg(long, value_name = "can:IF")]
    pub output: Option<String>,
    /// Which estimates, in which frames (TOML); all of the machine's in J1939 proprietary B if absent
    #[arg(long, requires = "output", value_name = "FILE")]
    pub output_map: Option<PathBuf>,
    /// Number of machines in one run, simulated (seeds one apart) or from the recordings in the folder --input. One process per
    /// processor steps them all; the estimates are one table
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_MACHINES as i64), conflicts_with_all = [
        "output", "rt", "spin", "view", "split", "min_free", "fleet", "state", "domain", "group", "require_trust", "no_report",
        "live_lines", "probe", "threads",
    ])]
    pub machines: Option<u32>,
    /// What a truck shall hold, such as 24t or 24000 (kg): loads are counted, reported as they come, and shown at `/loads` of the live page
    #[arg(long, value_name = "MASS", value_parser = crate::target::parsed)]
    pub target: Option<f64>,
    /// What is known of the machine
    #[command(flatten)]
    pub description: DescriptionArgs,
    /// Method of the main estimate; the usual one if absent (`heft estimate --help` lists them)
    #[arg(long)]
    pub method: Option<String>,
    /// Length of the run, such as 90 (s), 5m or 2h; until the scenario ends if absent
    #[arg(long, value_name = "TIME", value_parser = view::duration::positive, allow_negative_numbers = true)]
    pub duration: Option<f64>,
    /// Sampling rate of the simulator, in Hz; that of the machine file if absent
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub rate: Option<f64>,
    /// Seed of the simulator
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Real time, or as fast as it goes without losing a sample
    #[arg(long, value_enum, default_value = "realtime")]
    pub pace: Pace,
    /// Real-time scheduling: SCHED_FIFO by stage, one core, locked memory
    #[arg(long)]
    pub rt: bool,
    /// One process with a thread for each service instead of a process for each: fewer of them to look after and less memory, but an
    /// error of one ends them all
    #[arg(long)]
    pub threads: bool,
    /// Core of all processes of the run: they wake each other faster there; under --rt that of the stages, the last one if absent
    #[arg(long, conflicts_with = "spin")]
    pub core: Option<usize>,
    /// Cores of the stages under --rt, in turn along the chain (for `latency`)
    #[arg(
        long,
        hide = true,
        requires = "rt",
        conflicts_with = "core",
        value_delimiter = ','
    )]
    pub spread: Vec<usize>,
    /// These processes poll for messages, each on a core of its own (isolated ones first), instead of sleeping; every step if none is
    /// named
    #[arg(long, value_name = "PROCESS,...", num_args = 0..=1, require_equals = true, default_missing_value = crate::spin::ALL,
        conflicts_with = "rt")]
    pub spin: Option<String>,
    /// Show a live page; this computer alone reaches it, unless an address is given, such as 0.0.0.0:8440; a port alone will do
    #[arg(long, value_name = "ADDR", num_args = 0..=1, value_parser = page, default_missing_value = view::live::DEFAULT_ADDRESS)]
    pub view: Option<SocketAddr>,
    /// Folder for the recording and the report
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Bounds of the recording
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Where what is found is sent
    #[command(flatten)]
    pub fleet: FleetArgs,
    /// Remember slow parameters from run to run in this file: what was trusted is the prior of the next run
    #[arg(long, value_name = "FILE")]
    pub state: Option<PathBuf>,
    /// Name of the run, by which `top` and `tail` find it; each run has shared memory of its own
    #[arg(long)]
    pub domain: Option<String>,
    /// Let this group of users read the recording and follow the run (tail, top); nobody else may, and nobody may write
    #[arg(long, value_name = "NAME")]
    pub group: Option<String>,
    /// Exit with status 1 if no estimate of the last 30 s is `trusted`
    #[arg(long)]
    pub require_trust: bool,
    /// Nothing on the terminal while it runs
    #[arg(long, short)]
    pub quiet: bool,
    /// Write no report
    #[arg(long)]
    pub no_report: bool,
    /// At the end, statistics of each process too
    #[arg(long)]
    pub verbose: bool,
    /// Print the live line to standard output (for the demonstration)
    #[arg(long, hide = true)]
    pub live_lines: bool,
    /// Add a process that notes when estimates arrive, and write its notes here (for `latency`)
    #[arg(long, hide = true, value_name = "FILE")]
    pub probe: Option<PathBuf>,
    /// That process waits for the iceoryx2 event, as a program from outside would
    #[arg(long, hide = true, requires = "probe")]
    pub probe_listens: bool,
}
