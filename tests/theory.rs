//! The theory of both machines in an independent computation: the pages `docs/theory/MACHINE-steps.md`, in Python's standard library.

mod common;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;

use common::machines::loader_sample;
use common::table::Table;
use config::Tables as _;
use estimation::loader::{CgEstimator, Columns, Method, Settings};

/// Largest difference of two computations, in standard deviations: rounding of 64-bit numbers.
const ROUNDING: f64 = 1e-9;

/// A prior so wide that heft's answer does not change the ratio of the slips.
const WIDE_GUESS: &str = "prior.cg_ratio_std=0.1";

/// Names of the loader's states in the example.
const STATES: [&str; 12] = [
    "v", "w_f", "w_r", "K", "h", "lam", "F_x", "d_f", "d_r", "b", "e", "tau",
];

fn run(folder: &Path, program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("a program that starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {said}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn heft(folder: &Path, arguments: &[&str]) -> String {
    run(folder, env!("CARGO_BIN_EXE_heft"), arguments)
}

/// Records a simulated minute in `tables`, and writes the machine file, of which these lines are stated.
fn record(folder: &Path, machine: &str, stated: &str, scenario: &str) {
    let stated = format!("[machine]\nkind = \"{machine}\"\n{stated}");
    std::fs::write(folder.join("stated.toml"), stated).expect("a machine file");
    let file = heft(folder, &["check", "stated.toml", "--print"]);
    std::fs::write(folder.join("machine.toml"), file).expect("a machine file");
    let run = ["run", machine, "--without", "pressure", "--seed", "2"];
    let lasts = ["--duration", "60", "--pace", "max", "--out", "run"];
    heft(
        folder,
        &[&run[..], &["--scenario", scenario], &lasts].concat(),
    );
    heft(folder, &["export", "run/run.mcap", "-o", "tables"]);
}

/// Writes heft's estimates of it to `estimates.csv`.
fn estimate(folder: &Path, machine: &str, method: &str) {
    let samples = format!("tables/{machine}_sensors.csv");
    let how = ["--config", "machine.toml", "--method", method];
    let out = ["-o", "estimates.csv"];
    heft(folder, &[&["estimate", &samples][..], &how, &out].concat());
}

/// Largest difference of the example from heft, in standard deviations: the last word of its output.
fn apart(folder: &Path, machine: &str) -> f64 {
    let example = format!(
        "{}/examples/theory/{machine}.py",
        env!("CARGO_MANIFEST_DIR")
    );
    let samples = format!("tables/{machine}_sensors.csv");
    let said = run(
        folder,
        "python3",
        &[&example, "machine.toml", &samples, "estimates.csv"],
    );
    let largest = said
        .split(" (largest)")
        .next()
        .and_then(|s| s.rsplit(' ').next());
    let largest = largest.and_then(|number| number.parse().ok());
    largest.unwrap_or_else(|| panic!("{machine}: {said}"))
}

/// Adds every state of the loader's filter, with its standard deviation, to `estimates.csv`.
fn add_states(folder: &Path, method: Method) {
    let mut description = config::Loader::default();
    description.set(WIDE_GUESS).expect("a key");
    let settings = Settings::of(&description, method);
    let columns = Columns { acceleration: true };
    let mut estimator = CgEstimator::new(&settings, method, columns).expect("an estimator");
    let file = folder.join("estimates.csv");
    let estimates = std::fs::read_to_string(&file).expect("estimates");
    let mut lines = estimates.lines();
    let mut text = lines.next().expect("a header").to_owned();
    for name in &STATES[..estimator.state().len()] {
        let _ = write!(text, ",{name},{name}_std");
    }
    let samples = Table::read(folder.join("tables/loader_sensors.csv"));
    for (row, line) in samples.rows().zip(lines) {
        estimator.step(&loader_sample(&row));
        let _ = write!(text, "\n{line}");
        for (i, value) in estimator.state().iter().enumerate() {
            let _ = write!(text, ",{value},{}", estimator.state_std(i));
        }
    }
    std::fs::write(file, text).expect("a table");
}

/// Whether there is a Python that can read a machine file.
fn has_python() -> bool {
    let mut python = Command::new("python3");
    let asked = python.args(["-c", "import tomllib"]).status();
    let has = asked.is_ok_and(|status| status.success());
    if !has {
        let _ = writeln!(std::io::stderr(), "skipped: no python3 of version 3.11");
    }
    has
}

#[test]
fn who_follows_the_page_computes_the_same_inertia_and_payload() {
    if !has_python() {
        return;
    }
    for scenario in ["work", "work-slope-inclinometer-4-deg", "cycle"] {
        let folder = tempfile::tempdir().expect("a folder");
        record(folder.path(), "excavator", "", scenario);
        estimate(folder.path(), "excavator", "auto");
        let apart = apart(folder.path(), "excavator");
        assert!(apart < ROUNDING, "{scenario}: {apart}");
    }
}

#[test]
fn who_follows_the_page_computes_the_same_load_fraction_and_covariance() {
    if !has_python() {
        return;
    }
    let (key, value) = WIDE_GUESS.split_once('.').expect("a table and a key");
    let stated = format!("[{key}]\n{value}");
    for scenario in ["work-reversing", "accel-decel", "digging"] {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        record(folder, "loader", &stated, scenario);
        for method in [Method::FullEkf, Method::Ekf] {
            estimate(folder, "loader", method.name());
            add_states(folder, method);
            let apart = apart(folder, "loader");
            assert!(apart < ROUNDING, "{scenario}, {method}: {apart}");
        }
    }
}
