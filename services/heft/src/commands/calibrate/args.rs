//! The arguments of `heft calibrate`.

use std::path::PathBuf;

use clap::Args;
use messages::Machine;

use crate::args::{DescriptionArgs, ManyArgs, machine};

/// `heft calibrate`
#[derive(Debug, Args)]
#[command(after_help = "\
Example, with one weighed load:
  heft calibrate excavator empty.mcap loaded.mcap --payload empty.mcap=0 --payload loaded.mcap=423±2 -o m.toml")]
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
    /// Load in the bucket of a recording, as weighed (of a loader: for its lift cylinders)
    #[arg(long, value_name = "FILE=KG±KG")]
    pub payload: Vec<String>,
    /// Mass of the whole machine in a recording of a loader, as weighed
    #[arg(long, value_name = "FILE=KG±KG")]
    pub mass: Vec<String>,
    /// Axle scales of a loader (as for heft weigh): of the machine without load, or in a recording
    #[arg(long, value_name = "[FILE=]SCALES.csv")]
    pub weigh: Vec<String>,
    /// An out-and-back run of a loader: two recordings of one path, the second back with the machine turned round
    #[arg(
        long = "out-and-back",
        alias = "there-and-back",
        value_name = "FILE,FILE"
    )]
    pub there_and_back: Vec<String>,
    /// Find these keys only
    #[arg(long, value_name = "KEY,...", value_delimiter = ',')]
    pub free: Vec<String>,
    /// Signal map (TOML)
    #[arg(long)]
    pub map: Option<PathBuf>,
    /// What is known of the machine
    #[command(flatten)]
    pub description: DescriptionArgs,
    /// Machine file to write (TOML)
    #[arg(
        short,
        long,
        value_name = "MACHINE.toml",
        required_unless_present = "each"
    )]
    pub output: Option<PathBuf>,
    /// Also write an HTML report
    #[arg(long, value_name = "R.html")]
    pub report: Option<PathBuf>,
    /// Write the machine file even if something speaks against it
    #[arg(long)]
    pub accept: bool,
}
