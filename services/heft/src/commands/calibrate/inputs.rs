//! The recordings of a calibration: their samples, their names, and their hashes in the result.

use std::path::{Path, PathBuf};

use messages::Value;
use recording::measurable::{self, Measured};
use recording::{Reader, Sensors};

use super::args::CalibrateArgs;
use crate::args::is_of_heft;
use crate::build::IDENTITY;
use crate::failure::Failure;

/// The signal map of a recording; one of heft needs none.
fn map_for<'a>(file: &Path, map: Option<&'a recording::Map>) -> Option<&'a recording::Map> {
    map.filter(|_| !is_of_heft(file))
}

/// Largest number that is a time, since 1970 or since a start \[s\]: 30 000 years.
const DATABLE: f64 = 1e12;
/// Largest time between two rows: above it they do not show the motion \[s\].
const FARTHEST: f64 = 2.0;

/// The samples of a recording, without values beyond the range of any sensor.
///
/// # Errors
/// It cannot be read, or its rows are too far apart.
pub fn samples<S: Sensors>(
    file: &Path,
    map: Option<&recording::Map>,
    rate: f64,
) -> Result<Vec<S>, Failure> {
    let rows = recording::load::<S>(file, map_for(file, map))?;
    let mut samples: Vec<S> = rows.into_iter().map(|(sample, _)| sample).collect();
    // Milliseconds since 1970 are beyond the range of times, and named.
    check_steps(file, &samples, rate)?;
    let measured = measurable::measured::<S>(|_| None);
    let left_out: usize = samples.iter_mut().map(|s| leave_out(s, &measured)).sum();
    if left_out > 0 {
        let file = file.display();
        eprintln!("{file}: {left_out} numbers are larger than any measurement and were left out");
    }
    Ok(samples)
}

/// Removes values beyond the range of any sensor; returns their number.
fn leave_out<S: Sensors>(sample: &mut S, measured: &[Measured]) -> usize {
    let beyond = measurable::beyond(sample, measured);
    if let Some(index) = S::index("valid") {
        let valid = sample.bits_of("valid") & !beyond;
        sample.set(index, Value::U32(valid));
    }
    let time = &mut sample.stamp_mut().time;
    let is_timed = !time.is_finite() || time.abs() <= DATABLE;
    if !is_timed {
        *time = f64::NAN;
    }
    beyond.count_ones() as usize + usize::from(!is_timed)
}

/// Refuses rows so far apart that the motion between them is unknown.
fn check_steps<S: Sensors>(file: &Path, samples: &[S], rate: f64) -> Result<(), Failure> {
    let times: Vec<f64> = samples.iter().map(|s| s.stamp().time).collect();
    let is_far = |step: &f64| *step > FARTHEST && *step < DATABLE;
    let Some(step) = recording::usual_step(&times).filter(is_far) else {
        return Ok(());
    };
    let unit = recording::time_unit(&times, rate).map_or("ms", |(_, unit)| unit);
    Err(Failure::input(
        format!("the rows are {step} s apart: too far to see a machine move"),
        file.display(),
        format!(
            "record faster; or is the time in {unit}? write t = {{ column = \"t\", unit = \"{unit}\" }} in a signal map"
        ),
    ))
}

/// Refuses a recording that is named twice: it would count as two consistent ones, and narrow the intervals.
pub fn check_distinct(files: &[PathBuf]) -> Result<(), Failure> {
    let mut seen = std::collections::BTreeSet::new();
    let mut places = files
        .iter()
        .map(|f| (f, f.canonicalize().unwrap_or_else(|_| f.clone())));
    match places.find(|(_, place)| !seen.insert(place.clone())) {
        None => Ok(()),
        Some((file, _)) => Err(Failure::input(
            "this recording is named twice",
            file.display(),
            "name each recording once",
        )),
    }
}

/// Names of the recordings in sentences: the ends of their paths, as long as needed to distinguish them.
pub fn names(files: &[PathBuf]) -> Vec<String> {
    let end = |file: &PathBuf, parts: usize| -> String {
        let all: Vec<_> = file.components().collect();
        let last: PathBuf = all[all.len().saturating_sub(parts)..].iter().collect();
        last.display().to_string()
    };
    let longest = files.iter().map(|f| f.components().count()).max();
    let called = |parts| files.iter().map(|f| end(f, parts)).collect::<Vec<_>>();
    let is_clear = |names: &Vec<String>| {
        let distinct: std::collections::BTreeSet<_> = names.iter().collect();
        distinct.len() == names.len()
    };
    let longest = longest.unwrap_or(1);
    let mut tried = (1..longest).map(called);
    tried.find(is_clear).unwrap_or_else(|| called(longest))
}

/// Origin of the numbers: version, date, files with their hashes.
pub fn origin(args: &CalibrateArgs) -> Result<Vec<String>, Failure> {
    let mut lines = vec![format!(
        "Calibrated by heft {IDENTITY} on {} from",
        recording::date_and_time(runtime::since_1970().as_secs())
    )];
    lines.extend(hashes(&args.files)?);
    let stated = [
        ("--payload", &args.payload),
        ("--mass", &args.mass),
        ("--weigh", &args.weigh),
        ("--out-and-back", &args.there_and_back),
    ];
    let stated = stated
        .iter()
        .flat_map(|(option, given)| given.iter().map(move |g| format!("{option}={g}")));
    let all: Vec<String> = options(args).into_iter().chain(stated).collect();
    lines.push(asked(&all));
    Ok(lines)
}

/// A line for each recording, with its hash.
fn hashes(files: &[PathBuf]) -> Result<Vec<String>, Failure> {
    let mut lines = Vec::new();
    for file in files {
        let reader = recording::Kind::is_recording(file)
            .then(|| Reader::open(file))
            .transpose()?;
        let parts: Vec<&Path> = match &reader {
            Some(reader) => reader.files().collect(),
            None => vec![file],
        };
        for part in parts {
            let bytes = std::fs::read(part).map_err(|e| Failure::file("read", part, &e))?;
            let hash = recording::sha256(&bytes);
            lines.push(format!("  {}{HASH}{hash}", part.display()));
        }
    }
    Ok(lines)
}

/// Text between a recording and its hash in a result.
const HASH: &str = "  sha256 ";

/// Whether a result is of this version, these recordings and these options.
pub(super) fn is_result_of(result: &str, files: &[PathBuf], options: &[String]) -> bool {
    let Ok(hashes) = hashes(files) else {
        return false;
    };
    let said: Vec<&str> = result
        .lines()
        .filter_map(|line| line.strip_prefix('#'))
        .map(|line| line.strip_prefix(' ').unwrap_or(line))
        .collect();
    let asked = asked(options);
    let recordings = said.iter().filter(|line| line.contains(HASH));
    recordings.copied().eq(&hashes)
        && said.contains(&asked.as_str())
        && said.iter().any(|line| line.contains(IDENTITY))
}

/// Options that change the result, beside statements on the recordings.
pub(super) fn options(args: &CalibrateArgs) -> Vec<String> {
    let map = args
        .map
        .iter()
        .map(|map| format!("--map={}", map.display()));
    let described = args.description.again().into_iter();
    let described = described.map(|option| option.to_string_lossy().into_owned());
    let free = (!args.free.is_empty()).then(|| format!("--free={}", args.free.join(",")));
    let accept = args.accept.then(|| "--accept".to_owned());
    map.chain(described).chain(free).chain(accept).collect()
}

/// The line of the result that contains the options.
pub(super) fn asked(options: &[String]) -> String {
    format!("  asked: {}", options.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_of_its_recordings_and_of_all_that_was_asked_and_of_no_more() {
        let folder = tempfile::tempdir().expect("a folder");
        let [a, b] = ["a.csv", "b.csv"].map(|name| folder.path().join(name));
        for file in [&a, &b] {
            std::fs::write(file, "t\n1\n").expect("a file");
        }
        let option = |text: &str| text.to_owned();
        let asked_for = [option("--class=21t"), option("--payload=b.csv=500")];
        let files = [a, b];
        let mut lines = vec![format!("Calibrated by heft {IDENTITY} on a day from")];
        lines.extend(hashes(&files).expect("they are there"));
        lines.push(asked(&asked_for));
        let result: String = lines.iter().map(|line| format!("# {line}\n")).collect();
        assert!(is_result_of(&result, &files, &asked_for));
        assert!(!is_result_of(&result, &files, &asked_for[..1]));
        assert!(!is_result_of(&result, &files[..1], &asked_for));
        std::fs::write(&files[1], "t\n2\n").expect("a file");
        assert!(!is_result_of(&result, &files, &asked_for));
    }

    #[test]
    fn recordings_get_the_shortest_names_that_distinguish_them() {
        let of = |files: &[&str]| names(&files.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["x/a.csv", "y/b.csv"]), ["a.csv", "b.csv"]);
        assert_eq!(
            of(&["s/e/run.mcap", "s/f/run.mcap"]),
            ["e/run.mcap", "f/run.mcap"]
        );
        assert_eq!(of(&["a.csv", "a.csv"]), ["a.csv", "a.csv"]);
    }

    #[test]
    fn the_size_of_the_machine_is_among_the_options_of_each() {
        use clap::Parser;
        let words = "heft calibrate excavator a --each --class 21.5t --set sensors.rate=50";
        let cli = crate::commands::Cli::parse_from(words.split(' '));
        let Some(crate::commands::Command::Calibrate(args)) = cli.command else {
            panic!("calibrate");
        };
        let all = options(&args);
        assert_eq!(all, ["--class=21500kg", "--set=sensors.rate=50"]);
    }
}
