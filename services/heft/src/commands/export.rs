//! `heft export`: every channel of a recording as CSV.

use std::path::Path;

use recording::Reader;

use crate::failure::Failure;

/// `heft export`
pub fn export(file: &Path, folder: &Path) -> Result<(), Failure> {
    super::recover::mend(file)?;
    std::fs::create_dir_all(folder).map_err(|e| Failure::file("make the folder", folder, &e))?;
    for written in recording::csv::export(&Reader::open(file)?, folder)? {
        println!("{}", written.display());
    }
    Ok(())
}
