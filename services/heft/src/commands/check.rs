//! `heft check`: validates a description of a machine.

use std::path::Path;

use config::Description;
use messages::Machine;

use crate::failure::Failure;

/// `heft check`
pub fn check(file: &Path, machine: Option<Machine>, print: bool) -> Result<(), Failure> {
    let text = std::fs::read_to_string(file).map_err(|e| Failure::file("read", file, &e))?;
    let description = Description::parse(&text, &file.display().to_string(), machine)?;
    if print {
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
