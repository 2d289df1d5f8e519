//! Many inputs in one command: a process for each, as many at a time as there are processors. Results that are up to date are
//! not computed again, so an interrupted command continues where it stopped.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::io::{IsTerminal, Read};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use calibrate::parallel;
use recording::{Kind, OneLine};

use crate::failure::Failure;
use crate::image;
use crate::out::{self, Plain};
use crate::signals::{Children, end_together};

/// One input.
pub struct Job {
    /// Its name.
    pub input: PathBuf,
    /// Arguments of its process of `heft`.
    pub arguments: Vec<OsString>,
    /// Its result exists already.
    pub is_done: bool,
}

/// How a job ended.
pub enum Outcome {
    /// The result existed.
    Kept,
    /// The result was computed.
    Made,
    /// It was computed, and the answer is no: why.
    No(String),
    /// There is no result: why.
    Failed(String),
}

impl Outcome {
    /// One word, or the message.
    pub fn word(&self) -> &str {
        match self {
            Self::Kept => "up to date",
            Self::Made => "done",
            Self::No(why) | Self::Failed(why) => why.lines().next().unwrap_or_default(),
        }
    }

    /// Whether there is no result.
    pub fn is_bad_input(&self) -> bool {
        matches!(self, Self::Failed(_))
    }
}

/// Exit status of the command: that of the worst outcome.
pub fn judge(ends: &[Outcome]) -> Result<(), Failure> {
    let failed = ends.iter().filter(|e| e.is_bad_input()).count();
    let no = ends.iter().filter(|e| matches!(e, Outcome::No(_))).count();
    match (failed, no, ends) {
        (0, 0, _) => Ok(()),
        (_, _, [Outcome::No(why)]) => Err(Failure::answer_is_no(why.as_str())),
        (_, _, [Outcome::Failed(why)]) => Err(Failure::reported(why.clone())),
        (0, no, _) => Err(Failure::answer_is_no(format!(
            "{no} of {} inputs have a result that is in doubt; the table above says why",
            ends.len()
        ))),
        (failed, _, _) => Err(Failure::input(
            format!("{failed} of {} inputs failed", ends.len()),
            "the table above",
            "fix or remove them and run again; finished inputs are skipped",
        )),
    }
}

/// The named recordings: files as they are, and in every folder each recording once
/// (not its parts), each table and each CAN log, but no results of heft.
///
/// # Errors
/// There is no such file, a folder cannot be read, or nothing is found.
pub fn inputs(paths: &[PathBuf], tables: bool) -> Result<Vec<PathBuf>, Failure> {
    let (mut found, mut left_out) = (Vec::new(), Vec::new());
    for path in paths {
        // A name like an option would be parsed as one by the process that reads it.
        let path = &match path.as_os_str().as_encoded_bytes() {
            [b'-', ..] => Path::new(".").join(path),
            _ => path.clone(),
        };
        if path.is_dir() {
            let mut unread = Vec::new();
            walk(path, tables, &mut found, &mut unread)
                .map_err(|e| Failure::file("read", path, &e))?;
            left_out.append(&mut unread);
        } else if recording::exists(path) {
            // `*.csv` also matches earlier results.
            found.extend((!is_ours(path)).then(|| path.clone()));
        } else {
            let error = std::io::ErrorKind::NotFound.into();
            return Err(Failure::file("read", path, &error));
        }
    }
    let mut seen = BTreeSet::new();
    found.retain(|f| seen.insert(f.canonicalize().unwrap_or_else(|_| f.clone())));
    if found.is_empty() {
        if let Some(error) = paths.iter().find_map(|path| recording::foreign(path)) {
            return Err(error.into());
        }
        paths.iter().try_for_each(|path| check_is_data(path))?;
        let places: Vec<_> = paths.iter().map(|p| p.display().to_string()).collect();
        let remedy = match tables {
            true => {
                "name recordings (.mcap), tables (.csv), CAN logs (.log), or folders that hold some; a table of `heft export` counts where it is named itself"
            }
            false => {
                "name recordings of heft (.mcap), or folders that hold some; tables and CAN logs have a page by `heft estimate FILE --report PAGE`"
            }
        };
        return Err(Failure::input(
            "there is nothing to read",
            places.join(", "),
            remedy,
        ));
    }
    tell_unread(&left_out);
    Ok(found)
}

/// Most files of other formats that are named.
const NAMED: usize = 10;

/// Names the files of folders that may hold samples in a format that heft does not read.
fn tell_unread(files: &[(PathBuf, &str)]) {
    for (file, what) in files.iter().take(NAMED) {
        eprintln!("left out: {}: {what}", OneLine(file.display()));
    }
    match files.len().saturating_sub(NAMED) {
        0 => {}
        more => eprintln!("left out: {more} more of other formats"),
    }
    if let [(file, _), ..] = files {
        eprintln!(
            "heft reads .csv, .log and .mcap of a folder; `heft map {}` says how to convert it",
            OneLine(file.display())
        );
    }
}

/// The inputs of a folder, and the files that may be some in another format.
fn walk(
    folder: &Path,
    tables: bool,
    found: &mut Vec<PathBuf>,
    unread: &mut Vec<(PathBuf, &'static str)>,
) -> std::io::Result<()> {
    let mut recordings = recording::recordings(folder);
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let (path, kind) = entry.map(|e| (e.path(), e.file_type()))?;
        let hidden = path
            .file_name()
            .is_none_or(|n| n.as_encoded_bytes()[0] == b'.');
        // Links are not followed: they may form a cycle.
        if hidden {
            continue;
        } else if kind?.is_dir() {
            folders.push(path);
        } else if tables && (path.is_file() || is_dangling(&path)) && is_table(&path) {
            recordings.push(path);
        } else if tables && path.is_file() {
            let what = recording::unread(&path);
            unread.extend(what.map(|what| (path, what)));
        }
    }
    recordings.sort();
    found.append(&mut recordings);
    folders.sort();
    unread.sort();
    let mut each = folders.iter();
    each.try_for_each(|f| walk(f, tables, found, unread))
}

/// Whether it is a link to a file that is not there: such data are missing, and named as an input that failed.
fn is_dangling(path: &Path) -> bool {
    path.is_symlink() && !path.exists()
}

fn is_table(path: &Path) -> bool {
    // A text of any kind may have such an ending.
    let is_vague = path.extension().is_some_and(|e| {
        ["txt", "dat", "tab"]
            .iter()
            .any(|v| e.eq_ignore_ascii_case(v))
    });
    let kind = Kind::by_name(path).filter(|_| !is_vague);
    // An exported channel duplicates the recording, which is in the folder too.
    let is_made = is_ours(path) || begins(path, &[recording::csv::is_export]);
    matches!(kind, Some(Kind::Table | Kind::Log)) && !is_made
}

/// Whether it is a table written by heft: estimates, loads, or a summary of inputs.
pub fn is_ours(path: &Path) -> bool {
    let ours: [fn(&[u8]) -> bool; 3] = [
        recording::csv::is_estimates,
        view::loads::is_csv,
        is_summary,
    ];
    begins(path, &ours)
}

/// Fails on a table written by heft, which holds no samples.
pub fn check_is_data(path: &Path) -> Result<(), Failure> {
    if !is_ours(path) {
        return Ok(());
    }
    Err(Failure::input(
        "this table is a result of heft",
        path.display(),
        "name the table of sensors that it was made from",
    ))
}

/// Whether one of these recognizes the beginning of a file.
fn begins(path: &Path, kinds: &[fn(&[u8]) -> bool]) -> bool {
    let mut head = Vec::new();
    // Opening a pipe blocks until it has a writer.
    let opened = path.is_file().then(|| std::fs::File::open(path));
    let read = opened.map(|f| f.and_then(|f| f.take(4096).read_to_end(&mut head)));
    matches!(read, Some(Ok(_))) && kinds.iter().any(|is_it| is_it(&head))
}

/// First columns of a table of results.
pub const SUMMARY: &str = "input,result,";

/// Recognizes a table of results by its first bytes.
pub fn is_summary(head: &[u8]) -> bool {
    head.starts_with(SUMMARY.as_bytes())
}

/// A result name beside each input: its name with another ending; with both endings if two inputs would have the same.
pub fn beside(inputs: &[PathBuf], ending: &str) -> Vec<PathBuf> {
    let short: Vec<PathBuf> = inputs.iter().map(|i| i.with_extension(ending)).collect();
    let whole = |input: &PathBuf| {
        let mut name = input.clone().into_os_string();
        name.push(format!(".{ending}"));
        name.into()
    };
    let is_shared = |name: &PathBuf| short.iter().filter(|s| *s == name).count() > 1;
    let choose = |(input, name): (&PathBuf, &PathBuf)| {
        if is_shared(name) {
            whole(input)
        } else {
            name.clone()
        }
    };
    inputs.iter().zip(&short).map(choose).collect()
}

/// Whether a result exists and none of its sources is newer.
pub fn is_newer(result: &Path, sources: &[&Path]) -> bool {
    let Some(made) = recording::changed(result) else {
        return false;
    };
    let is_older = |source: &&Path| recording::changed(source).is_some_and(|at| at <= made);
    sources.iter().all(is_older)
}

/// Runs all jobs; returns their outcomes in the same order.
pub fn run(jobs: &[Job], most: Option<NonZeroUsize>) -> Vec<Outcome> {
    let ended = AtomicUsize::new(0);
    let (children, printed) = (Children::default(), Printed::default());
    if let Err(failure) = end_together(&children) {
        tracing::warn!("a signal would end this process alone: {failure}");
    }
    let results = parallel::map_on(most, jobs.len(), |at| {
        let job = &jobs[at];
        let end = if job.is_done {
            Outcome::Kept
        } else {
            one(job, &children, &printed)
        };
        let count = ended.fetch_add(1, Ordering::Relaxed) + 1;
        if std::io::stderr().is_terminal() {
            let name = Plain(job.input.display());
            out::draw(&format!("\r\x1b[2K{count} of {} {name}", jobs.len()));
        }
        end
    });
    if std::io::stderr().is_terminal() {
        out::draw("\r\x1b[2K");
    }
    results
}

/// Runs a process to its end; it is one of the children meanwhile.
fn output(job: &Job, children: &Children) -> std::io::Result<Output> {
    let mut command = image::command();
    command.args(&job.arguments);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    let lock = || children.lock().unwrap_or_else(PoisonError::into_inner);
    let mut running = lock();
    let child = command.spawn()?;
    let pid = child.id();
    running.insert(pid);
    drop(running);
    let output = child.wait_with_output();
    lock().remove(&pid);
    output
}

fn one(job: &Job, children: &Children, printed: &Printed) -> Outcome {
    match output(job, children) {
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            let (remarks, reason) = last_words(&said);
            tell(&job.input, remarks, printed);
            let reason = reason.map_or_else(|| output.status.to_string(), Into::into);
            if output.status.success() {
                return Outcome::Made;
            }
            match output.status.code() {
                Some(1) => Outcome::No(reason),
                _ => Outcome::Failed(reason),
            }
        }
        Err(error) => Outcome::Failed(error.to_string()),
    }
}

/// Notes that were printed already.
type Printed = Mutex<BTreeSet<String>>;

/// Prints the messages of a process on its input; a note that several processes have in common, once.
fn tell(input: &Path, remarks: &str, printed: &Printed) {
    if !remarks.is_empty() && std::io::stderr().is_terminal() {
        out::draw("\r\x1b[2K");
    }
    let mut printed = printed.lock().unwrap_or_else(PoisonError::into_inner);
    let mut is_new =
        |line: &&str| !line.starts_with("note: ") || printed.insert((*line).to_owned());
    for remark in remarks.lines().filter(|line| is_new(line)) {
        eprintln!("{}: {remark}", OneLine(input.display()));
    }
}

/// The messages of a process, and its failure: the last one that it reported, with all its lines.
fn last_words(said: &str) -> (&str, Option<&str>) {
    const FIRST: &str = "heft: ";
    let from = match said.rfind(&format!("\n{FIRST}")) {
        Some(at) => at + 1,
        None if said.starts_with(FIRST) => 0,
        None => return (said, None),
    };
    (&said[..from], Some(said[from + FIRST.len()..].trim_end()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_failure_is_reported_with_what_to_do() {
        let said = "heft: one\nnote: x\nheft: two\n  where: there\n  what to do: that\n";
        let (remarks, why) = last_words(said);
        assert_eq!(remarks, "heft: one\nnote: x\n");
        assert_eq!(why, Some("two\n  where: there\n  what to do: that"));
        assert_eq!(last_words("heft: one\n"), ("", Some("one")));
        assert_eq!(last_words("note: heft: x\n"), ("note: heft: x\n", None));
    }

    #[test]
    fn a_folder_stands_for_every_recording_and_table_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| {
            let file = folder.path().join(name);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, text).unwrap();
        };
        put("a.csv", "t,swing_velocity\n");
        put("a.estimates.csv", "t,inertia,method\n");
        put("all.csv", "input,result,rows\n");
        put("deeper/run.mcap", "x");
        put("deeper/run.part2.mcap", "x");
        put("deeper/run.recovered.mcap", "x");
        put("deeper/bus.log", "x");
        put("deeper/notes.txt", "x");
        put(".hidden/a.csv", "t\n");
        std::os::unix::fs::symlink("gone.csv", folder.path().join("link.csv")).unwrap();
        let found = inputs(&[folder.path().to_owned()], true).unwrap();
        let names = found.iter().map(|f| f.strip_prefix(folder.path()).unwrap());
        let expected = ["a.csv", "link.csv", "deeper/bus.log", "deeper/run.mcap"];
        assert_eq!(names.collect::<Vec<_>>(), expected.map(Path::new));
        let only = inputs(&[folder.path().to_owned()], false).unwrap();
        assert_eq!(only.len(), 1);
        assert!(inputs(&[folder.path().join("none")], true).is_err());
    }

    #[test]
    fn no_two_results_have_the_same_name() {
        let inputs = ["a.csv", "a.mcap", "b.log"].map(PathBuf::from);
        let expected = ["a.csv.html", "a.mcap.html", "b.html"].map(PathBuf::from);
        assert_eq!(beside(&inputs, "html"), expected);
    }
}
