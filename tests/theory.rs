//! The theory of the excavator, computed anew: the page `docs/theory/excavator-steps.md` in the standard library of Python, beside heft.

use std::io::Write as _;
use std::path::Path;
use std::process::Command;

/// What another computation may differ by, in heft's standard deviations: rounding of numbers of 64 bits.
const ROUNDING: f64 = 1e-9;

fn heft(folder: &Path, arguments: &[&str]) -> Vec<u8> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_heft"));
    let output = command.args(arguments).current_dir(folder).output();
    let output = output.expect("heft runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "heft {arguments:?}: {said}");
    output.stdout
}

/// How far both are apart on a simulated recording, in standard deviations: what the example says last.
fn apart(scenario: &str) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let file = heft(path, &["check", "--machine", "excavator", "--print"]);
    std::fs::write(path.join("machine.toml"), file).expect("a machine file");
    let run = ["run", "excavator", "--without", "pressure", "--seed", "2"];
    let lasts = ["--duration", "60", "--pace", "max", "--out", "run"];
    heft(
        path,
        &[&run[..], &["--scenario", scenario], &lasts].concat(),
    );
    heft(path, &["export", "run/run.mcap", "-o", "tables"]);
    let samples = "tables/excavator_sensors.csv";
    let machine = ["--machine", "excavator", "-o", "estimates.csv"];
    heft(path, &[&["estimate", samples][..], &machine].concat());
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/theory/excavator.py");
    let output = Command::new("python3")
        .arg(example)
        .args(["machine.toml", samples, "estimates.csv"])
        .current_dir(path)
        .output()
        .expect("python3");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{scenario}: {said}");
    let said = String::from_utf8_lossy(&output.stdout);
    let largest = said
        .split(" (largest)")
        .next()
        .and_then(|s| s.rsplit(' ').next());
    let largest = largest.and_then(|number| number.parse().ok());
    largest.unwrap_or_else(|| panic!("{scenario}: {said}"))
}

#[test]
fn who_follows_the_page_computes_the_same_inertia_and_payload() {
    let mut python = Command::new("python3");
    let asked = python.args(["-c", "import tomllib"]).status();
    if !asked.is_ok_and(|status| status.success()) {
        let _ = writeln!(std::io::stderr(), "skipped: no python3 of version 3.11");
        return;
    }
    for scenario in ["work", "work-slope-inclinometer-4-deg", "cycle"] {
        let apart = apart(scenario);
        assert!(apart < ROUNDING, "{scenario}: {apart}");
    }
}
