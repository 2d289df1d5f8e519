//! `heft check`: validates a machine file.

use std::path::PathBuf;

use clap::Args;
use config::Description;
use messages::Machine;

use crate::args::{is_for, machine, tell_old_names};
use crate::failure::Failure;
use crate::small_file;

/// `heft check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The machine file (TOML); with --print the reference machine if absent
    #[arg(required_unless_present = "print")]
    pub file: Option<PathBuf>,
    /// The machine that it is for; needed where the file does not say
    #[arg(long, value_parser = machine())]
    pub machine: Option<Machine>,
    /// Print the complete machine file, every key with its unit, range and meaning
    #[arg(long)]
    pub print: bool,
}

/// `heft check`
pub fn check(args: &CheckArgs) -> Result<(), Failure> {
    let text = args.file.as_deref().map(small_file::text).transpose()?;
    let text = text.unwrap_or_default();
    tell_old_names(&config::old_names(&text));
    let name = args.file.as_ref().map(|file| file.display().to_string());
    let name = name.unwrap_or_else(|| "--print".to_owned());
    let description = Description::parse(&text, &name, args.machine)?;
    if let Some(machine) = args.machine {
        is_for(machine, &description, &name)?;
    }
    if args.print {
        print!("{}", description.to_toml());
    } else {
        println!(
            "{name}: a valid machine file of the {}",
            description.machine()
        );
    }
    Ok(())
}
