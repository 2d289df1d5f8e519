//! `heft evaluate`: Monte-Carlo evaluation next to the published figures.

use std::fs;

use messages::Machine;

use crate::cli::EvaluateArgs;
use crate::failure::Failure;

/// `heft evaluate`
pub fn evaluate(args: &EvaluateArgs) -> Result<(), Failure> {
    if let Some(folder) = &args.figures {
        fs::create_dir_all(folder).map_err(|e| Failure::file("make the folder", folder, &e))?;
        return crate::figures::draw(args.machine, folder);
    }
    let options = evaluate::Options {
        table: args.table.clone(),
        seeds: args.seeds,
        ..Default::default()
    };
    let report = match args.machine {
        Machine::Excavator => evaluate::excavator(&options),
        Machine::Loader => evaluate::loader(&options),
    }
    .map_err(|e| {
        Failure::input(
            e,
            "--table",
            "choose one of the tables above, or none for all",
        )
    })?;
    println!("{}", report.text.trim_end());
    if let Some(file) = &args.json {
        let text = serde_json::to_string_pretty(&report.json).map_err(Failure::internal)?;
        fs::write(file, text + "\n").map_err(|e| Failure::file("write", file, &e))?;
    }
    if !report.met {
        println!("\nNot every target is met: see the rows marked above.");
    }
    Ok(())
}
