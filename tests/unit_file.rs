//! The systemd unit, as far as a shell can test it.

use std::io::Write as _;
use std::process::{Command, Output};

/// Runs the command of the unit, with `heft` replaced by a program that prints its arguments, and the description at `described`.
fn started(environment: &[(&str, &str)], described: &str) -> Output {
    let unit = include_str!("../services/heft/heft@.service");
    let line = unit
        .lines()
        .find_map(|l| l.strip_prefix("ExecStart=/bin/sh -c '"));
    let script = line
        .and_then(|l| l.strip_suffix('\''))
        .expect("a command in quotes");
    let script = script
        .replace("%i", "excavator")
        .replace("/etc/heft/excavator.toml", described)
        .replace("exec heft", "echo heft");
    let mut shell = Command::new("/bin/sh");
    shell.args(["-c", &script]).env_clear();
    shell.envs(environment.iter().copied());
    shell.output().expect("a shell")
}

#[test]
fn the_unit_refuses_to_start_without_a_source_and_says_what_to_write() {
    for environment in [&[][..], &[("INPUT", "can:can0")], &[("MAP", "/m.toml")]] {
        let output = started(environment, "/dev/null");
        assert_eq!(output.status.code(), Some(78));
        let said = String::from_utf8_lossy(&output.stderr);
        for word in [
            "INPUT=can:can0",
            "MAP=/etc/heft/excavator.map.toml",
            "/etc/heft/excavator.source",
        ] {
            assert!(said.contains(word), "{said}");
        }
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn the_unit_refuses_to_start_without_a_description_and_says_what_to_write() {
    let output = started(
        &[("INPUT", "can:can0"), ("MAP", "/m.toml")],
        "/no/where.toml",
    );
    assert_eq!(output.status.code(), Some(78));
    let said = String::from_utf8_lossy(&output.stderr);
    let command = "heft check --machine excavator --print";
    assert!(
        said.contains("/no/where.toml") && said.contains(command),
        "{said}"
    );
    let command = command.split(' ').skip(1);
    let reported = Command::new(env!("CARGO_BIN_EXE_heft"))
        .args(command)
        .output();
    let reported = reported.expect("heft starts");
    assert!(reported.status.success() && reported.stdout.starts_with(b"[machine]"));
}

#[test]
fn the_unit_runs_the_source_that_is_written_with_its_options() {
    let options = ("OPTIONS", "--split 10min --keep 20GB");
    let source = [("INPUT", "can:can0"), ("MAP", "/m.toml"), options];
    let output = started(&source, "/dev/null");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success());
    let start =
        "heft run excavator --input can:can0 --map /m.toml --split 10min --keep 20GB --config";
    assert!(said.starts_with(start), "{said}");
}

#[test]
fn the_example_of_a_source_starts_the_unit() {
    let source = include_str!("../services/heft/debian/examples/excavator.source");
    let lines = source.lines().filter(|l| !l.starts_with('#'));
    let source: Vec<_> = lines.filter_map(|l| l.split_once('=')).collect();
    let output = started(&source, "/dev/null");
    let said = String::from_utf8_lossy(&output.stdout);
    let start = "heft run excavator --input can:can0 --map /etc/heft/excavator.map.toml";
    assert!(said.starts_with(start), "{said}");
}

#[test]
fn the_options_of_the_unit_are_options_of_heft_and_give_way_to_those_that_are_written() {
    let unit = include_str!("../services/heft/heft@.service");
    let usual = unit
        .find("Environment=\"OPTIONS=")
        .expect("options of its own");
    let written = unit.find("EnvironmentFile=").expect("a file");
    assert!(usual < written, "what stands later counts");
    let options = unit[usual..].lines().next().expect("a line");
    let options = options
        .strip_prefix("Environment=\"OPTIONS=")
        .and_then(|o| o.strip_suffix('"'));
    // It is refused for the missing file only, after all options were parsed.
    let output = Command::new(env!("CARGO_BIN_EXE_heft"))
        .args(["run", "excavator", "--input", "/nowhere.csv"])
        .args(options.expect("in quotes").split(' '))
        .output()
        .expect("heft starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("/nowhere.csv"), "{said}");
}

/// The output of `systemd-analyze` on the unit; `None`, with a message, if it is not installed.
fn analyzed(arguments: &[&str]) -> Option<Output> {
    let unit = concat!(env!("CARGO_MANIFEST_DIR"), "/services/heft/heft@.service");
    let mut command = Command::new("systemd-analyze");
    let output = command.args(arguments).arg(unit).output();
    if output.is_err() {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: systemd-analyze is not installed"
        );
    }
    output.ok()
}

#[test]
fn systemd_understands_every_line_of_the_unit() {
    // Its manual page is installed by the package, not here.
    let Some(output) = analyzed(&["verify", "--man=no"]) else {
        return;
    };
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !said.contains("heft@"), "{said}");
}

#[test]
fn the_unit_is_exposed_as_little_as_a_pipeline_may_be() {
    // In tenths: 24 with systemd 252, where 100 is a unit without any protection.
    let offline = ["security", "--offline=true", "--threshold=30"];
    let Some(output) = analyzed(&offline) else {
        return;
    };
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
}
