//! Eight excavators that are not our simulator: of what they call trusted, at most one row of twenty is wrong.
//!
//! The recordings and the settings that a competent user states are in `golden/machines`. A trusted row is
//! wrong if its 95 % interval misses the truth or the value is more than 10 % off.

use std::path::PathBuf;

use config::Tables as _;
use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};
use evaluate::honesty::{Judged, Tally};

/// True velocity above which the machine moves [rad/s].
const MOVING: f64 = 0.05;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/machines")
}

/// The estimator of a recording as `heft estimate` makes it, and the tally over its rows.
fn tally(name: &str, sets: &serde_json::Value, method: Method) -> Tally {
    let sets = sets.as_object().expect("settings by key");
    let sets: Vec<String> = sets
        .iter()
        .map(|(key, value)| format!("{key}={value}"))
        .collect();
    let mut description = config::Excavator::default();
    description.set_all(&sets).expect("settings that exist");
    let settings = Settings::of(&description);

    let text = std::fs::read_to_string(folder().join(format!("{name}.csv"))).expect("a recording");
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    let column = |name: &str| header.iter().position(|found| *found == name);
    let columns = Columns {
        velocity: true,
        torque: true,
        posture: true,
        ..Columns::default()
    };
    let mut estimator = SwingEstimator::new(&settings, method, columns).expect("an estimator");
    let mut tally = Tally::default();
    for cells in lines {
        let value = |name: &str| column(name).and_then(|i| cells[i].parse::<f64>().ok());
        let estimate = estimator.step(&Sample {
            time: value("t").expect("a time"),
            velocity: value("swing_velocity"),
            torque: value("swing_torque"),
            posture: ["boom_angle", "arm_angle", "bucket_angle"].map(value),
            ..Sample::default()
        });
        tally.push(&Judged {
            truth: value("true_inertia").expect("the truth"),
            estimate: estimate.inertia,
            std: estimate.inertia_std,
            trusted: estimate.flags.trusted(),
            moving: value("true_velocity").expect("the truth").abs() > MOVING,
            reason: "",
        });
    }
    tally
}

fn recordings() -> serde_json::Map<String, serde_json::Value> {
    let text = std::fs::read_to_string(folder().join("excavator.json")).expect("the settings");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn what_is_trusted_on_other_machines_is_right_and_the_interval_holds_all_the_time() {
    for (name, about) in recordings() {
        let found = tally(&name, &about["sets"], Method::Auto);
        let said = format!(
            "{name}: trusted {:.2} wrong {:.3} rms {:.2} % covered {:.3}",
            found.trusted(),
            found.wrong(),
            found.rms(),
            found.covered()
        );
        println!("{said}");
        assert!(found.wrong() <= 0.05, "{said}");
        assert!(found.covered() >= 0.93, "{said}");
        let least = if name.contains("level") { 0.70 } else { 0.50 };
        assert!(found.trusted() >= least, "{said}");
    }
}

#[test]
fn other_methods_are_right_or_not_trusted() {
    for (name, about) in recordings() {
        for method in [Method::Torque, Method::Posture, Method::Velocity] {
            let found = tally(&name, &about["sets"], method);
            let said = format!(
                "{name}, {}: trusted {:.2} wrong {:.3}",
                method.name(),
                found.trusted(),
                found.wrong()
            );
            println!("{said}");
            assert!(found.wrong() <= 0.05, "{said}");
        }
    }
}
