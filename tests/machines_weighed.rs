//! Two excavators and two loaders with cylinder pressures that are not our simulator: `heft estimate` trusts them, and is right.
//!
//! What they are known for: noise of 4 mrad of a loader's angles is no turning bucket, and an excavator whose brake holds under torque
//! tells nothing of it. The recordings and what a competent user states are in `golden/weighed`.

mod common;

use std::path::{Path, PathBuf};

use common::run_ok;
use evaluate::honesty::{JudgedRow, Tally};
use serde_json::Value;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/weighed")
}

/// A table with the names of its columns.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a table");
        let mut lines = text.lines();
        let names = lines.next().expect("a header").split(',');
        Self {
            names: names.map(str::to_owned).collect(),
            rows: lines
                .map(|line| {
                    line.split(',')
                        .map(|c| c.parse().unwrap_or(f64::NAN))
                        .collect()
                })
                .collect(),
        }
    }

    fn column(&self, name: &str) -> impl Iterator<Item = f64> + '_ {
        let place = self.names.iter().position(|found| found == name);
        let place = place.unwrap_or_else(|| panic!("no column {name}"));
        self.rows.iter().map(move |row| row[place])
    }
}

/// A quantity, by the columns of value, deviation and verdict, its truth, and above which true speed the machine moves.
struct Quantity {
    value: &'static str,
    trusted: &'static str,
    truth: &'static str,
    speed: (&'static str, f64),
}

fn tally(recording: &Table, estimates: &Table, quantity: &Quantity) -> Tally {
    let std = format!("{}_std", quantity.value);
    let found = estimates.column(quantity.value).zip(estimates.column(&std));
    let found = found.zip(estimates.column(quantity.trusted));
    let truth = recording
        .column(quantity.truth)
        .zip(recording.column(quantity.speed.0));
    let mut tally = Tally::default();
    for (((estimate, std), trusted), (truth, speed)) in found.zip(truth) {
        tally.push(&JudgedRow {
            truth,
            estimate,
            std,
            trusted: trusted > 0.5,
            moving: speed.abs() > quantity.speed.1,
            reason: "",
        });
    }
    tally
}

fn estimated(name: &str, about: &Value) -> (Table, Table) {
    let scratch = tempfile::tempdir().expect("a folder");
    let recording = folder().join(format!("{name}.csv"));
    let output = common::path_in(scratch.path(), "estimates.csv");
    let sets = about["sets"].as_object().expect("settings by key");
    let sets: Vec<String> = sets
        .iter()
        .map(|(key, value)| format!("{key}={value}"))
        .collect();
    let mut args = vec![
        "estimate",
        recording.to_str().expect("a path"),
        "-o",
        &output,
    ];
    args.extend(["--machine", about["machine"].as_str().expect("a machine")]);
    args.extend(sets.iter().flat_map(|set| ["--set", set.as_str()]));
    run_ok(&args);
    let tables = (Table::read(&recording), Table::read(Path::new(&output)));
    assert_eq!(
        tables.0.rows.len(),
        tables.1.rows.len(),
        "{name}: a row each"
    );
    tables
}

#[test]
fn machines_with_pressures_are_trusted_and_what_is_trusted_is_right() {
    let text = std::fs::read_to_string(folder().join("machines.json")).expect("the settings");
    let machines: serde_json::Map<String, Value> = serde_json::from_str(&text).expect("JSON");
    assert_eq!(machines.len(), 4);
    let mut failed = Vec::new();
    for (name, about) in &machines {
        let quantity = if about["machine"] == "excavator" {
            Quantity {
                value: "inertia",
                trusted: "trusted",
                truth: "true_inertia",
                speed: ("true_velocity", 0.05),
            }
        } else {
            Quantity {
                value: "cg_ratio",
                trusted: "trusted_ratio",
                truth: "true_cg_ratio",
                speed: ("true_speed", 0.3),
            }
        };
        let (recording, estimates) = estimated(name, about);
        let found = tally(&recording, &estimates, &quantity);
        let said = format!(
            "{name}: trusted {:.2} wrong {:.3} rms {:.2} % covered {:.3}",
            found.trusted(),
            found.wrong(),
            found.rms(),
            found.covered()
        );
        println!("{said}");
        let least = about["least_trusted"].as_f64().expect("a share");
        if found.trusted() < least || found.wrong() > 0.05 || found.covered() < 0.95 {
            failed.push(said);
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
