//! `heft serve`: estimates of many machines, for the computer of a site.

use std::ffi::OsString;
use std::fs::File;
use std::io::stdin;
use std::num::NonZeroUsize;
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use clap::Args;
use messages::Machine;
use steps::chain::{chain, method};

use crate::args::{DescriptionArgs, EstimationArgs, description, machine, tell_odd_keys};
use crate::failure::Failure;
use crate::serve::{Common, Form, Input, UntilSignal};
use crate::{machines, size, sources};

/// Largest number of processes: more than any computer has processors, and a bound on a mistyped number.
const MOST_SHARDS: i64 = 1024;

/// `heft serve`
#[derive(Debug, Args)]
pub struct ServeArgs {
    /// The kind of the machines
    #[arg(value_parser = machine())]
    pub machine: Machine,
    /// The table (CSV); standard input if absent
    pub file: Option<PathBuf>,
    /// Options of the estimation
    #[command(flatten)]
    pub with: EstimationArgs,
    /// At most one row per machine in this time of its clock, such as 1 (s) or 500ms; every row if 0
    #[arg(long, value_name = "TIME", default_value_t = 0.0, value_parser = view::duration::seconds, allow_negative_numbers = true)]
    pub every: f64,
    /// Processes that the machines are shared among; as many as there are processors if absent
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_SHARDS))]
    pub shards: Option<u16>,
    /// Read and write messages as recordings hold them, in place of tables: for programs, such as `heft fleet serve`
    #[arg(long, conflicts_with = "map")]
    pub messages: bool,
    /// Run as one of these processes
    #[arg(long, hide = true)]
    pub shard: bool,
}

/// `heft serve`
pub fn serve(args: &ServeArgs) -> Result<(), Failure> {
    let description = description(Some(args.machine), &args.with.description)?;
    let method = method(args.machine, args.with.method.as_deref());
    let entry = machines::entry(args.machine);
    let form = if args.messages {
        Form::Messages
    } else {
        Form::Table
    };
    if args.shard {
        return (entry.serve_shard)(&description, method, args.every, form);
    }
    // The router reports errors of the method and the description, so that they appear once and not once per shard.
    chain(&description, method)?;
    tell_odd_keys(&description, &[method]);
    let map = sources::map(args.with.map.as_deref())?;
    let input = args.file.as_deref().unwrap_or(Path::new("-"));
    if !args.messages
        && let Some(note) = size::assumed(&description, &args.with.description, input)?
    {
        eprintln!("{note}");
    }
    let input = opened(args.file.as_deref(), form)?;
    let shards = args.shards.map_or_else(usual_shards, usize::from);
    let mut arguments = shard_arguments(args.machine, method, &args.with.description, args.every);
    if args.messages {
        arguments.push("--messages".into());
    }
    let common = Common {
        description: &description,
        map: map.as_ref(),
        shards,
        arguments: &arguments,
    };
    (entry.route)(input, form, common)
}

/// The file, or standard input. A signal ends a table in order; messages come from a program, which ends them itself.
fn opened(file: Option<&Path>, form: Form) -> Result<Input, Failure> {
    let (name, content) = match file {
        Some(folder) if folder.is_dir() => {
            let error = std::io::ErrorKind::IsADirectory.into();
            return Err(Failure::file("read", folder, &error));
        }
        Some(file) => (
            file.display().to_string(),
            File::open(file).map_err(|e| Failure::file("read", file, &e))?,
        ),
        None => {
            let own = stdin().as_fd().try_clone_to_owned();
            let own = own.map_err(|e| Failure::file("read", Path::new("standard input"), &e))?;
            ("standard input".to_owned(), File::from(own))
        }
    };
    Ok(Input {
        name: name.into(),
        content: match form {
            Form::Table => Box::new(UntilSignal::of(content)?),
            Form::Messages => Box::new(content),
        },
    })
}

/// The arguments of a shard.
pub fn shard_arguments(
    machine: Machine,
    method: &str,
    description: &DescriptionArgs,
    every: f64,
) -> Vec<OsString> {
    let fixed = [
        "serve",
        machine.name(),
        "--shard",
        "--method",
        method,
        "--every",
    ];
    let mut all: Vec<OsString> = fixed.map(Into::into).into();
    all.push(every.to_string().into());
    all.extend(description.again());
    all
}

/// Default number of shards: the number of processors.
pub fn usual_shards() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
}
