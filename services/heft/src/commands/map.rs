//! `heft map`: a first signal map from a file.

use std::path::{Path, PathBuf};

use messages::Machine;

use crate::failure::Failure;

/// `heft map`
pub fn map(
    file: &Path,
    dbc: &[PathBuf],
    machine: Option<Machine>,
    output: Option<&Path>,
) -> Result<(), Failure> {
    let text = recording::suggest(file, dbc, machine)?;
    match output {
        None => print!("{text}"),
        Some(path) => {
            std::fs::write(path, text).map_err(|e| Failure::file("write", path, &e))?;
            println!(
                "{}: read every line of it, then give it with --map",
                path.display()
            );
        }
    }
    Ok(())
}
