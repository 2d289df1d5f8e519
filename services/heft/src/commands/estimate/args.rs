//! The arguments of `heft estimate`.

use std::path::PathBuf;

use clap::Args;
use messages::Machine;

use crate::args::{EstimationArgs, ManyArgs, machine};

/// `heft estimate`
#[derive(Debug, Args)]
#[command(after_help = "\
Example, with a table of your own (`heft map` writes the map, which you check):
  heft map day.csv -o day.toml
  heft estimate day.csv --machine excavator --map day.toml --class 21t -o out.csv --report out.html")]
pub struct EstimateArgs {
    /// Recorded data: .csv, .mcap, or .log (candump); without --output many of them, and folders of them
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// The machine; a recording of heft or the machine file (--config) names it
    #[arg(long, value_parser = machine())]
    pub machine: Option<Machine>,
    /// What they are made with; a recording of heft brings its machine file
    #[command(flatten)]
    pub with: EstimationArgs,
    /// Estimates, one row per accepted row of the input (CSV); if absent NAME.estimates.csv beside each input, with a summary in NAME.estimates.json
    #[arg(short, long, value_name = "OUT.csv")]
    pub output: Option<PathBuf>,
    /// Run a fixed-interval smoother, so that each estimate uses the whole recording (excavator with torque and posture)
    #[arg(long)]
    pub smooth: bool,
    /// Also write an HTML report
    #[arg(long, value_name = "R.html")]
    pub report: Option<PathBuf>,
    /// Also write a summary (JSON)
    #[arg(long, value_name = "FILE")]
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
