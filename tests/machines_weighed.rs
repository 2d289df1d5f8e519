//! Two excavators and two loaders of independent simulators, with cylinder pressures: `heft estimate` trusts them correctly.
//!
//! Special cases: noise of 4 mrad in a loader's angles must not count as a turning bucket, and an excavator whose brake holds under torque
//! gives no information. The recordings and the settings of a competent user are in `golden/weighed`.

mod common;

use common::machines::{self, Limits};
use common::table::Table;
use common::{golden, path_in, run_ok};
use serde_json::Value;
use statistics::judge::{JudgedRow, Tally};

/// A quantity: columns of value, standard deviation and verdict, its truth, and the true speed above which the machine moves.
struct Quantity {
    value: &'static str,
    trusted: &'static str,
    truth: &'static str,
    speed: (&'static str, f64),
}

fn tally(recording: &Table, estimates: &Table, quantity: &Quantity) -> Tally {
    let std = format!("{}_std", quantity.value);
    let (speed, still) = quantity.speed;
    let mut tally = Tally::default();
    for (truth, found) in recording.rows().zip(estimates.rows()) {
        tally.push(&JudgedRow {
            truth: truth.number(quantity.truth),
            estimate: found.number(quantity.value),
            std: found.number(&std),
            trusted: found.number(quantity.trusted) > 0.5,
            moving: truth.number(speed).abs() > still,
            reason: "",
        });
    }
    tally
}

/// A recording, and its estimates by `heft estimate`.
fn estimated(name: &str, about: &Value) -> (Table, Table) {
    let scratch = tempfile::tempdir().expect("a folder");
    let recording = golden(&format!("weighed/{name}.csv"));
    let output = path_in(scratch.path(), "estimates.csv");
    let sets = machines::sets(&about["sets"]);
    let mut args = vec![
        "estimate",
        recording.to_str().expect("a path"),
        "-o",
        &output,
    ];
    args.extend(["--machine", about["machine"].as_str().expect("a machine")]);
    args.extend(sets.iter().flat_map(|set| ["--set", set.as_str()]));
    run_ok(&args);
    let (recording, estimates) = (Table::read(&recording), Table::read(&output));
    let rows = [&recording, &estimates].map(|table| table.rows().len());
    assert_eq!(rows[0], rows[1], "{name}: a row each");
    (recording, estimates)
}

#[test]
fn machines_with_pressures_are_trusted_and_what_is_trusted_is_right() {
    let machines = machines::described("weighed/machines.json");
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
        let said = format!("{name}: {}", machines::scores(&found));
        println!("{said}");
        let limits = Limits {
            trusted: about["least_trusted"].as_f64().expect("a share"),
            covered: 0.95,
        };
        if !limits.hold(&found) {
            failed.push(said);
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
