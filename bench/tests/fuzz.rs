//! A short part of the battery's fuzzing, including all earlier findings: every target returns within its memory limit.
//! The gate runs a longer part, with one seed each time.

use std::collections::VecDeque;
use std::process::Command;
use std::sync::Mutex;

use fuzz::TARGETS;

/// A number from the environment.
fn asked(name: &str, usual: u64) -> String {
    let value = std::env::var(name).unwrap_or_else(|_| usual.to_string());
    assert!(value.parse::<u64>().is_ok(), "{name}={value} is no number");
    value
}

/// Runs a target in a process and a folder of its own. The error has its output and its last input, if it did not survive.
fn attack(target: &str) -> Result<(), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let seed = asked("HEFT_FUZZ_SEED", 11);
    let output = Command::new(env!("CARGO_BIN_EXE_battery"))
        .args(["--fuzz", target, "--seed", &seed])
        .args(["--seconds", &asked("HEFT_FUZZ_SECONDS", 1)])
        .current_dir(folder.path())
        .output()
        .expect("the battery starts");
    let printed = String::from_utf8_lossy(&output.stdout);
    println!("{target}: {} inputs, seed {seed}", printed.trim());
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let input = folder.keep().join("input");
    Err(format!(
        "{target}, seed {seed}, input {}: {} {said}",
        input.display(),
        output.status
    ))
}

#[test]
fn every_parser_survives_what_was_found_and_some_seconds_of_mutations() {
    let waiting: Mutex<VecDeque<_>> = Mutex::new(TARGETS.iter().map(|t| t.name).collect());
    let next = || waiting.lock().expect("nobody panics").pop_front();
    // Two at a time.
    let some = || -> Vec<_> { std::iter::from_fn(next).map(attack).collect() };
    let results = std::thread::scope(|scope| {
        let other = scope.spawn(some);
        let mut results = some();
        results.extend(other.join().expect("it ends"));
        results
    });
    assert_eq!(results.len(), TARGETS.len());
    let failed: Vec<String> = results.into_iter().filter_map(Result::err).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn an_unknown_target_is_refused_with_the_known_ones() {
    let output = Command::new(env!("CARGO_BIN_EXE_battery"))
        .args(["--fuzz", "none of them"])
        .output()
        .expect("the battery starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && said.contains("candump"),
        "{said}"
    );
}
