//! `heft map`: a first signal map from a file.

use std::path::{self, Path, PathBuf};

use clap::Args;
use messages::Machine;

use crate::args::machine;
use crate::failure::Failure;
use crate::many;
use crate::results;

/// `heft map`
#[derive(Debug, Args)]
#[command(after_help = "\
A signal map says which column or CAN signal is which quantity, in which unit. Check units and signs, then use it:
  heft estimate day.csv --machine excavator --map day.toml -o out.csv")]
pub struct MapArgs {
    /// The table (.csv), the CAN log (.log), or an MCAP file of others (.mcap), whose topics and numbers are listed
    pub file: PathBuf,
    /// The DBC files that describe the log
    #[arg(long, value_name = "FILE")]
    pub dbc: Vec<PathBuf>,
    /// The machine; the one that fits best if absent
    #[arg(long, value_parser = machine())]
    pub machine: Option<Machine>,
    /// Map to write; standard output if absent
    #[arg(short, long, value_name = "MAP.toml")]
    pub output: Option<PathBuf>,
}

/// `heft map`
pub fn map(args: &MapArgs) -> Result<(), Failure> {
    many::check_is_data(&args.file)?;
    let suggestion = recording::suggest(&args.file, &dbc(args)?, args.machine)?;
    let text = &suggestion.text;
    match &args.output {
        None => print!("{text}"),
        Some(path) => {
            // An existing map may have been edited: it is never overwritten.
            results::text("write the map", path, &[&args.file], |_| false, text)?;
            println!(
                "{}: read every line of it, then give it with --map",
                path.display()
            );
        }
    }
    let missing = suggestion.missing.iter().map(|group| group.join(" or "));
    let missing: Vec<String> = missing.collect();
    if !missing.is_empty() {
        eprintln!(
            "no name fits these, which are needed: {}; fill them in",
            missing.join(", ")
        );
    }
    if !suggestion.links.is_empty() {
        eprintln!(
            "no name fits {}: without all three angles nothing is trusted",
            suggestion.links.join(", ")
        );
    }
    if !suggestion.of_others.is_empty() {
        eprintln!(
            "these are not used, as their units are of something else: {}; a scale in their lines converts them",
            suggestion.of_others.join(", ")
        );
    }
    if !suggestion.unknown.is_empty() {
        eprintln!(
            "these are no units that heft knows: {}; write unit or scale into their lines",
            suggestion.unknown.join(", ")
        );
    }
    if !suggestion.of_second.is_empty() {
        eprintln!(
            "1/s is taken as rad/s: {}; where it counts turns, write unit = \"turn/s\" into their lines",
            suggestion.of_second.join(", ")
        );
    }
    Ok(())
}

/// The DBC files, with paths relative to the map's folder.
fn dbc(args: &MapArgs) -> Result<Vec<PathBuf>, Failure> {
    let folder = args.output.as_deref().and_then(Path::parent);
    if folder.is_none_or(|folder| folder.as_os_str().is_empty()) {
        return Ok(args.dbc.clone());
    }
    let absolute =
        |file: &PathBuf| path::absolute(file).map_err(|e| Failure::file("find", file, &e));
    args.dbc.iter().map(absolute).collect()
}
