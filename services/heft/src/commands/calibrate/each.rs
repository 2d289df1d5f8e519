//! Many machines in one command: every folder contains the recordings of one, gets its result, and a table compares them.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use calibrate::output::found;
use estimation::Quantity;
use evaluate::text::Table;
use view::number;

use super::args::CalibrateArgs;
use super::inputs;
use super::stated::scales;
use crate::failure::Failure;
use crate::many::{self, Job, Outcome};
use crate::results;

/// Names of the results in a folder.
const DESCRIPTION: &str = "calibrated.toml";
const PAGE: &str = "calibrated.html";

/// Calibrates each machine in a process of its own.
pub fn calibrate(args: &CalibrateArgs) -> Result<(), Failure> {
    if let Some(summary) = &args.summary {
        recording::output::check(summary, &[], many::is_summary)?;
    }
    let folders = &args.files;
    let jobs = folders.iter().map(|folder| job(args, folder));
    let jobs = jobs.collect::<Result<Vec<Job>, Failure>>()?;
    let ends = many::run(&jobs, args.many.jobs);
    let machines: Vec<Machine> = folders.iter().zip(&ends).map(Machine::of).collect();
    print!("{}", terminal(&machines));
    if let Some(file) = &args.summary {
        let table = csv(&machines);
        results::text("write the summary", file, &[], many::is_summary, &table)?;
        println!("{} machines in {}", machines.len(), file.display());
    }
    many::judge(&ends)
}

fn job(args: &CalibrateArgs, folder: &Path) -> Result<Job, Failure> {
    if !folder.is_dir() {
        return Err(Failure::input(
            "with --each every machine has a folder, and this is none",
            folder.display(),
            "put the recordings of each machine into a folder of its own",
        ));
    }
    let weights: Vec<&Path> = args.weigh.iter().map(|w| scales(w).1).collect();
    let is_scales = |file: &PathBuf| weights.iter().any(|w| file.ends_with(w));
    let mut files = many::inputs(&[folder.to_owned()], true)?;
    files.retain(|file| !is_scales(file));
    let options = options(args, folder);
    let description = folder.join(DESCRIPTION);
    let mut arguments: Vec<OsString> = vec!["calibrate".into(), args.machine.name().into()];
    arguments.extend(options.iter().map(OsString::from));
    arguments.extend(["--output".into(), description.clone().into()]);
    arguments.extend(["--report".into(), folder.join(PAGE).into()]);
    arguments.push("--".into());
    arguments.extend(files.iter().map(OsString::from));
    let others = [args.map.as_deref(), args.description.config.as_deref()];
    let sources = files.iter().map(PathBuf::as_path).chain(weights);
    let sources: Vec<&Path> = sources.chain(others.into_iter().flatten()).collect();
    let is_done = !args.many.again
        && many::is_newer(&description, &sources)
        && std::fs::read_to_string(&description)
            .is_ok_and(|text| inputs::is_result_of(&text, &files, &options));
    Ok(Job {
        input: folder.to_owned(),
        arguments,
        is_done,
    })
}

/// The options of a machine. A name with a folder applies to that machine only, a name without to every machine.
fn options(args: &CalibrateArgs, folder: &Path) -> Vec<String> {
    let is_meant = |file: &str| {
        let parent = Path::new(file).parent().unwrap_or(Path::new(""));
        parent == Path::new("") || parent.starts_with(folder)
    };
    let file = |text: &str| {
        text.rsplit_once('=')
            .map_or("", |(file, _)| file)
            .to_owned()
    };
    let is_here = |text: &&String| is_meant(&file(text));
    let mut all = inputs::options(args);
    for (name, stated) in [("--payload", &args.payload), ("--mass", &args.mass)] {
        let here: Vec<String> = stated.iter().filter(is_here).map(|t| file(t)).collect();
        // A statement on this machine's file replaces one on all files of that name.
        let is_said_closer = |text: &&String| {
            let (name, mut here) = (file(text), here.iter());
            here.any(|other| other.len() > name.len() && Path::new(other).ends_with(&name))
        };
        let mut own: Vec<&String> = stated.iter().filter(is_here).collect();
        own.retain(|text| !is_said_closer(text));
        all.extend(own.iter().map(|text| format!("{name}={text}")));
    }
    // Scales of this name in the folder of the machine, else the named file.
    all.extend(args.weigh.iter().filter(is_here).map(|text| {
        let (file, named) = scales(text);
        let own = folder.join(named);
        let place = if own.exists() { &own } else { named };
        let file = file.map_or(String::new(), |f| format!("{f}="));
        format!("--weigh={file}{}", place.display())
    }));
    let pairs = args.there_and_back.iter();
    let own_pairs = pairs.filter(|text| text.split(',').all(is_meant));
    all.extend(own_pairs.map(|text| format!("--out-and-back={text}")));
    all
}

/// Result of a machine.
struct Machine {
    folder: PathBuf,
    end: String,
    found: BTreeMap<String, Quantity>,
}

impl Machine {
    fn of((folder, end): (&PathBuf, &Outcome)) -> Self {
        let text = match end {
            Outcome::Kept | Outcome::Made => std::fs::read_to_string(folder.join(DESCRIPTION)).ok(),
            // The file in the folder is of an earlier run.
            Outcome::No(_) | Outcome::Failed(_) => None,
        };
        Self {
            folder: folder.clone(),
            end: end.word().into(),
            found: text.map_or_else(BTreeMap::new, |t| found(&t).into_iter().collect()),
        }
    }
}

fn keys(machines: &[Machine]) -> Vec<&str> {
    let all = machines.iter().flat_map(|m| m.found.keys());
    let distinct: std::collections::BTreeSet<&String> = all.collect();
    distinct.into_iter().map(String::as_str).collect()
}

/// The result of each machine, then each parameter over all of them, and the outliers.
fn terminal(machines: &[Machine]) -> String {
    let mut results = Table::new(&["machine", "result"]);
    for m in machines {
        results.row([m.folder.display().to_string(), m.end.clone()]);
    }
    let mut parameters = Table::new(&["parameter", "smallest", "median", "largest", "stands out"]);
    for key in keys(machines) {
        let with = machines.iter().filter_map(|m| Some((m, m.found.get(key)?)));
        let with: Vec<(&Machine, &Quantity)> = with.collect();
        let mut values: Vec<f64> = with.iter().map(|(_, q)| q.value).collect();
        values.sort_by(f64::total_cmp);
        let stds: Vec<f64> = with.iter().map(|(_, q)| q.std).collect();
        let places = number::decimals(statistics::median(&stds));
        let middle = statistics::median(&values);
        let shown = [values.first(), Some(&middle), values.last()];
        let shown = shown.map(|v| v.map_or(String::new(), |v| number::grouped(*v, places)));
        let [smallest, middle, largest] = shown;
        parameters.row([key.to_owned(), smallest, middle, largest, odd(&with)]);
    }
    format!("{results}{parameters}")
}

/// The machines that are outliers.
fn odd(machines: &[(&Machine, &Quantity)]) -> String {
    let values: Vec<_> = machines.iter().map(|(_, q)| (q.value, q.std)).collect();
    let Some(standing) = statistics::standing(&values) else {
        return String::new();
    };
    let out = machines.iter().zip(standing);
    let out = out.filter(|(_, z)| z.abs() > statistics::STANDS_OUT);
    let names = out.map(|((m, q), _)| {
        let value = number::with_std(q.value, q.std, "");
        format!("{}: {value}", m.folder.display())
    });
    names.collect::<Vec<_>>().join(", ")
}

/// One line per machine; a parameter has its value and its standard deviation.
fn csv(machines: &[Machine]) -> String {
    let keys = keys(machines);
    let columns: Vec<String> = keys.iter().map(|k| format!("{k},{k}_std")).collect();
    let mut out = format!("{}{}\n", many::SUMMARY, columns.join(","));
    for m in machines {
        let mut cells = vec![
            recording::csv::quoted(&m.folder.display().to_string()),
            recording::csv::quoted(&m.end),
        ];
        for key in &keys {
            let shown = m
                .found
                .get(*key)
                .map(|q| [q.value, q.std].map(|v| v.to_string()));
            cells.extend(shown.unwrap_or_default());
        }
        out += &(cells.join(",") + "\n");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stated_of_a_machines_own_file_is_meant_instead_of_what_is_stated_of_all() {
        use clap::Parser;
        let words = "heft calibrate excavator --each site/m7 site/m8 --payload empty.mcap=0 \
            --payload loaded.mcap=423±2 --payload site/m7/loaded.mcap=510±2";
        let cli = crate::commands::Cli::parse_from(words.split_whitespace());
        let Some(crate::commands::Command::Calibrate(args)) = cli.command else {
            panic!("calibrate");
        };
        let of = |folder: &str| {
            let mut all = options(&args, Path::new(folder));
            all.retain(|option| option.starts_with("--payload="));
            all
        };
        let empty = "--payload=empty.mcap=0";
        assert_eq!(
            of("site/m7"),
            [empty, "--payload=site/m7/loaded.mcap=510±2"]
        );
        assert_eq!(of("site/m8"), [empty, "--payload=loaded.mcap=423±2"]);
    }
}
