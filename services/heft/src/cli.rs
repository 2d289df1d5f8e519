//! The command line as a whole, and the arguments that commands share.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser};
use messages::Machine;
use steps::stages::Pipeline;

use crate::commands::Command;
use crate::machines;

/// Lets a construction machine know its own mass properties while it works.
///
/// Without a command: the demonstration. Both machines run in real time as separate processes for
/// some 20 s; then heft says what it found and whether to believe it.
#[derive(Debug, Parser)]
#[command(name = "heft", version = crate::build::IDENTITY, max_term_width = 100)]
#[command(
    after_help = "Exit status: 0 done, 1 ran but the answer is no, 2 wrong use or bad input.\n\n\
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

/// The machines by their names.
pub fn machine() -> impl TypedValueParser<Value = Machine> {
    let names = Machine::ALL
        .map(|machine| PossibleValue::new(machine.name()).help(machines::entry(machine).about()));
    PossibleValuesParser::new(names)
        .try_map(|name| Machine::from_name(&name).ok_or("there is no such machine"))
}

/// The machine's description.
#[derive(Debug, Clone, Args)]
pub struct DescriptionArgs {
    /// Description of the machine (TOML)
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Size of the machine, such as 21t: what nothing else tells is that of machines of this mass
    #[arg(long, value_name = "MASS", value_parser = tonnes)]
    pub class: Option<f64>,
    /// Set one key of the description, such as sensors.swing_velocity_std=0.008
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// A mass such as 21t, 21.5 t or 21500kg \[kg\].
fn tonnes(text: &str) -> Result<f64, String> {
    let text = text.trim().to_lowercase();
    let (number, factor) = match (text.strip_suffix("kg"), text.strip_suffix('t')) {
        (Some(number), _) => (number, 1.0),
        (None, Some(number)) => (number, 1000.0),
        (None, None) => return Err("write it like 21t or 21500kg".into()),
    };
    let mass = number.trim().parse::<f64>().map(|number| number * factor);
    mass.ok()
        .filter(|mass| (200.0..=1e6).contains(mass))
        .ok_or_else(|| "a mass from 200kg to 1000t".into())
}

/// What `--method` says of itself: the methods of each machine, the usual one first.
fn methods() -> String {
    let of = |machine: Machine| {
        let pipeline = Pipeline::of(machine);
        let stages = pipeline.stages.iter().rev();
        let names: Vec<&str> = stages.flat_map(|stage| stage.methods()).copied().collect();
        format!("{}: {}", machine.name(), names.join(", "))
    };
    let all = Machine::ALL.map(of).join("; ");
    format!("Method; the usual one if absent ({all})")
}

/// What estimates are made with.
#[derive(Debug, Args)]
pub struct EstimationArgs {
    /// Signal map (TOML)
    #[arg(long)]
    pub map: Option<PathBuf>,
    #[arg(long, help = methods())]
    pub method: Option<String>,
    /// The machine's description
    #[command(flatten)]
    pub description: DescriptionArgs,
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
