//! The command line: names, arguments, help texts.

use std::net::SocketAddr;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use messages::Machine;

use crate::bounds::LimitArgs;
use crate::fleet::FleetArgs;
use crate::machines;

/// Lets a construction machine know its own mass properties while it works.
///
/// Without a command: the demonstration. Both machines run in real time as separate processes for
/// some 20 s; then heft says what it found and whether to believe it.
#[derive(Debug, Parser)]
#[command(name = "heft", version = crate::build::IDENTITY, max_term_width = 100)]
#[command(
    after_help = "Exit status: 0 done, 1 ran but the answer is no, 2 wrong use or bad input."
)]
pub struct Cli {
    /// What to do; the demonstration if absent.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The machines by their names.
fn machine() -> impl TypedValueParser<Value = Machine> {
    let names = Machine::ALL
        .map(|machine| PossibleValue::new(machine.name()).help(machines::entry(machine).about()));
    PossibleValuesParser::new(names)
        .try_map(|name| Machine::from_name(&name).ok_or("there is no such machine"))
}

/// How fast a run goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Pace {
    /// At the times that the samples tell.
    Realtime,
    /// As fast as the processes take it, without losing a sample.
    Max,
}

/// Commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the pipeline as separate processes, on the simulator or on recorded data
    Run(Box<RunArgs>),
    /// Run the same steps in one process on recorded data
    Estimate(EstimateArgs),
    /// Estimate for many machines at once: a table with a column `machine` in, estimates out
    Serve(ServeArgs),
    /// Recompute every estimate of a recording
    Replay(ReplayArgs),
    /// Evaluate the estimators by Monte-Carlo simulation, next to the published figures
    Evaluate(EvaluateArgs),
    /// Find the machine's own parameters from recordings, with intervals
    Calibrate(CalibrateArgs),
    /// Write a whole copy of a recording that was cut off, damaged or left in parts
    Recover {
        /// The recording, or its folder; it is not changed
        file: PathBuf,
        /// Copy to write; RUN.recovered.mcap beside the recording if absent
        #[arg(short, long)]
        output: Option<PathBuf>,
    },
    /// Make one offline HTML page of a recording
    Report(ReportArgs),
    /// Write every channel of a recording as CSV
    Export {
        /// The recording, or its folder
        file: PathBuf,
        /// Folder to write to
        #[arg(short, long)]
        output: PathBuf,
    },
    /// Dashboard of a running pipeline in the terminal
    Top {
        /// The domain to attach to; the only one there is if absent
        #[arg(long)]
        domain: Option<String>,
        /// Print one picture as text and end
        #[arg(long)]
        once: bool,
    },
    /// Measure the latency of the real processes next to the machine's own limits
    Latency(LatencyArgs),
    /// Say what this host lacks for real-time work, and what killed runs left behind
    Doctor {
        /// Remove what killed runs left behind
        #[arg(long)]
        clean: bool,
    },
    /// Validate a description of a machine
    Check {
        /// The description (TOML)
        file: PathBuf,
        /// Machine, where the file does not say
        #[arg(long, value_parser = machine())]
        machine: Option<Machine>,
        /// Print the complete description, every key with its unit, range and meaning
        #[arg(long)]
        print: bool,
    },
    /// Write a first signal map for a table or a CAN log, each line with its reason
    Map {
        /// The table (.csv) or the CAN log (.log)
        file: PathBuf,
        /// The DBC files that describe the log
        #[arg(long, value_name = "FILE")]
        dbc: Vec<PathBuf>,
        /// The machine; the one that fits best if absent
        #[arg(long, value_parser = machine())]
        machine: Option<Machine>,
        /// Map to write; standard output if absent
        #[arg(short, long, value_name = "MAP.toml")]
        output: Option<PathBuf>,
    },
    /// Print the messages as types of another language
    Schema {
        /// The language
        #[arg(long, value_enum)]
        lang: crate::commands::schema::Language,
        /// With --lang dbc: the machine; every machine if absent
        #[arg(long, value_parser = machine())]
        machine: Option<Machine>,
        /// With --lang dbc: the output map of that machine
        #[arg(long, requires = "machine", value_name = "FILE")]
        output_map: Option<PathBuf>,
    },
    /// Follow a channel of a running pipeline, a line per sample
    Tail(crate::commands::tail::TailArgs),
    /// Centre of gravity from axle weights on level and tilted ground
    Weigh {
        /// CSV with the columns pitch [rad], front_load [N], rear_load [N]
        file: PathBuf,
        /// Description of the loader
        #[command(flatten)]
        description: DescriptionArgs,
        /// Write the result as JSON
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Keep and show what many machines send (needs heft-fleet)
    #[command(disable_help_flag = true)]
    Fleet {
        /// `heft fleet --help` tells
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<String>,
    },
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Write manual pages and completion scripts into a folder (for packages)
    #[command(hide = true)]
    Package {
        /// The folder
        folder: PathBuf,
    },
    /// Be one service of a pipeline (started by the supervisor)
    #[command(hide = true)]
    Service {
        /// Name in the table of processes
        name: String,
        /// Domain of the run
        #[arg(long)]
        domain: String,
        /// How often it was started before
        #[arg(long, default_value_t = 0)]
        restarts: u32,
    },
    /// Be one link of a bare chain (started by `heft latency`)
    #[command(hide = true, name = "limits-worker")]
    LimitsWorker {
        /// What the chain tells its links
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<String>,
    },
}

/// The machine's description.
#[derive(Debug, Clone, Args)]
pub struct DescriptionArgs {
    /// Description of the machine (TOML)
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Set one key of the description, such as sensors.swing_velocity_std=0.008
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// `heft run`
#[derive(Debug, Clone, Args)]
pub struct RunArgs {
    /// The machine
    #[arg(value_parser = machine())]
    pub machine: Machine,
    /// Scenario of the simulator; `--scenario list` names them
    #[arg(long)]
    pub scenario: Option<String>,
    /// Payload of the simulator [kg]
    #[arg(long, value_name = "KG")]
    pub payload: Option<f64>,
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
    /// So many machines in one run, simulated with seeds one apart or those of the recordings in the folder --input: no pipeline
    /// each, but a process a processor that steps them all, and one table of estimates
    #[arg(long, value_name = "N", conflicts_with_all = [
        "output", "rt", "spin", "view", "split", "min_free", "fleet", "state", "domain", "group", "require_trust", "no_report",
        "live_lines", "probe",
    ])]
    pub machines: Option<NonZeroUsize>,
    /// The machine's description
    #[command(flatten)]
    pub description: DescriptionArgs,
    /// Method of the ukf process
    #[arg(long)]
    pub method: Option<String>,
    /// Length of the run [s]; until the scenario ends if absent
    #[arg(long, value_name = "S")]
    pub duration: Option<f64>,
    /// Sampling rate of the simulator [Hz]; that of the description if absent
    #[arg(long, value_name = "HZ")]
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
    /// Core of the stages under --rt; the last one if absent
    #[arg(long, requires = "rt")]
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
    /// These processes look for messages all the time, each on a core of its own (isolated ones first), instead of sleeping until
    /// they are woken; every step if none is named
    #[arg(long, value_name = "PROCESS,...", num_args = 0..=1, require_equals = true, default_missing_value = crate::spin::ALL,
        conflicts_with = "rt")]
    pub spin: Option<String>,
    /// Show a live page
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = view::live::DEFAULT_ADDRESS)]
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
    /// Name of the run's corner of shared memory
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

/// `heft estimate`
#[derive(Debug, Args)]
pub struct EstimateArgs {
    /// Recorded data: .csv, .mcap, or .log (candump); without --output many of them, and folders of them
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// The machine
    #[arg(long, value_parser = machine())]
    pub machine: Machine,
    /// Signal map (TOML)
    #[arg(long)]
    pub map: Option<PathBuf>,
    /// Method; see the README for the list
    #[arg(long)]
    pub method: Option<String>,
    /// The machine's description
    #[command(flatten)]
    pub description: DescriptionArgs,
    /// Estimates, one row per accepted row of the input (CSV); if absent NAME.estimates.csv beside each input, with a summary in NAME.estimates.json
    #[arg(short, long, value_name = "OUT.csv")]
    pub output: Option<PathBuf>,
    /// Also let every later row speak of each moment (excavator, torque and posture)
    #[arg(long)]
    pub smooth: bool,
    /// Also write an HTML report
    #[arg(long, value_name = "R.html", requires = "output")]
    pub report: Option<PathBuf>,
    /// Also write a summary (JSON)
    #[arg(long, value_name = "FILE", requires = "output")]
    pub json: Option<PathBuf>,
    /// Exit with status 1 if no estimate of the last 30 s is `trusted`
    #[arg(long)]
    pub require_trust: bool,
    /// Many inputs: write the table of results here too (CSV)
    #[arg(long, value_name = "FILE.csv", conflicts_with = "output")]
    pub summary: Option<PathBuf>,
    /// How many inputs are treated
    #[command(flatten)]
    pub many: ManyArgs,
}

/// Many inputs in one command.
#[derive(Debug, Args)]
pub struct ManyArgs {
    /// Many inputs: do again what is done already
    #[arg(long, conflicts_with = "output")]
    pub again: bool,
    /// Many inputs: processes at the same time; as many as there are processors if absent
    #[arg(long, value_name = "N", conflicts_with = "output")]
    pub jobs: Option<NonZeroUsize>,
}

/// `heft report`
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// The recording, or its folder; several of the same machine are compared
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Page to write; if absent the recording's name with .html, or compared.html beside the first
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// A page of its own beside each recording, and beside every recording of a folder
    #[arg(long, conflicts_with = "output")]
    pub each: bool,
    /// How many inputs are treated
    #[command(flatten)]
    pub many: ManyArgs,
}

/// `heft serve`
#[derive(Debug, Args)]
pub struct ServeArgs {
    /// The kind of the machines
    #[arg(value_parser = machine())]
    pub machine: Machine,
    /// The table (CSV); standard input if absent
    pub file: Option<PathBuf>,
    /// Signal map (TOML)
    #[arg(long)]
    pub map: Option<PathBuf>,
    /// Method; see the README for the list
    #[arg(long)]
    pub method: Option<String>,
    /// The description of all of them
    #[command(flatten)]
    pub description: DescriptionArgs,
    /// At most one row a machine in so much of its time [s]; every row if 0
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = seconds)]
    pub every: f64,
    /// Processes that the machines are shared among; as many as there are processors if absent
    #[arg(long, value_name = "N")]
    pub shards: Option<NonZeroUsize>,
    /// Be one of them
    #[arg(long, hide = true)]
    pub shard: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x| (0.0..=1e9).contains(x));
    number.ok_or_else(|| "a number of seconds, 0 or more".into())
}

/// `heft calibrate`
#[derive(Debug, Args)]
pub struct CalibrateArgs {
    /// The machine
    #[arg(value_parser = machine())]
    pub machine: Machine,
    /// Recordings: .csv, .mcap, .log (candump), or folders of runs
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Every folder that is named holds the recordings of one machine; calibrated.toml and calibrated.html are written there
    #[arg(long, conflicts_with_all = ["output", "report"])]
    pub each: bool,
    /// With --each: also write the results of all as one table (CSV)
    #[arg(long, value_name = "FILE", requires = "each")]
    pub summary: Option<PathBuf>,
    /// How many machines are treated
    #[command(flatten)]
    pub many: ManyArgs,
    /// Load in the bucket in a recording of an excavator, as weighed
    #[arg(long, value_name = "FILE=KG±KG")]
    pub payload: Vec<String>,
    /// Mass of the whole machine in a recording of a loader, as weighed
    #[arg(long, value_name = "FILE=KG±KG")]
    pub mass: Vec<String>,
    /// Axle scales of a loader (as for heft weigh): of the machine without load, or in a recording
    #[arg(long, value_name = "[FILE=]SCALES.csv")]
    pub weigh: Vec<String>,
    /// Find these keys only
    #[arg(long, value_name = "KEY,...", value_delimiter = ',')]
    pub free: Vec<String>,
    /// Signal map (TOML)
    #[arg(long)]
    pub map: Option<PathBuf>,
    /// The machine's description
    #[command(flatten)]
    pub description: DescriptionArgs,
    /// Description to write (TOML)
    #[arg(
        short,
        long,
        value_name = "DESCRIPTION",
        required_unless_present = "each"
    )]
    pub output: Option<PathBuf>,
    /// Also write an HTML report
    #[arg(long, value_name = "R.html")]
    pub report: Option<PathBuf>,
    /// Write the description even if something speaks against it
    #[arg(long)]
    pub accept: bool,
}

/// `heft replay`
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// The recording, or its folder
    pub file: PathBuf,
    /// Compare every estimate bit for bit; exit 1 if one differs
    #[arg(long)]
    pub verify: bool,
}

/// `heft evaluate`
#[derive(Debug, Args)]
pub struct EvaluateArgs {
    /// The machine
    #[arg(value_parser = machine())]
    pub machine: Machine,
    /// One table only; an unknown name lists them
    #[arg(long)]
    pub table: Option<String>,
    /// Monte-Carlo runs per case
    #[arg(long, default_value_t = 100)]
    pub seeds: usize,
    /// Write the numbers as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Draw the papers' figures from our runs as SVG into this folder
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
}

/// `heft latency`
#[derive(Debug, Args)]
pub struct LatencyArgs {
    /// The machine whose processes are measured
    #[arg(value_parser = machine(), default_value = Machine::Excavator.name())]
    pub machine: Machine,
    /// One sampling rate [Hz]; 100, 1000 and 10000 if absent
    #[arg(long, value_name = "HZ")]
    pub rate: Option<f64>,
    /// Seconds per measurement
    #[arg(long, default_value_t = 5.0)]
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
