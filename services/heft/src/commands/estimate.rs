//! `heft estimate`: the steps of the pipeline in one thread, on recorded data.

pub mod args;
mod found;
mod many;
pub mod one;

use std::path::{Path, PathBuf};

pub use self::args::EstimateArgs;
use crate::args::described;
use crate::failure::Failure;
use crate::results::{self, IsOurs, is_json_of};
use crate::size;
use crate::{machines, page};

/// `heft estimate`
pub fn estimate(args: &EstimateArgs) -> Result<(), Failure> {
    match (&args.output, args.files.as_slice()) {
        (Some(output), [folder]) if folder.is_dir() && recording::recordings(folder).is_empty() => {
            Err(Failure::input(
                "this is a folder without a recording, and one result is of one input",
                format!("{}, --output {}", folder.display(), output.display()),
                "name one of its files; or leave --output out: the result of each file below the folder goes beside it",
            ))
        }
        (Some(output), [file]) => one(args, file, output),
        (None, files) => match single_results(args).as_slice() {
            [] => many::estimate(args),
            wanted if matches!(files, [file] if !file.is_dir()) => Err(Failure::input(
                "a report or a summary is made beside the estimates, and they have no file",
                wanted.join(", "),
                "name it: --output OUT.csv",
            )),
            wanted => Err(of_one_input(&args.files, wanted)),
        },
        (Some(_), files) => Err(of_one_input(files, &single_results(args))),
    }
}

/// The options that name a result of a single input.
fn single_results(args: &EstimateArgs) -> Vec<String> {
    let all = [
        ("--output", &args.output),
        ("--json", &args.json),
        ("--report", &args.report),
    ];
    let named = |(option, file): (&str, &Option<PathBuf>)| {
        let file = file.as_ref()?;
        Some(format!("{option} {}", file.display()))
    };
    all.into_iter().filter_map(named).collect()
}

/// The error for results of a single input where there are several, or one of them is none.
fn of_one_input(files: &[PathBuf], options: &[String]) -> Failure {
    if let Some(missing) = files.iter().find(|file| !file.exists()) {
        return Failure::file("read", missing, &std::io::ErrorKind::NotFound.into());
    }
    let names = options.iter().filter_map(|o| o.split(' ').next());
    let names: Vec<&str> = names.collect();
    Failure::input(
        "several inputs cannot have one result",
        options.join(", "),
        format!(
            "leave {} out: the estimates of each input and their summary (JSON) go beside it; a report is of one input with --output",
            names.join(" and ")
        ),
    )
}

/// One input in this process.
fn one(args: &EstimateArgs, file: &Path, output: &Path) -> Result<(), Failure> {
    check_outputs(args, file, output)?;
    crate::many::check_is_data(file)?;
    let description = described(args.machine, &args.with.description, file)?;
    let end = (machines::entry(description.machine()).estimate)(args, file, output, &description);
    // For an input that cannot be read no assumption is reported.
    if end.as_ref().err().is_none_or(|failure| failure.status == 1)
        && let Some(note) = size::assumed(&description, &args.with.description, file)?
    {
        eprintln!("{note}");
    }
    end
}

/// Refuses to overwrite an input or any other valuable file.
fn check_outputs(args: &EstimateArgs, file: &Path, output: &Path) -> Result<(), Failure> {
    let config = args.with.description.config.as_deref();
    let inputs = [Some(file), args.with.map.as_deref(), config];
    let is_json = is_json_of("estimate");
    let wanted: [(_, IsOurs); 3] = [
        (Some(output), &recording::csv::is_estimates),
        (args.report.as_deref(), &page::is_ours),
        (args.json.as_deref(), &is_json),
    ];
    results::check(inputs.into_iter().flatten().collect(), &wanted)
}
