//! Recordings in parts. A run records to `run.mcap`; data after a restart of its logger, or
//! after a split, are in `run.part2.mcap`, `run.part3.mcap`... Each part is a complete recording by
//! itself, and a reader of the first one reads all of them. A second run into the same folder
//! is `run-2.mcap`.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::Error;
use crate::file::Bytes;

/// Metadata key of a part's number.
pub const PART: &str = "part";
/// Metadata key of a joined recording that lists its former parts.
pub(crate) const JOINED: &str = "joined";

/// The name of a recording without `.partN.mcap`, and N where there is one.
fn name(path: &Path) -> Option<(String, Option<u32>)> {
    let stem = path.file_name()?.to_str()?.strip_suffix(".mcap")?;
    let split = stem.rsplit_once(".part");
    let part = split.and_then(|(run, n)| Some((run.to_owned(), Some(n.parse().ok()?))));
    Some(part.unwrap_or_else(|| (stem.to_owned(), None)))
}

/// The name of part `n` of the recording `first`.
pub fn part(first: &Path, n: u32) -> PathBuf {
    if n < 2 {
        return first.to_owned();
    }
    first.with_extension(format!("part{n}.mcap"))
}

/// The first part of `first` whose name is still free.
pub fn next_part(first: &Path) -> PathBuf {
    let taken = folder_of(first).filter_map(|p| name(&p));
    let stem = name(first).map_or_else(String::new, |n| n.0);
    let last = taken
        .filter(|n| n.0 == stem)
        .map(|n| n.1.unwrap_or(1))
        .max();
    part(first, last.map_or(1, |n| n + 1))
}

/// All files beside `path`.
fn folder_of(path: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path())
}

/// Reserves a name for the recording of a new run in `folder`: `run.mcap`, or the next
/// `run-N.mcap` that no recording uses. An empty file is created, so that two runs
/// that start at once do not choose the same name.
///
/// # Errors
/// The folder cannot be written.
pub fn reserve(folder: &Path) -> Result<PathBuf, Error> {
    for number in 1..=u32::MAX {
        let file = folder.join(match number {
            1 => "run.mcap".to_owned(),
            n => format!("run-{n}.mcap"),
        });
        // Parts without their first file are a recording too: their name is taken.
        if next_part(&file) != file {
            continue;
        }
        match std::fs::File::create_new(&file) {
            Ok(_) => return Ok(file),
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(Error::system("make the recording", &file, &e)),
        }
    }
    unreachable!("a folder does not hold so many files")
}

/// Whether `file` is a part of the recording `first`.
pub fn is_part_of(first: &Path, file: &Path) -> bool {
    first.parent() == file.parent() && name(first).map(|n| n.0) == name(file).map(|n| n.0)
}

/// Number of a part, 1 for the first.
pub fn part_number(file: &Path) -> u32 {
    name(file).and_then(|n| n.1).unwrap_or(1)
}

/// The files that runs have recorded into a folder (`run.mcap`, `run-2.part3.mcap`...) with the time
/// when they were last written and their size \[bytes\], the oldest first.
pub fn files_by_age(folder: &Path) -> Vec<(PathBuf, SystemTime, u64)> {
    let is_ours = |stem: &str| {
        let number = stem.strip_prefix("run-").map(|n| n.parse::<u32>().is_ok());
        stem == "run" || number == Some(true)
    };
    let files = folder_of(&folder.join("x")).filter(|f| name(f).is_some_and(|n| is_ours(&n.0)));
    let about = |file: PathBuf| {
        let about = std::fs::symlink_metadata(&file)
            .ok()
            .filter(|m| m.is_file())?;
        Some((file, about.modified().ok()?, about.len()))
    };
    let mut found: Vec<_> = files.filter_map(about).collect();
    found.sort_by_key(|(file, changed, _)| (*changed, part_number(file)));
    found
}

/// Whether a writer has the file open.
pub fn is_being_written(file: &Path) -> bool {
    Bytes::open(file).is_ok_and(|bytes| bytes.is_being_written())
}

/// The first part of each recording of a folder, the newest last; copies that `recover` has made and
/// unfinished joins are left out.
pub fn recordings(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<(SystemTime, PathBuf)> = Vec::new();
    for file in folder_of(&folder.join("x")) {
        let Some((stem, _)) = name(&file) else {
            continue;
        };
        if stem.starts_with('.') || stem.ends_with(".recovered") || stem.ends_with(".joined") {
            continue;
        }
        let about = std::fs::metadata(&file);
        let about = about.ok().filter(|m| m.is_file() && m.len() > 0);
        let Some(changed) = about.and_then(|m| m.modified().ok()) else {
            continue;
        };
        let first = folder.join(format!("{stem}.mcap"));
        match found.iter_mut().find(|(_, f)| *f == first) {
            Some((time, _)) => *time = changed.max(*time),
            None => found.push((changed, first)),
        }
    }
    found.sort();
    found.into_iter().map(|(_, file)| file).collect()
}

/// The files of the recording that `path` names: a folder means the newest recording in it,
/// the first part means all parts, another part only itself.
///
/// # Errors
/// The folder holds no recording.
pub(crate) fn files(path: &Path) -> Result<Vec<PathBuf>, Error> {
    let first = if path.is_dir() {
        recordings(path).pop().ok_or_else(|| {
            Error::new(
                "there is no recording in this folder",
                path.display().to_string(),
                "give a .mcap file, or a folder that `heft run --out` has filled",
            )
        })?
    } else {
        path.to_owned()
    };
    let Some((stem, None)) = name(&first) else {
        return Ok(vec![first]);
    };
    let siblings = folder_of(&first).filter_map(|file| Some((name(&file)?, file)));
    // Older versions renamed the first part to `run.part1.mcap`.
    let mut parts: Vec<(u32, PathBuf)> = siblings
        .filter(|((its, _), _)| *its == stem)
        .filter_map(|((_, n), file)| Some((n?, file)))
        .collect();
    parts.sort();
    let mut files: Vec<PathBuf> = parts.into_iter().map(|(_, file)| file).collect();
    if files.is_empty() || first.exists() {
        files.insert(0, first);
    }
    Ok(files)
}

/// Whether a recording or any other file has this name: the first part of a recording may have been removed for its age.
pub fn exists(path: &Path) -> bool {
    path.exists() || changed(path).is_some()
}

/// Time of the last write to the files of this name.
pub fn changed(path: &Path) -> Option<SystemTime> {
    let files = files(path).unwrap_or_default();
    let written = |file: &PathBuf| std::fs::metadata(file).and_then(|m| m.modified()).ok();
    files.iter().filter_map(written).max()
}

/// Names of missing parts between the first and the last file of a recording. The oldest parts may have been removed
/// for their age.
pub(crate) fn missing(files: &[PathBuf]) -> Vec<String> {
    let mut numbers: Vec<u32> = files.iter().map(|file| part_number(file)).collect();
    numbers.sort_unstable();
    let pairs = numbers.windows(2).map(|pair| (pair[0] + 1, pair[1]));
    let gaps = pairs.filter(|(from, to)| from < to);
    let words = |(from, to)| match to - from {
        1 => format!("{}: part {from} is missing", files[0].display()),
        _ => format!(
            "{}: parts {from} to {} are missing",
            files[0].display(),
            to - 1
        ),
    };
    gaps.map(words).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(folder: &Path, name: &str) -> PathBuf {
        let file = folder.join(name);
        std::fs::write(&file, "x").expect("writable");
        file
    }

    #[test]
    fn a_second_run_gets_a_name_of_its_own() {
        let dir = tempfile::tempdir().expect("a folder");
        let names: Vec<_> = (0..3).map(|_| reserve(dir.path()).expect("free")).collect();
        let expected = ["run.mcap", "run-2.mcap", "run-3.mcap"].map(|n| dir.path().join(n));
        assert_eq!(names, expected);
        touch(dir.path(), "run-4.part1.mcap");
        assert_eq!(reserve(dir.path()), Ok(dir.path().join("run-5.mcap")));
    }

    #[test]
    fn parts_belong_to_their_first_file() {
        let dir = tempfile::tempdir().expect("a folder");
        let first = touch(dir.path(), "run.mcap");
        assert_eq!(next_part(&first), dir.path().join("run.part2.mcap"));
        let parts = [
            first.clone(),
            touch(dir.path(), "run.part2.mcap"),
            touch(dir.path(), "run.part10.mcap"),
        ];
        touch(dir.path(), "run-2.mcap");
        touch(dir.path(), "run.recovered.mcap");
        assert_eq!(files(&first), Ok(parts.to_vec()));
        assert_eq!(files(&parts[2]), Ok(vec![parts[2].clone()]));
        let lack = missing(&parts);
        assert_eq!(lack.len(), 1, "{lack:?}");
        assert!(lack[0].ends_with("run.mcap: parts 3 to 9 are missing"));
        assert_eq!(missing(&parts[..2]), Vec::<String>::new());
        assert_eq!(next_part(&first), dir.path().join("run.part11.mcap"));
        let later = SystemTime::now() + std::time::Duration::from_secs(60);
        let last = std::fs::File::options().write(true).open(&parts[2]);
        last.and_then(|file| file.set_modified(later))
            .expect("its time");
        assert_eq!(changed(&first), Some(later));
        let both = vec![first, dir.path().join("run-2.mcap")];
        let mut found = recordings(dir.path());
        found.sort_by_key(|f| f.as_os_str().len());
        assert_eq!(found, both);
        std::fs::remove_file(&both[0]).expect("the first part");
        assert!(exists(&both[0]));
        assert!(!exists(&dir.path().join("run-3.mcap")));
    }
}
