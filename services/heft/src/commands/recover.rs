//! `heft recover`: writes a whole copy of a recording that was cut off, damaged or left in parts.
//! Commands that read a recording read what is whole of it by themselves, and write nothing.

use std::path::Path;

use crate::failure::Failure;

/// `heft recover`
pub fn recover(file: &Path, output: Option<&Path>) -> Result<(), Failure> {
    println!("{}: {}", file.display(), recording::recover(file, output)?);
    Ok(())
}
