//! `heft export`: every channel of a recording as CSV.

use std::path::Path;

use crate::failure::Failure;
use crate::parts;

/// `heft export`
pub fn export(file: &Path, folder: &Path) -> Result<(), Failure> {
    let reader = parts::open(file)?;
    std::fs::create_dir_all(folder).map_err(|e| Failure::folder(folder, &e))?;
    for written in recording::csv::export(&reader, folder)? {
        println!("{}", written.display());
    }
    parts::tell_damage(&reader)
}
