//! A short share of the battery's fuzzing, with everything that was found before: every target returns, within its memory.

use std::process::Command;

#[test]
fn every_parser_survives_what_was_found_and_a_second_of_mutations() {
    let targets = [
        "csv",
        "dbc",
        "map",
        "description",
        "candump",
        "lines",
        "mcap",
        "report",
        "http",
    ];
    for target in targets {
        let folder = tempfile::tempdir().expect("a folder");
        let output = Command::new(env!("CARGO_BIN_EXE_battery"))
            .args(["--fuzz", target, "--seconds", "1", "--seed", "11"])
            .current_dir(folder.path())
            .output()
            .expect("the battery starts");
        let said = String::from_utf8_lossy(&output.stderr);
        let input = std::fs::read(folder.path().join("input")).unwrap_or_default();
        assert!(
            output.status.success(),
            "{target}: {} {said}\ninput: {:?}",
            output.status,
            String::from_utf8_lossy(&input)
        );
    }
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
