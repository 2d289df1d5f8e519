//! Pages and pictures of recordings: written completely or not at all, and over earlier ones only.

use std::path::Path;

use recording::Reader;
use recording::output;
use view::Run;

use crate::failure::Failure;
use crate::results;

/// Writes the page of a recording; only the picture where the name ends in `.svg`.
pub fn write(reader: &Reader, page: &Path) -> Result<(), Failure> {
    let files: Vec<&Path> = reader.files().collect();
    output::check(page, &files, is_ours)?;
    let run = Run::from_recording(reader)?;
    let is_picture = page
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("svg"));
    let text = if is_picture {
        view::picture(&run)
    } else {
        view::report(&run)
    };
    put(&text, page, &files)
}

/// Writes the text of a page.
pub fn put(text: &str, page: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    results::text("write the page", page, inputs, is_ours, text)
}

/// Whether a page states that its recording is not whole.
pub fn tells_damage(page: &Path) -> bool {
    std::fs::read_to_string(page).is_ok_and(|text| text.contains(view::NOT_WHOLE))
}

/// Whether a file that begins like this is a page or a picture of heft.
pub fn is_ours(head: &[u8]) -> bool {
    let head = String::from_utf8_lossy(head);
    head.starts_with("<!doctype html>") && head.contains("<title>heft report")
        || head.starts_with("<svg") && head.contains("class=\"plot file\"")
}
