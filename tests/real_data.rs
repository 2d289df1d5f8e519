//! Parameters of real axes, from independent recordings; without the data these tests report that and pass.

mod common;
#[path = "common/theirs.rs"]
mod theirs;

use std::path::{Path, PathBuf};

use common::table::Table;
use common::{both, run};
use theirs::data;

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(name)
}

/// Names and cells of the last row of a table.
fn last_row(file: &Path) -> Vec<(String, String)> {
    let table = Table::read(file);
    let last = table.rows().next_back().expect("a row");
    let pair = |name: &String| (name.clone(), last.cell(name).to_owned());
    table.names().iter().map(pair).collect()
}

fn number(row: &[(String, String)], name: &str) -> f64 {
    let cell = row.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str());
    cell.and_then(|v| v.parse().ok())
        .unwrap_or_else(|| panic!("no {name} in {row:?}"))
}

fn estimate(input: &Path, map: &str, description: &str) -> Vec<(String, String)> {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("out.csv");
    let (map, description) = (shipped(map), shipped(description));
    let text = |p: &Path| p.to_str().expect("a path").to_owned();
    let result = run(&[
        "estimate",
        &text(input),
        "--machine",
        "excavator",
        "--map",
        &text(&map),
        "--config",
        &text(&description),
        "--method",
        "svf-rls",
        "-o",
        &text(&output),
    ]);
    assert!(result.status.success(), "{}", both(&result));
    last_row(&output)
}

#[test]
fn the_parameters_of_a_real_axis_are_found_within_a_few_percent() {
    let Some(input) = data("recorded/emps_identification.csv") else {
        return;
    };
    let row = estimate(&input, "maps/emps.toml", "descriptions/emps.toml");
    // Published values of the EMPS benchmark (Janot, Gautier, Brunot 2019).
    for (name, published, tolerance) in [
        ("inertia", 95.1089, 0.02),
        ("damping", 203.5034, 0.03),
        ("friction", 20.3935, 0.05),
    ] {
        let (value, std) = (number(&row, name), number(&row, &format!("{name}_std")));
        let error = value / published - 1.0;
        assert!(
            error.abs() < tolerance,
            "{name} {value}: {:+.2} %",
            100.0 * error
        );
        assert!(
            (value - published).abs() < 3.0 * std,
            "{name} {value} ± {std} claims to know better than the published {published}"
        );
    }
}

#[test]
fn the_interval_of_a_servo_stand_holds_its_inertia() {
    let Some(input) = data("recorded/hsm150_torque_steps.csv") else {
        return;
    };
    let row = estimate(&input, "maps/hsm150.toml", "descriptions/hsm150.toml");
    let (value, std) = (number(&row, "inertia"), number(&row, "inertia_std"));
    assert!(
        (value - 1.2e-4).abs() < 1.96 * std,
        "{value} ± {std} against 1.2e-4 kg m²"
    );
    assert!(std < 0.5 * value, "{value} ± {std} says nothing");
}

/// Keys and numbers of a written description.
fn numbers(file: &Path) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(file).expect("a description");
    let lines = text
        .lines()
        .filter_map(|l| l.split('#').next()?.split_once('='));
    lines
        .map(|(k, v)| (k.trim().to_owned(), v.trim().to_owned()))
        .collect()
}

#[test]
fn a_real_axis_is_calibrated_within_its_intervals_without_a_filter_frequency() {
    let Some(input) = data("recorded/emps_identification.csv") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("axis.toml");
    let (map, description) = (shipped("maps/emps.toml"), shipped("descriptions/emps.toml"));
    let text = |p: &Path| p.to_str().expect("a path").to_owned();
    let result = run(&[
        "calibrate",
        "excavator",
        &text(&input),
        "--map",
        &text(&map),
        "--config",
        &text(&description),
        "-o",
        &text(&output),
    ]);
    assert!(result.status.success(), "{}", both(&result));
    let found = numbers(&output);
    // Published values of the EMPS benchmark (Janot, Gautier, Brunot 2019).
    for (name, std, published, tolerance) in [
        ("inertia", "inertia_std", 95.1089, 0.005),
        ("nominal_damping", "damping_std", 203.5034, 0.01),
        ("coulomb_friction", "friction_std", 20.3935, 0.02),
    ] {
        let (value, std) = (number(&found, name), number(&found, std));
        assert!(
            (value / published - 1.0).abs() < tolerance,
            "{name} {value}"
        );
        assert!(
            (value - published).abs() < 1.96 * std,
            "{name} {value} ± {std}"
        );
    }
    let checked = run(&["check", &text(&output)]);
    assert!(checked.status.success(), "{}", both(&checked));
}

#[test]
fn a_servo_that_turns_one_way_is_calibrated_only_if_one_insists_and_its_interval_holds_the_inertia()
{
    let Some(input) = data("recorded/hsm150_torque_steps.csv") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("servo.toml");
    let (map, description) = (
        shipped("maps/hsm150.toml"),
        shipped("descriptions/hsm150.toml"),
    );
    let text = |p: &Path| p.to_str().expect("a path").to_owned();
    let (input, output_name) = (text(&input), text(&output));
    let (map, description) = (text(&map), text(&description));
    let mut words = vec!["calibrate", "excavator", &input, "--map", &map];
    words.extend(["--config", &description, "-o", &output_name]);
    let refused = run(&words);
    assert_eq!(refused.status.code(), Some(1), "{}", both(&refused));
    assert!(both(&refused).contains("one side only") && !output.exists());
    words.push("--accept");
    let accepted = run(&words);
    assert!(accepted.status.success(), "{}", both(&accepted));
    let found = numbers(&output);
    let (value, std) = (number(&found, "inertia"), number(&found, "inertia_std"));
    assert!(
        (value - 1.2e-4).abs() < 1.96 * std,
        "{value} ± {std} against 1.2e-4 kg m²"
    );
}
