//! `heft report`: one offline HTML page of a recording.

use std::path::{Path, PathBuf};

use recording::Reader;
use recording::output::{self, Output};
use view::Run;

use crate::failure::Failure;
use crate::parts;

/// `heft report`
pub fn report(file: &Path, output: Option<&Path>) -> Result<(), Failure> {
    let reader = parts::open(file)?;
    let first = reader.files().next().unwrap_or(file);
    let page = output.map_or_else(|| first.with_extension("html"), PathBuf::from);
    write(&reader, &page)?;
    println!("{}", page.display());
    parts::tell_damage(&reader)
}

/// Writes the page of a recording; nothing half-written is left behind, and nothing overwritten but
/// an earlier page.
pub fn write(reader: &Reader, page: &Path) -> Result<(), Failure> {
    let files: Vec<&Path> = reader.files().collect();
    output::check(page, &files, is_page)?;
    let text = view::report(&Run::from_recording(reader)?);
    let mut out = Output::create("write the page", page, &files, is_page)?;
    out.put(text.as_bytes())?;
    Ok(out.finish()?)
}

/// Whether a file that begins like this is a page of heft.
pub fn is_page(head: &[u8]) -> bool {
    let head = String::from_utf8_lossy(head);
    head.starts_with("<!doctype html>") && head.contains("<title>heft report")
}
