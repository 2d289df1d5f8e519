//! The swing inertia from a table, without a process: `cargo run --example inertia_from_csv data.csv`.
//!
//! Four rows a second of a table of 100 Hz, and at the end the last row that is trusted.

use std::error::Error;
use std::process::ExitCode;

use estimation::excavator::keys::Description;
use estimation::excavator::{Columns, Method, Settings, SwingEstimator};

/// Number of rows per printed row.
const EVERY: usize = 25;

fn main() -> ExitCode {
    let Err(error) = run() else {
        return ExitCode::SUCCESS;
    };
    eprintln!("{error}");
    ExitCode::from(2)
}

fn run() -> Result<(), Box<dyn Error>> {
    let default = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/golden/excavator_input_base_case2.csv"
    );
    let file = std::env::args().nth(1).unwrap_or_else(|| default.into());
    let rows = recording::load::<messages::ExcavatorSensors>(&file, None)?;
    let columns = rows.first().map_or(Columns::default(), |(first, _)| {
        steps::excavator::columns(first)
    });
    let settings = Settings::of(&Description::default());
    let mut estimator = SwingEstimator::new(&settings, Method::Auto, columns)?;
    let mut trusted = None;
    for (row, (sensors, _)) in rows.iter().enumerate() {
        let answer = estimator.step(&steps::excavator::sample(sensors));
        let half = estimation::HALF_WIDTH_95 * answer.inertia_std;
        let text = format!(
            "{:7.2} s  {:6.0} ± {half:5.0} kg m²",
            sensors.stamp.time, answer.inertia
        );
        let word = match answer.flags.trusted() {
            true => "trusted",
            false => "not trusted",
        };
        if row % EVERY == 0 {
            println!("{text}  {word}");
        }
        if answer.flags.trusted() {
            trusted = Some(text);
        }
    }
    match trusted {
        Some(text) => println!("last trusted: {text} (95 %)"),
        None => println!("never trusted: `heft estimate` says why"),
    }
    Ok(())
}
