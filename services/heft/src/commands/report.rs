//! `heft report`: one offline HTML page of a recording, or of several side by side.

use std::path::{Path, PathBuf};

use recording::Reader;
use recording::output::{self, Output};
use view::Run;

use crate::failure::Failure;
use crate::parts;

/// `heft report`
pub fn report(files: &[PathBuf], output: Option<&Path>) -> Result<(), Failure> {
    match files {
        [file] => one(file, output),
        _ => side_by_side(files, output),
    }
}

fn one(file: &Path, output: Option<&Path>) -> Result<(), Failure> {
    let reader = parts::open(file)?;
    let first = reader.files().next().unwrap_or(file);
    let page = output.map_or_else(|| first.with_extension("html"), PathBuf::from);
    write(&reader, &page)?;
    println!("{}", page.display());
    parts::tell_damage(&reader)
}

/// Recordings of the same machine compared, beside the first of them.
fn side_by_side(files: &[PathBuf], output: Option<&Path>) -> Result<(), Failure> {
    let readers = files.iter().map(|file| parts::open(file));
    let readers = readers.collect::<Result<Vec<_>, _>>()?;
    let mut runs = Vec::new();
    for (name, reader) in names(files).into_iter().zip(&readers) {
        runs.push((name, Run::from_recording(reader)?));
    }
    let inputs: Vec<&Path> = readers.iter().flat_map(Reader::files).collect();
    let first = inputs.first().copied().unwrap_or(Path::new("."));
    let page = output.map_or_else(|| first.with_file_name("compared.html"), PathBuf::from);
    put(&view::compared(&runs), &page, &inputs)?;
    println!("{}", page.display());
    readers.iter().try_for_each(parts::tell_damage)
}

/// The names of the files, whole paths where two have the same name.
fn names(files: &[PathBuf]) -> Vec<String> {
    let short = |file: &PathBuf| file.file_stem().map(|s| s.to_string_lossy().into_owned());
    let stems: Vec<Option<String>> = files.iter().map(short).collect();
    let distinct: std::collections::BTreeSet<_> = stems.iter().collect();
    if distinct.len() == files.len() && !stems.contains(&None) {
        return stems.into_iter().flatten().collect();
    }
    files
        .iter()
        .map(|file| file.display().to_string())
        .collect()
}

/// Writes the page of a recording; nothing half-written is left behind, and nothing overwritten but
/// an earlier page.
pub fn write(reader: &Reader, page: &Path) -> Result<(), Failure> {
    let files: Vec<&Path> = reader.files().collect();
    output::check(page, &files, is_page)?;
    put(&view::report(&Run::from_recording(reader)?), page, &files)
}

fn put(text: &str, page: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    let mut out = Output::create("write the page", page, inputs, is_page)?;
    out.put(text.as_bytes())?;
    Ok(out.finish()?)
}

/// Whether a file that begins like this is a page of heft.
pub fn is_page(head: &[u8]) -> bool {
    let head = String::from_utf8_lossy(head);
    head.starts_with("<!doctype html>") && head.contains("<title>heft report")
}
