//! `heft calibrate` over many machines, and files that it must never overwrite.

mod common;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use common::{both, path_in, run, run_ok, says};
use config::Tables as _;
use evaluate::excavator::calibration::Truth;

/// A table of a machine's sensors while it works with a load [kg].
fn record(file: &Path, machine: u64, load: f64) {
    let mut text = "t,swing_velocity,swing_torque,boom_angle,arm_angle,bucket_angle\n".to_owned();
    for s in Truth::new(machine).record(load, 2 * machine + u64::from(load > 0.0)) {
        let values = [s.velocity, s.torque].into_iter().chain(s.posture);
        let _ = write!(text, "{}", s.time);
        for value in values {
            let _ = write!(text, ",{}", value.expect("a healthy sensor"));
        }
        text.push('\n');
    }
    std::fs::write(file, text).expect("writable");
}

struct Site(tempfile::TempDir);

impl Site {
    /// Three machines with an empty and a loaded recording each; the load of the last one is not stated.
    fn new() -> Self {
        let site = Self(tempfile::tempdir().expect("a folder"));
        for (name, machine) in [("a", 3), ("b", 5), ("c", 8)] {
            std::fs::create_dir(site.path(name)).expect("a folder");
            record(&site.path(&format!("{name}/empty.csv")), machine, 0.0);
            if name != "c" {
                record(&site.path(&format!("{name}/loaded.csv")), machine, 423.0);
            }
        }
        site
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        path_in(self.0.path(), name)
    }

    fn words(&self, more: &[&str]) -> Vec<String> {
        let mut words: Vec<String> = [
            "calibrate",
            "excavator",
            "--each",
            "--payload",
            "empty.csv=0",
            // Their geometry is as described, and their angles are exact.
            "--set",
            "machine.geometry_tolerance=0",
            "--set",
            "sensors.angle_offset_std=0",
        ]
        .map(String::from)
        .into();
        words.extend(more.iter().map(|w| (*w).to_owned()));
        words
    }
}

#[test]
fn each_folder_is_a_machine_and_results_are_retained_until_other_ones_are_requested() {
    let site = Site::new();
    let summary = site.text("all.csv");
    let run_all = |folders: &[&str], load: &str| {
        let mut words = site.words(&["--payload", load, "--summary", &summary]);
        words.extend(folders.iter().map(|f| site.text(f)));
        run(&words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let result = run_all(&["a", "b"], "loaded.csv=423±0.5");
    assert!(result.status.success(), "{}", both(&result));
    for (folder, machine) in [("a", 3), ("b", 5)] {
        run_ok(&["check", &site.text(&format!("{folder}/calibrated.toml"))]);
        assert!(site.path(&format!("{folder}/calibrated.html")).exists());
        let text = std::fs::read_to_string(site.path(&format!("{folder}/calibrated.toml")));
        let d = config::Excavator::parse(&text.expect("a file"), "calibrated.toml").expect("good");
        let (gain, std) = (
            d.sensors.swing_torque_gain,
            d.sensors.swing_torque_gain_std.expect("written"),
        );
        let truth = Truth::new(machine).gain;
        assert!(
            (gain - truth).abs() < 3.0 * std && std < 0.01,
            "{gain} ± {std}: {truth}"
        );
    }
    let table = std::fs::read_to_string(&summary).expect("a table");
    let mut lines = table.lines();
    let columns = lines.next().expect("names").split(',').count();
    assert!(table.contains("sensors.swing_torque_gain,sensors.swing_torque_gain_std"));
    assert_eq!(
        lines.map(|l| l.split(',').count()).collect::<Vec<_>>(),
        [columns; 2]
    );
    // The same command again computes nothing; another load, and a machine without its recording, are reported.
    let again = run_all(&["a", "b"], "loaded.csv=423±0.5");
    assert_eq!(
        both(&again).matches("up to date").count(),
        2,
        "{}",
        both(&again)
    );
    let other = run_all(&["a", "c"], "loaded.csv=423±1");
    assert_eq!(other.status.code(), Some(2), "{}", both(&other));
    assert!(both(&other).contains("done") && !both(&other).contains("up to date"));
    assert!(both(&other).contains("loaded.csv is none of the recordings"));
    assert!(!site.path("c/calibrated.toml").exists());
}

#[test]
fn nothing_that_was_there_before_is_written_over() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| path_in(folder.path(), name);
    record(Path::new(&at("empty.csv")), 3, 0.0);
    let scales = "pitch,front_load,rear_load\n0,60000,60000\n0.1,50000,70000\n";
    for (name, text) in [
        ("notes.txt", "mine\n"),
        ("scales.csv", scales),
        ("other.json", "{}\n"),
    ] {
        std::fs::write(at(name), text).expect("writable");
    }
    let before = std::fs::read(at("empty.csv")).expect("there");
    let (empty, scales, notes, other) = (
        at("empty.csv"),
        at("scales.csv"),
        at("notes.txt"),
        at("other.json"),
    );
    let calibrate = ["calibrate", "excavator", &empty, "-o"];
    for words in [
        &[&calibrate[..], &[&empty]].concat()[..],
        &[&calibrate[..], &[&notes]].concat(),
        &[&calibrate[..], &[&at("new.toml"), "--report", &empty]].concat(),
        &["weigh", &scales, "--json", &scales],
        &["weigh", &scales, "--json", &other],
        &["map", &empty, "--machine", "excavator", "--output", &empty],
        &["map", &empty, "--machine", "excavator", "--output", &notes],
        &[
            "evaluate",
            "excavator",
            "--table",
            "table1",
            "--seeds",
            "1",
            "--json",
            &other,
        ],
    ] {
        let result = run(words);
        assert_eq!(
            result.status.code(),
            Some(2),
            "{words:?}: {}",
            both(&result)
        );
        says(&result, "choose another name");
    }
    assert_eq!(std::fs::read(&empty).expect("there"), before);
    assert_eq!(std::fs::read(&notes).expect("there"), b"mine\n");
    assert_eq!(std::fs::read(&other).expect("there"), b"{}\n");
    // An earlier result of the same command is.
    for _ in 0..2 {
        run_ok(&["weigh", &scales, "--json", &at("new.json")]);
    }
}
