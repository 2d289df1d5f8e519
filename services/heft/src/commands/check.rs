//! `heft check`: validates a description of a machine.

use std::path::PathBuf;

use clap::Args;
use config::Description;
use messages::Machine;

use crate::args::{machine, tell_old_names};
use crate::failure::Failure;
use crate::small_file;

/// `heft check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The description (TOML)
    pub file: PathBuf,
    /// Machine, where the file does not say
    #[arg(long, value_parser = machine())]
    pub machine: Option<Machine>,
    /// Print the complete description, every key with its unit, range and meaning
    #[arg(long)]
    pub print: bool,
}

/// `heft check`
pub fn check(args: &CheckArgs) -> Result<(), Failure> {
    let file = &args.file;
    let text = small_file::text(file)?;
    tell_old_names(&config::old_names(&text));
    let description = Description::parse(&text, &file.display().to_string(), args.machine)?;
    if args.print {
        print!("{}", description.to_toml());
    } else {
        println!(
            "{}: a valid description of the {}",
            file.display(),
            description.machine()
        );
    }
    Ok(())
}
