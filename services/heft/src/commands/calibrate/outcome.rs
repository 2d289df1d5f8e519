//! Prints the result of a calibration, and writes it if it is accepted.

use std::io::Read;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use calibrate::Summary;
use calibrate::fit::Progress;
use recording::output;

use super::args::CalibrateArgs;
use super::{page, stated};
use crate::failure::Failure;
use crate::results;

pub fn unknown_key(e: String) -> Failure {
    Failure::input(
        e,
        "--free",
        "name keys that can be found, separated by commas",
    )
}

/// Set by the first interruption; a second one ends the command at once: one step of a long recording lasts minutes.
pub fn interrupt() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let (mut hears, rings) = UnixStream::pair().map_err(Failure::internal)?;
    let body = move || {
        if hears.read_exact(&mut [0]).is_ok() {
            eprintln!(
                "stopping after this step, with the best so far; a second interruption ends it at once"
            );
        }
    };
    let thread = std::thread::Builder::new();
    thread.spawn(body).map_err(Failure::thread)?;
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        let again = Arc::clone(&stop);
        signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, again)
            .map_err(Failure::internal)?;
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(Failure::internal)?;
        let ring = rings.try_clone().map_err(Failure::internal)?;
        signal_hook::low_level::pipe::register(signal, ring).map_err(Failure::internal)?;
    }
    Ok(stop)
}

pub fn tell_progress(progress: Progress) {
    use std::io::IsTerminal;
    if std::io::stderr().is_terminal() {
        crate::out::draw(&format!(
            "\rstep {:<3} cost {:<16.3}",
            progress.step, progress.cost
        ));
    }
}

const DOING: &str = "write the machine file";
/// First words of a calibrated description.
const FIRST_WORDS: &str = "# Calibrated by heft ";

fn is_ours(head: &[u8]) -> bool {
    head.starts_with(FIRST_WORDS.as_bytes())
}

fn output_of(args: &CalibrateArgs) -> Result<&Path, Failure> {
    let missing = || {
        Failure::input(
            "no name for the machine file",
            "--output",
            "give one: -o machine.toml",
        )
    };
    args.output.as_deref().ok_or_else(missing)
}

/// The inputs, which must not be overwritten.
fn taken(args: &CalibrateArgs) -> Vec<&Path> {
    let scales = args.weigh.iter().map(|w| stated::scales(w).1);
    let files = args.files.iter().map(PathBuf::as_path);
    let others = [args.map.as_deref(), args.description.config.as_deref()];
    files
        .chain(scales)
        .chain(others.into_iter().flatten())
        .collect()
}

/// Refuses, before the calibration, outputs that could not be written after it.
pub(super) fn check_outputs(args: &CalibrateArgs) -> Result<(), Failure> {
    let mut taken = taken(args);
    let description = output_of(args)?;
    output::check(description, &taken, is_ours)?;
    taken.push(description);
    if let Some(report) = &args.report {
        output::check(report, &taken, page::is_ours)?;
        if report == description {
            return Err(Failure::input(
                "machine file and page have the same name",
                report.display(),
                "choose another name for one of them",
            ));
        }
    }
    Ok(())
}

/// Prints the result, and writes the description if it is accepted or the user insists.
pub fn finish(
    args: &CalibrateArgs,
    summary: &Summary<'_>,
    written: Option<String>,
) -> Result<(), Failure> {
    // Files first: the reader of the terminal may leave early.
    let files = write(args, summary, written);
    print!("{}{}", text(summary), files.as_deref().unwrap_or_default());
    files?;
    let sure = summary.faults.is_empty();
    if sure || (args.accept && summary.found.is_some()) {
        return Ok(());
    }
    Err(Failure::answer_is_no(format!(
        "{}\n  where: {}\n  what to do: record what is missing, or take the rest with --accept",
        summary.faults.join("\n"),
        summary.recordings.join(", ")
    )))
}

/// Writes the requested files; returns their places.
fn write(
    args: &CalibrateArgs,
    summary: &Summary<'_>,
    written: Option<String>,
) -> Result<String, Failure> {
    let taken = taken(args);
    let mut places = String::new();
    if let Some(report) = &args.report {
        let page = page::page(summary);
        results::text("write the page", report, &taken, page::is_ours, &page)?;
        places += &format!("report in {}\n", report.display());
    }
    match written {
        Some(text) if summary.faults.is_empty() || args.accept => {
            let output = output_of(args)?;
            results::text(DOING, output, &taken, is_ours, &text)?;
            places += &format!("machine file in {}\n", output.display());
        }
        Some(_) | None => places += "no machine file written\n",
    }
    Ok(places)
}

/// The result as text for a terminal.
fn text(summary: &Summary<'_>) -> String {
    let mut out = String::new();
    for remark in summary.remarks {
        out += &format!("note: {remark}\n");
    }
    let Some(found) = summary.found else {
        return out;
    };
    out += "found, ± one standard deviation:\n";
    let parameters = summary.model.parameters();
    let width = parameters
        .iter()
        .map(|p| p.words.chars().count())
        .max()
        .unwrap_or(0);
    let sum = summary.model.sum();
    for (i, p) in parameters.iter().enumerate() {
        let of_sum = sum.as_ref().filter(|(shares, _)| shares.contains(&i));
        let (words, quantity) = match of_sum {
            Some((shares, _)) if i != shares.start => continue,
            Some((shares, words)) => (*words, summary.sum(shares.clone())),
            None => (p.words.as_str(), summary.quantity(i)),
        };
        let Some(q) = quantity else {
            continue;
        };
        let held = if summary.fixed[i] {
            "  (of the machine file)"
        } else {
            ""
        };
        out += &format!("  {words:<width$} {}{held}\n", page::figure(q, p.unit));
    }
    let [before, after] = &found.unseen;
    out += &format!(
        "check on every fourth {}, left out of the fit: squared residuals {:.2} times the predicted (1 is right; {:.2} before), {:.1} % inside their 95 % interval ({:.1} % before)\n",
        summary.block,
        after.nis,
        before.nis,
        100.0 * after.covered,
        100.0 * before.covered
    );
    out += &format!(
        "the standard deviations were widened {:.2} times, by the scatter from {} to {}\n",
        found.uncertainty.widened, summary.block, summary.block
    );
    out
}
