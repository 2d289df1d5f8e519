//! `heft map`: a first signal map from a file.

use std::path::{Path, PathBuf};

use messages::Machine;

use crate::failure::Failure;
use crate::results;

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
            // Somebody may have worked on an earlier one.
            results::text("write the map", path, &[file], |_| false, &text)?;
            println!(
                "{}: read every line of it, then give it with --map",
                path.display()
            );
        }
    }
    Ok(())
}
