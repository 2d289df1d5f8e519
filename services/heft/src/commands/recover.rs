//! `heft recover`: writes a whole copy of a recording that was cut off, damaged or left in parts.
//! Commands that read a recording read its whole part themselves, and write nothing.

use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::signals;

/// `heft recover`
#[derive(Debug, Args)]
pub struct RecoverArgs {
    /// The recording, or its folder; it is not changed
    pub file: PathBuf,
    /// Copy to write; RUN.recovered.mcap beside the recording if absent
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// `heft recover`
pub fn recover(args: &RecoverArgs) -> Result<(), Failure> {
    signals::leave_nothing()?;
    let recovered = recording::recover(&args.file, args.output.as_deref())?;
    println!("{}: {recovered}", args.file.display());
    if recovered.messages == 0 {
        return Err(Failure::answer_is_no(format!(
            "nothing was recovered\n  where: {}\n  what to do: look for another copy of the recording",
            args.file.display()
        )));
    }
    Ok(())
}
