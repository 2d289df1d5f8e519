//! `heft evaluate`: Monte-Carlo evaluation next to the published figures.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use messages::Machine;

use crate::args::machine;
use crate::build::IDENTITY;
use crate::failure::Failure;
use crate::machines;
use crate::results;

/// `heft evaluate`
#[derive(Debug, Args)]
pub struct EvaluateArgs {
    /// The machine
    #[arg(value_parser = machine())]
    pub machine: Machine,
    /// One table only; an unknown name lists them, docs/theory/papers.md says what they show
    #[arg(long)]
    pub table: Option<String>,
    /// Monte-Carlo runs per case
    #[arg(long, default_value_t = 100)]
    pub seeds: usize,
    /// Write the numbers as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Draw the papers' figures from our runs as SVG into this folder
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
}

/// `heft evaluate`
pub fn evaluate(args: &EvaluateArgs) -> Result<(), Failure> {
    if let Some(folder) = &args.figures {
        fs::create_dir_all(folder).map_err(|e| Failure::folder(folder, &e))?;
        for (name, svg) in (machines::entry(args.machine).figures)()? {
            let path = folder.join(format!("{}-{name}.svg", args.machine));
            results::text(
                "write the figure",
                &path,
                &[],
                |head| head.starts_with(b"<svg"),
                &svg,
            )?;
            println!("{}", path.display());
        }
        return Ok(());
    }
    if let Some(file) = &args.json {
        recording::output::check(file, &[], results::is_json_of("evaluate"))?;
    }
    let options = evaluate::Options {
        table: args.table.clone(),
        seeds: args.seeds,
    };
    let report = (machines::entry(args.machine).evaluate)(&options);
    let report = report.map_err(|e| {
        let hint = match &e {
            evaluate::Error::UnknownTable { name, known } => {
                config::nearest(name, known.iter().copied()).map(|n| format!("did you mean `{n}`?"))
            }
            _ => None,
        };
        let remedy = hint.unwrap_or("choose one of the tables above, or none for all".into());
        Failure::input(e, "--table", remedy)
    })?;
    println!("{}", report.text.trim_end());
    if let Some(file) = &args.json {
        results::json(file, &[], "evaluate", IDENTITY, &report.json)?;
    }
    match report.met {
        true => Ok(()),
        false => Err(Failure::answer_is_no(
            "not every target is met: see the rows marked above",
        )),
    }
}
