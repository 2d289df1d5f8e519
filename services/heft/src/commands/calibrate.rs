//! `heft calibrate`: the machine's own parameters from recordings, with intervals.

mod each;
mod page;
pub mod told;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{SystemTime, UNIX_EPOCH};

use calibrate::Summary;
use calibrate::fit::Progress;
use clap::Args;
use messages::Machine;
use recording::{Reader, output};

use crate::build::IDENTITY;
use crate::cli::{DescriptionArgs, ManyArgs, machine};
use crate::commands::run::description;
use crate::failure::Failure;
use crate::{machines, results};

/// `heft calibrate`
#[derive(Debug, Args)]
pub struct CalibrateArgs {
    /// The machine
    #[arg(value_parser = machine())]
    pub machine: Machine,
    /// Recordings: .csv, .mcap, .log (candump), or folders of runs
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Every folder that is named holds the recordings of one machine; calibrated.toml and calibrated.html are written there
    #[arg(long, conflicts_with_all = ["output", "report"])]
    pub each: bool,
    /// With --each: also write the results of all as one table (CSV)
    #[arg(long, value_name = "FILE", requires = "each")]
    pub summary: Option<PathBuf>,
    /// How many machines are treated
    #[command(flatten)]
    pub many: ManyArgs,
    /// Load in the bucket in a recording of an excavator, as weighed
    #[arg(long, value_name = "FILE=KG±KG")]
    pub payload: Vec<String>,
    /// Mass of the whole machine in a recording of a loader, as weighed
    #[arg(long, value_name = "FILE=KG±KG")]
    pub mass: Vec<String>,
    /// Axle scales of a loader (as for heft weigh): of the machine without load, or in a recording
    #[arg(long, value_name = "[FILE=]SCALES.csv")]
    pub weigh: Vec<String>,
    /// Two recordings of a loader go the same way, the second back with the machine turned round
    #[arg(long, value_name = "FILE,FILE")]
    pub there_and_back: Vec<String>,
    /// Find these keys only
    #[arg(long, value_name = "KEY,...", value_delimiter = ',')]
    pub free: Vec<String>,
    /// Signal map (TOML)
    #[arg(long)]
    pub map: Option<PathBuf>,
    /// The machine's description
    #[command(flatten)]
    pub description: DescriptionArgs,
    /// Description to write (TOML)
    #[arg(
        short,
        long,
        value_name = "DESCRIPTION",
        required_unless_present = "each"
    )]
    pub output: Option<PathBuf>,
    /// Also write an HTML report
    #[arg(long, value_name = "R.html")]
    pub report: Option<PathBuf>,
    /// Write the description even if something speaks against it
    #[arg(long)]
    pub accept: bool,
}

/// `heft calibrate`
pub fn calibrate(args: &CalibrateArgs) -> Result<(), Failure> {
    if args.each {
        return each::calibrate(args);
    }
    check_outputs(args)?;
    let description = description(args.machine, &args.description)?;
    machines::entry(args.machine).calibrate(args, &description)
}

pub fn unknown_key(e: String) -> Failure {
    Failure::input(
        e,
        "--free",
        "name keys that can be found, separated by commas",
    )
}

const DOING: &str = "write the description";
/// How the first line of a calibrated description begins.
const FIRST_WORDS: &str = "# Calibrated by heft ";

fn is_ours(head: &[u8]) -> bool {
    head.starts_with(FIRST_WORDS.as_bytes())
}

fn output_of(args: &CalibrateArgs) -> Result<&Path, Failure> {
    let missing = || {
        Failure::input(
            "no name for the description",
            "--output",
            "give one: -o machine.toml",
        )
    };
    args.output.as_deref().ok_or_else(missing)
}

/// What is read, and must not be written over.
fn taken(args: &CalibrateArgs) -> Vec<&Path> {
    let scales = args.weigh.iter().map(|w| told::scales(w).1);
    let files = args.files.iter().map(PathBuf::as_path);
    let others = [args.map.as_deref(), args.description.config.as_deref()];
    files
        .chain(scales)
        .chain(others.into_iter().flatten())
        .collect()
}

/// Refuses before the work what could not be written after it.
fn check_outputs(args: &CalibrateArgs) -> Result<(), Failure> {
    let mut taken = taken(args);
    let description = output_of(args)?;
    output::check(description, &taken, is_ours)?;
    taken.push(description);
    if let Some(report) = &args.report {
        output::check(report, &taken, page::is_ours)?;
        if report == description {
            return Err(Failure::input(
                "description and page have the same name",
                report.display(),
                "choose another name for one of them",
            ));
        }
    }
    Ok(())
}

/// Tells what was found, and writes the description where it may be believed, or the user insists.
pub fn finish(
    args: &CalibrateArgs,
    summary: &Summary<'_>,
    written: Option<String>,
) -> Result<(), Failure> {
    print!("{}", text(summary));
    let taken = taken(args);
    if let Some(report) = &args.report {
        let page = page::page(summary);
        results::text("write the page", report, &taken, page::is_ours, &page)?;
        println!("report in {}", report.display());
    }
    let sure = summary.faults.is_empty();
    match written {
        Some(text) if sure || args.accept => {
            let output = output_of(args)?;
            results::text(DOING, output, &taken, is_ours, &text)?;
            println!("description in {}", output.display());
        }
        Some(_) | None => println!("no description written"),
    }
    if sure || (args.accept && summary.found.is_some()) {
        return Ok(());
    }
    Err(Failure::answer_is_no(format!(
        "{}\n  where: {}\n  what to do: record what is missing, or take the rest with --accept",
        summary.faults.join("\n"),
        summary.recordings.join(", ")
    )))
}

/// What a terminal shows of the result.
fn text(summary: &Summary<'_>) -> String {
    let mut out = String::new();
    for remark in summary.remarks {
        out += &format!("note: {remark}\n");
    }
    let Some(found) = summary.found else {
        return out;
    };
    let parameters = summary.model.parameters();
    let width = parameters
        .iter()
        .map(|p| p.words.chars().count())
        .max()
        .unwrap_or(0);
    for (i, p) in parameters.iter().enumerate() {
        let Some(q) = summary.quantity(i) else {
            continue;
        };
        let held = if summary.fixed[i] { "  (held)" } else { "" };
        out += &format!("{:<width$} {}{held}\n", p.words, page::figure(q, p.unit));
    }
    let [before, after] = &found.unseen;
    out += &format!(
        "on what took no part in the fit: squared innovations {:.2} of the expected ({:.2} as described), {:.1} % inside the 95 % interval ({:.1} %)\n",
        after.nis,
        before.nis,
        100.0 * after.covered,
        100.0 * before.covered
    );
    out += &format!(
        "intervals widened {:.2} times by the scatter from {} to {}\n",
        found.uncertainty.widened, summary.block, summary.block
    );
    out
}

fn is_recording(file: &Path) -> bool {
    file.is_dir() || file.extension().is_some_and(|e| e == "mcap")
}

/// A recording of heft takes no signal map.
pub fn map_for<'a>(file: &Path, map: Option<&'a recording::Map>) -> Option<&'a recording::Map> {
    map.filter(|_| !is_recording(file))
}

/// What the recordings are called in sentences: the ends of their paths, as long as it takes to tell them apart.
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

pub fn interrupt() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(Failure::internal)?;
    }
    Ok(stop)
}

pub fn tell_progress(progress: Progress) {
    use std::io::IsTerminal;
    if std::io::stderr().is_terminal() {
        eprint!("\rstep {:<3} cost {:<16.3}", progress.step, progress.cost);
    }
}

/// Where the numbers come from: version, date, files with their hashes.
pub fn origin(args: &CalibrateArgs) -> Result<Vec<String>, Failure> {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let mut lines = vec![format!(
        "Calibrated by heft {IDENTITY} on {} from",
        recording::date_and_time(now.map_or(0, |since| since.as_secs()))
    )];
    for file in &args.files {
        let reader = is_recording(file).then(|| Reader::open(file)).transpose()?;
        let parts: Vec<&Path> = match &reader {
            Some(reader) => reader.files().collect(),
            None => vec![file],
        };
        for part in parts {
            let bytes = std::fs::read(part).map_err(|e| Failure::file("read", part, &e))?;
            let hash = recording::sha256(&bytes);
            lines.push(format!("  {}  sha256 {hash}", part.display()));
        }
    }
    let told = [
        ("--payload", &args.payload),
        ("--mass", &args.mass),
        ("--weigh", &args.weigh),
        ("--there-and-back", &args.there_and_back),
    ];
    let told = told
        .iter()
        .flat_map(|(option, given)| given.iter().map(move |g| format!("{option}={g}")));
    let all: Vec<String> = options(args).into_iter().chain(told).collect();
    lines.push(asked(&all));
    Ok(lines)
}

/// Options that decide what comes out, beside what is told of the recordings.
fn options(args: &CalibrateArgs) -> Vec<String> {
    let mut all = Vec::new();
    let mut option = |name: &str, value: &str| all.push(format!("{name}={value}"));
    if let Some(map) = &args.map {
        option("--map", &map.display().to_string());
    }
    if let Some(config) = &args.description.config {
        option("--config", &config.display().to_string());
    }
    for set in &args.description.set {
        option("--set", set);
    }
    if !args.free.is_empty() {
        option("--free", &args.free.join(","));
    }
    all.extend(args.accept.then(|| "--accept".to_owned()));
    all
}

/// A line of the result that says what was asked for.
fn asked(options: &[String]) -> String {
    format!("  asked: {}", options.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_are_called_as_shortly_as_tells_them_apart() {
        let of = |files: &[&str]| names(&files.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["x/a.csv", "y/b.csv"]), ["a.csv", "b.csv"]);
        assert_eq!(
            of(&["s/e/run.mcap", "s/f/run.mcap"]),
            ["e/run.mcap", "f/run.mcap"]
        );
        assert_eq!(of(&["a.csv", "a.csv"]), ["a.csv", "a.csv"]);
    }
}
