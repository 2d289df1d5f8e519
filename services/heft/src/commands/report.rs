//! `heft report`: one offline HTML page of a recording.

use std::fs;
use std::path::{Path, PathBuf};

use recording::Reader;
use view::Run;

use crate::failure::Failure;

/// `heft report`
pub fn report(file: &Path, output: Option<&Path>) -> Result<(), Failure> {
    let page = output.map_or_else(|| file.with_extension("html"), PathBuf::from);
    super::recover::mend(file)?;
    write(file, &page)?;
    println!("{}", page.display());
    Ok(())
}

/// Writes the page of a recording; nothing half-written is left behind.
pub fn write(recording: &Path, page: &Path) -> Result<(), Failure> {
    let run = Run::from_recording(&Reader::open(recording)?)?;
    let text = view::report(&run);
    let half = page.with_extension("html.tmp");
    fs::write(&half, text).map_err(|e| Failure::file("write", &half, &e))?;
    fs::rename(&half, page).map_err(|e| Failure::file("write", page, &e))
}
