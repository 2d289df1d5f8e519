//! `heft export`: every channel of a recording as CSV.

use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::parts;

/// `heft export`
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// The recording, or its folder
    pub file: PathBuf,
    /// Folder to write to
    #[arg(short, long)]
    pub output: PathBuf,
}

/// `heft export`
pub fn export(args: &ExportArgs) -> Result<(), Failure> {
    crate::signals::leave_nothing()?;
    let folder = &args.output;
    let reader = parts::open(&args.file)?;
    parts::check_content(&reader)?;
    std::fs::create_dir_all(folder).map_err(|e| Failure::folder(folder, &e))?;
    for written in recording::csv::export(&reader, folder)? {
        println!("{}", written.display());
    }
    parts::check_whole(&reader)
}
