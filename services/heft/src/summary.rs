//! The summary at the end of a run.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use messages::{Envelope, Machine};
use view::estimate::Estimate;
use view::words::{verdict, wrapped};

use crate::failure::Failure;
use crate::fault::Fault;
use crate::page;
use crate::tally::{Scored, Tally};
use crate::watch::Watch;

/// Columns that every terminal has.
const WIDTH: usize = 80;

/// Writes the HTML report of a recording; `None`, with the reason printed, if that fails.
pub fn report(recording: &Path) -> Option<PathBuf> {
    // run.mcap, report.html; run-2.mcap, report-2.html.
    let name = recording
        .file_stem()?
        .to_string_lossy()
        .replacen("run", "report", 1);
    let path = recording.with_file_name(name + ".html");
    let written = recording::Reader::open(recording)
        .map_err(Into::into)
        .and_then(|reader| page::write(&reader, &path));
    match written {
        Ok(()) => Some(path),
        Err(failure) => {
            eprintln!("no report: {failure}");
            None
        }
    }
}

/// Extent of the summary.
#[derive(Debug, Clone, Copy)]
pub struct Detail {
    /// Loads as a table at the end, instead of the quantities one by one.
    pub is_story: bool,
    /// With statistics of the processes.
    pub is_verbose: bool,
}

/// The last estimate, each quantity, the losses, and the places of recording and report.
pub fn text(
    machine: Machine,
    watch: &Watch,
    recording: &Path,
    report: Option<&Path>,
    detail: Detail,
) -> String {
    let simulated = if watch.is_simulated() {
        " (simulated)"
    } else {
        ""
    };
    let mut out = format!("\n{machine}{simulated}\n");
    let mut line = |text: String| {
        if text.starts_with("  ") {
            // A row of a table.
            let _ = writeln!(out, "{text}");
            return;
        }
        for (i, part) in wrapped(&text, WIDTH - 6).iter().enumerate() {
            let indent = if i == 0 { "  " } else { "      " };
            let _ = writeln!(out, "{indent}{part}");
        }
    };
    if detail.is_story {
        for text in watch.headline().take(1).flat_map(tally_lines) {
            line(text);
        }
    } else {
        for text in watch.headline().flat_map(tally_lines) {
            line(text);
        }
        line(format!("at the end, {}", in_words(watch)));
        let main: Vec<_> = watch.headline().map(|t| t.quantity.channel).collect();
        let others = watch.tallies().iter();
        for tally in others.filter(|t| !main.contains(&t.quantity.channel)) {
            for text in tally_lines(tally) {
                line(format!("for comparison, {text}"));
            }
        }
    }
    if detail.is_verbose {
        tell_processes(watch, &mut line);
    }
    for fault in watch.faults() {
        // Late samples of a demonstration are statistics of the host: no sample was lost.
        let is_statistics = matches!(fault, Fault::Late { .. });
        if is_statistics && detail.is_story && !detail.is_verbose {
            continue;
        }
        line(watch.fault_words(&fault));
    }
    // Paths are not wrapped: users copy them. The folder may have been removed meanwhile.
    if recording::exists(recording) {
        let _ = writeln!(out, "  recording  {}", shown(recording));
    }
    if let Some(report) = report {
        let _ = writeln!(out, "  report     {}", shown(report));
    }
    if detail.is_story {
        tell_story(machine, watch, &mut out);
    }
    out
}

/// The table of loads.
fn tell_story(machine: Machine, watch: &Watch, out: &mut String) {
    let table = watch.story().table(machine);
    for (i, row) in table.lines().enumerate() {
        let indent = if i == 0 { "  " } else { "    " };
        let _ = writeln!(out, "{indent}{row}");
    }
}

/// Latencies and losses of each process.
fn tell_processes(watch: &Watch, line: &mut impl FnMut(String)) {
    for (name, health) in watch
        .processes()
        .all_health()
        .filter(|(_, h)| h.age_max_ns > 0)
    {
        if name == "sensor" {
            continue;
        }
        let counts = watch.processes().counts_of(name);
        line(format!(
            "{name} answers after p50 {:.0}, p99 {:.0}, p99.9 {:.0}, max {:.0} µs; step p50 {:.2} µs; {} samples, {} lost, {} late",
            us(health.age_p50_ns),
            us(health.age_p99_ns),
            us(health.age_p999_ns),
            us(health.age_max_ns),
            us(health.step_p50_ns),
            counts.steps,
            counts.lost,
            counts.late
        ));
    }
}

/// Age of the last trusted estimate, the largest over the headline quantities \[s\]; `None` if one of
/// them never was trusted.
pub fn trust_age(watch: &Watch) -> Option<f64> {
    let headline = watch.headline();
    let ages: Option<Vec<f64>> = headline
        .map(|s| Some(s.latest.time - s.last_trusted?.time))
        .collect();
    ages?.into_iter().reduce(f64::max)
}

/// Largest age of the last trusted value by which an estimate is judged \[s\]: a machine that stands at the end
/// has shown its inertia while it moved.
const TRUST_AGE: f64 = 30.0;

/// The condition of `--require-trust`: a trusted estimate, not too old.
pub fn require_trust(age: Option<f64>) -> Result<(), Failure> {
    match age {
        None => Err(Failure::answer_is_no("no estimate is `trusted`")),
        Some(age) if age > TRUST_AGE => Err(Failure::answer_is_no(format!(
            "the last trusted estimate is {age:.0} s old; at most {TRUST_AGE:.0} s are allowed"
        ))),
        Some(_) => Ok(()),
    }
}

fn us(ns: u64) -> f64 {
    ns as f64 / 1e3
}

/// A path as the user would type it; absolute for a service whose working directory is `/`.
pub fn shown(path: &Path) -> String {
    let here = std::env::current_dir().unwrap_or_default();
    let below = path.strip_prefix(&here).ok();
    below
        .filter(|_| here.parent().is_some())
        .unwrap_or(path)
        .display()
        .to_string()
}

macro_rules! in_words {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The last estimate of the method that was asked for, with the method's name.
        fn in_words(watch: &Watch) -> String {
            match watch.latest_headline() {
                $( Some(Envelope::$estimate(e)) => format!("by {}: {}", e.method_name(), verdict(e)), )*
                _ => "no estimate was made".into(),
            }
        }
    };
}

messages::machines!(in_words);

fn tally_lines(tally: &Tally) -> Vec<String> {
    let q = tally.quantity;
    let name = format!("{} ({})", q.label(), q.channel);
    let mut lines = Vec::new();
    let share = 100.0 * tally.trusted_count as f64 / tally.seen.max(1) as f64;
    match tally.last_trusted {
        None => lines.push(format!("{name}: never trusted in {} estimates", tally.seen)),
        Some(Scored {
            time,
            value,
            std,
            truth,
            ..
        }) => {
            let truth = truth.map_or(String::new(), |t| {
                format!(
                    ", truth {}, error {:+.1} %",
                    q.number(t, std),
                    100.0 * (value / t - 1.0)
                )
            });
            lines.push(format!(
                "{name}: last trusted at {time:.1} s: {} (95 %: {}){truth}; trusted {share:.0} % of the time",
                q.text(value, std),
                view::number::interval_95(value, std)
            ));
        }
    }
    if tally.scored > 0 {
        lines.push(format!(
            "while trusted: rms error {:.1} %, worst {:.1} %, the 95 % interval held the truth {:.0} % of the time",
            (tally.squares / tally.scored as f64).sqrt(),
            tally.worst,
            100.0 * tally.covered as f64 / tally.scored as f64
        ));
    }
    lines
}
