//! `heft calibrate`: the machine's own parameters from recordings, with intervals.

mod page;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{SystemTime, UNIX_EPOCH};

use calibrate::Summary;
use calibrate::fit::Progress;
use estimation::Quantity;

use crate::cli::CalibrateArgs;
use crate::commands::run::description;
use crate::failure::Failure;
use crate::machines;

/// `heft calibrate`
pub fn calibrate(args: &CalibrateArgs) -> Result<(), Failure> {
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

/// Tells what was found, and writes the description where it may be believed, or the user insists.
pub fn finish(
    args: &CalibrateArgs,
    summary: &Summary<'_>,
    written: Option<String>,
) -> Result<(), Failure> {
    print!("{}", text(summary));
    if let Some(report) = &args.report {
        std::fs::write(report, page::page(summary))
            .map_err(|e| Failure::file("write", report, &e))?;
        println!("report in {}", report.display());
    }
    let sure = summary.faults.is_empty();
    match written {
        Some(text) if sure || args.accept => {
            std::fs::write(&args.output, text)
                .map_err(|e| Failure::file("write", &args.output, &e))?;
            println!("description in {}", args.output.display());
        }
        _ => println!("no description written"),
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
    for (i, p) in summary.model.parameters().iter().enumerate() {
        let Some(q) = summary.quantity(i) else {
            continue;
        };
        let held = if summary.fixed[i] { "  (held)" } else { "" };
        out += &format!("{:<44} {}{held}\n", p.words, page::figure(q, p.unit));
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

/// The load of each file: `FILE=KG`, `FILE=KG±KG` or `FILE=KG+-KG`.
pub fn told(
    args: &CalibrateArgs,
    given: &[String],
    option: &str,
) -> Result<Vec<Option<Quantity>>, Failure> {
    let mut loads = vec![None; args.files.len()];
    for text in given {
        let bad = |what: String| {
            Failure::input(
                what,
                format!("{option} {text}"),
                format!("write it like {option} loaded.mcap=423±2"),
            )
        };
        let Some((file, load)) = text.rsplit_once('=') else {
            return Err(bad("no = between file and mass".into()));
        };
        let at = position(args, file, option, text)?;
        loads[at] = Some(quantity(load).ok_or_else(|| bad(format!("{load} is no mass")))?);
    }
    Ok(loads)
}

/// Which recording is meant.
pub fn position(
    args: &CalibrateArgs,
    file: &str,
    option: &str,
    text: &str,
) -> Result<usize, Failure> {
    let is_meant = |f: &PathBuf| f == Path::new(file) || name(f) == file;
    args.files.iter().position(is_meant).ok_or_else(|| {
        Failure::input(
            format!("{file} is none of the recordings"),
            format!("{option} {text}"),
            "name one of them, with or without its folder",
        )
    })
}

/// A mass with its accuracy, both not negative.
fn quantity(text: &str) -> Option<Quantity> {
    let (value, std) = text
        .split_once('±')
        .or_else(|| text.split_once("+-"))
        .unwrap_or((text, "0"));
    let number = |t: &str| {
        t.trim()
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite() && *v >= 0.0)
    };
    Some(Quantity {
        value: number(value)?,
        std: number(std)?,
    })
}

/// A recording of heft takes no signal map.
pub fn map_for<'a>(file: &Path, map: Option<&'a recording::Map>) -> Option<&'a recording::Map> {
    map.filter(|_| file.extension().is_none_or(|e| e != "mcap"))
}

pub fn name(file: &Path) -> String {
    file.file_name().map_or_else(
        || file.display().to_string(),
        |n| n.to_string_lossy().into_owned(),
    )
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
    let mut lines = vec![format!(
        "Calibrated by heft {} on {} from",
        env!("CARGO_PKG_VERSION"),
        date(SystemTime::now())
    )];
    for file in &args.files {
        let bytes = std::fs::read(file).map_err(|e| Failure::file("read", file, &e))?;
        lines.push(format!(
            "  {}  sha256 {}",
            file.display(),
            recording::sha256(&bytes)
        ));
    }
    let loads = args.payload.iter().chain(&args.mass).chain(&args.weigh);
    lines.extend(loads.map(|l| format!("  told: {}", short(l))));
    if let Some(config) = &args.description.config {
        lines.push(format!("  description before: {}", name(config)));
    }
    Ok(lines)
}

fn short(load: &str) -> String {
    match load.rsplit_once('=') {
        Some((file, mass)) => format!("{} = {mass}", name(&PathBuf::from(file))),
        None => name(&PathBuf::from(load)),
    }
}

/// The day in UTC, as 2026-11-21 (days to civil, Hinnant 2013).
fn date(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let days = i64::try_from(seconds / 86_400).unwrap_or(0) + 719_468;
    let era = days.div_euclid(146_097);
    let day_of_era = days.rem_euclid(146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 {
        shifted + 3
    } else {
        shifted - 9
    };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_load_is_read_in_three_ways() {
        let load = |value, std| Some(Quantity { value, std });
        assert_eq!(quantity("423"), load(423.0, 0.0));
        assert_eq!(quantity("423±2"), load(423.0, 2.0));
        assert_eq!(quantity("423.5 +- 2"), load(423.5, 2.0));
        for bad in ["", "x", "-1", "1±x", "nan", "1±-2"] {
            assert_eq!(quantity(bad), None, "{bad}");
        }
    }

    #[test]
    fn days_are_those_of_the_calendar() {
        for (days, day) in [
            (0, "1970-01-01"),
            (11_016, "2000-02-29"),
            (20_778, "2026-11-21"),
        ] {
            assert_eq!(
                date(UNIX_EPOCH + Duration::from_secs(days * 86_400 + 5)),
                day
            );
        }
    }
}
