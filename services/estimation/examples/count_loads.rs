//! Counts the loads in the estimates of `heft estimate`:
//! `cargo run -p estimation --example count_loads -- ESTIMATES.csv RATED_KG`.

use std::error::Error;
use std::process::ExitCode;

use estimation::Quantity;
use estimation::loads::{Ledger, Load, Row, Settings, Stage};

fn main() -> ExitCode {
    let Err(error) = run() else {
        return ExitCode::SUCCESS;
    };
    eprintln!("{error}");
    ExitCode::from(2)
}

fn run() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(file), Some(rated)) = (arguments.next(), arguments.next()) else {
        return Err("usage: count_loads ESTIMATES.csv RATED_KG".into());
    };
    let text = std::fs::read_to_string(&file).map_err(|e| format!("{file}: {e}"))?;
    let rated = rated.parse().map_err(|e| format!("{rated}: {e}"))?;
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut ledger = Ledger::new(Settings::with_rated(rated));
    let report = |load: Option<Load>| {
        if let Some(load) = load.filter(|l| l.stage == Stage::Settled) {
            println!("{}", line_of(&load));
        }
    };
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |name: &str| -> Option<f64> {
            let at = header.iter().position(|h| *h == name)?;
            cells.get(at)?.parse().ok()
        };
        let is_set = |name: &str| number(name) == Some(1.0);
        let payload = number("payload").zip(number("payload_std"));
        let events = ledger.step(&Row {
            time: number("t").unwrap_or(f64::NAN),
            payload: payload.map(|(value, std)| Quantity { value, std }),
            speed: number("velocity").unwrap_or(0.0),
            changing: is_set("changing"),
            trusted: is_set("trusted"),
            ..Row::default()
        });
        report(events.load);
    }
    report(ledger.finish().load);
    if let Some(load) = ledger.carried() {
        println!("in the bucket: {}", line_of(&load));
    }
    let all = ledger.all();
    println!(
        "loads: {}, {:.0} +- {:.0} kg",
        all.loads,
        all.kg,
        1.96 * all.std()
    );
    Ok(())
}

fn line_of(load: &Load) -> String {
    format!(
        "{} {} filled {:.2} dumped {:.2} kg {:.1} std {:.1} rest {:.1} std {:.1} trusted {}",
        load.number,
        load.stage.name(),
        load.filled,
        load.dumped.unwrap_or(f64::NAN),
        load.weight.kg,
        load.weight.std,
        load.carry_back.kg,
        load.carry_back.std,
        load.trusted
    )
}
