//! `heft calibrate loader` as a user runs it, on a simulated machine from production.

mod common;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Output;

use common::{both, run, run_ok, says};
use config::Tables as _;
use sim::loader::{Effects, Machine, Row, Run, Scenario, Simulation, Tier};

const MACHINE: u64 = 7;
const LOAD: f64 = 1500.0;
const OFFSET: f64 = 0.05;

/// A machine with its own tyres, a delayed speed and a misaligned accelerometer.
fn run_of(scenario: Scenario, course: u64, payload: Option<f64>) -> Run {
    Run {
        seed: 1000 * MACHINE + course,
        machine_seed: Some(MACHINE),
        tier: Tier::B,
        effects: Effects {
            speed_delay: 0.05,
            stiffness_difference: 0.06,
            stiffness_exponent: 0.1,
            radius_sensitivity: 0.003,
            acceleration_offset: OFFSET,
            ..Effects::default()
        },
        payload,
        duration: Some(100.0),
        ..Run::new(scenario)
    }
}

fn drive(run: &Run) -> Simulation {
    Simulation::new(run).expect("a run")
}

/// The path back from the end of a drive, of the same length.
fn back(there: &Run) -> Vec<Row> {
    let way = |rows: &[Row]| -> f64 {
        let steps = rows.windows(2);
        steps
            .map(|r| (r[1].time - r[0].time) * r[1].truth.speed)
            .sum()
    };
    let length = way(&drive(there).collect::<Vec<_>>());
    let run = Run {
        road_seed: Some(there.seed),
        turned_at: Some(length + 1.5),
        duration: Some(200.0),
        ..run_of(Scenario::Dither, 2, None)
    };
    let mut rows: Vec<Row> = drive(&run).collect();
    while way(&rows) > length {
        rows.truncate(rows.len() - 100);
    }
    rows
}

struct Recordings {
    folder: tempfile::TempDir,
    machine: Machine,
    slope_bias: f64,
}

impl Recordings {
    fn new() -> Self {
        let flat = run_of(Scenario::WorkCycle, 1, None);
        let recordings = Self {
            folder: tempfile::tempdir().expect("a folder"),
            machine: *drive(&flat).machine(),
            slope_bias: drive(&flat).slope_bias(),
        };
        recordings.write("flat.csv", drive(&flat));
        recordings.write("back.csv", back(&flat).into_iter());
        recordings.write(
            "loaded.csv",
            drive(&run_of(Scenario::Dither, 3, Some(LOAD))),
        );
        let light = run_of(Scenario::Dither, 4, Some(0.1 * LOAD));
        recordings.write("light.csv", drive(&light));
        recordings.write("still.csv", drive(&flat).take(40));
        let mut scales = "pitch,front_load,rear_load\n".to_owned();
        let m = &recordings.machine;
        for pitch in [0.0, 0.0, 0.12, -0.12] {
            let share = m.cg_ratio - m.cg_height / m.wheelbase * f64::tan(pitch);
            let weight = 9.81 * m.mass;
            let _ = writeln!(
                scales,
                "{pitch},{},{}",
                share * weight,
                (1.0 - share) * weight
            );
        }
        std::fs::write(recordings.path("scales.csv"), scales).expect("a file");
        recordings
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, rows: impl Iterator<Item = sim::loader::Row>) {
        let mut text = "t,speed,front_wheel_speed,rear_wheel_speed,front_torque,rear_torque,slope,acceleration\n".to_owned();
        for r in rows {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{}",
                r.time,
                r.speed,
                r.front_wheel_speed,
                r.rear_wheel_speed,
                r.front_torque,
                r.rear_torque,
                r.slope,
                r.acceleration
            );
        }
        std::fs::write(self.path(name), text).expect("a file");
    }

    /// Calibrates from some of the files, with further arguments.
    fn calibrate(&self, files: &[&str], more: &[&str]) -> (Output, PathBuf) {
        let text = |p: &Path| p.to_str().expect("a path").to_owned();
        let output = self.path("machine.toml");
        let mut words = vec!["calibrate".to_owned(), "loader".to_owned()];
        words.extend(files.iter().map(|f| text(&self.path(f))));
        words.extend(more.iter().map(|w| (*w).to_owned()));
        words.extend(["-o".to_owned(), text(&output)]);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        (run(&words), output)
    }
}

/// Within three of the stated standard deviations, and these no larger than a calibration needs.
fn assert_is_of_the_machine(d: &config::Loader, recordings: &Recordings) {
    let m = &recordings.machine;
    for (what, found, std, truth, useful) in [
        (
            "load sensitivity",
            d.machine.radius_load_sensitivity,
            d.machine.radius_load_sensitivity_std,
            m.radius_load_sensitivity,
            5e-4,
        ),
        (
            "stiffness ratio",
            d.machine.stiffness_ratio,
            d.machine.stiffness_ratio_std,
            1.0 + m.stiffness_difference,
            0.02,
        ),
        (
            "load exponent",
            d.machine.stiffness_load_exponent,
            d.machine.stiffness_load_exponent_std,
            m.stiffness_exponent,
            0.04,
        ),
        (
            "delay",
            d.sensors.speed_delay,
            d.sensors.speed_delay_std,
            0.05,
            5e-3,
        ),
        (
            "zero of the accelerometer",
            d.sensors.acceleration_offset,
            d.sensors.acceleration_offset_std,
            OFFSET,
            0.02,
        ),
        (
            "zero of the slope",
            d.prior.slope_bias,
            d.prior.slope_bias_std,
            recordings.slope_bias,
            3e-3,
        ),
        (
            "rolling resistance",
            d.machine.rolling_resistance,
            // Stated as a comment.
            1e-4,
            m.rolling_resistance,
            2e-4,
        ),
        (
            "front radius",
            d.prior.front_radius_error,
            d.prior.radius_std,
            m.front_radius_error,
            1e-3,
        ),
        (
            "slip stiffness",
            d.prior.slip_stiffness,
            d.prior.slip_stiffness_std,
            m.slip_stiffness,
            1.5,
        ),
    ] {
        assert!(
            (found - truth).abs() < 3.0 * std && std < useful,
            "{what}: {found} ± {std} for {truth}"
        );
    }
}

#[test]
fn three_drives_and_axle_scales_find_the_machine_within_its_intervals() {
    let recordings = Recordings::new();
    let scales = recordings.path("scales.csv");
    let scales = scales.to_str().expect("a path");
    let (result, output) = recordings.calibrate(
        &["flat.csv", "back.csv", "loaded.csv"],
        &[
            "--mass",
            "loaded.csv=6200±30",
            "--weigh",
            scales,
            "--there-and-back",
            "flat.csv,back.csv",
        ],
    );
    says(&result, "go the same way");
    assert!(result.status.success(), "{}", both(&result));
    run_ok(&["check", output.to_str().expect("a path")]);
    let text = std::fs::read_to_string(&output).expect("a file");
    let d = config::Loader::parse(&text, "machine.toml").expect("a description");
    assert_is_of_the_machine(&d, &recordings);
    assert!(text.contains("sha256") && text.contains("Correlations"));
}

#[test]
fn an_empty_and_a_loaded_drive_tell_the_tyres_apart_from_the_load_without_axle_scales() {
    let recordings = Recordings::new();
    let (result, output) = recordings.calibrate(
        &["flat.csv", "back.csv", "loaded.csv"],
        &["--mass", "loaded.csv=6200±30"],
    );
    assert!(result.status.success(), "{}", both(&result));
    let text = std::fs::read_to_string(&output).expect("a file");
    let d = config::Loader::parse(&text, "machine.toml").expect("a description");
    let m = &recordings.machine;
    for (found, std, truth, useful) in [
        (
            d.machine.radius_load_sensitivity,
            d.machine.radius_load_sensitivity_std,
            m.radius_load_sensitivity,
            5e-4,
        ),
        (d.prior.cg_ratio, d.prior.cg_ratio_std, m.cg_ratio, 0.05),
    ] {
        assert!(
            (found - truth).abs() < 3.0 * std && std < useful,
            "{found} ± {std} for {truth}"
        );
    }
}

#[test]
fn what_cannot_be_trusted_is_reported_and_not_written() {
    let recordings = Recordings::new();
    let scales = recordings.path("scales.csv");
    let scales = scales.to_str().expect("a path");
    let all: &[&str] = &["flat.csv", "back.csv", "loaded.csv"];
    for (files, more, sentence) in [
        (
            all,
            &["--mass", "loaded.csv=5450±30", "--weigh", scales][..],
            "was stated as 5450 kg",
        ),
        (&all[..2], &["--weigh", scales], "the same load"),
        (&["still.csv"], &["--weigh", scales], "stands still"),
        (
            &["flat.csv", "back.csv", "light.csv"],
            &["--mass", "light.csv=4850±30"],
            "weigh both axles",
        ),
    ] {
        let (result, output) = recordings.calibrate(files, more);
        assert_eq!(result.status.code(), Some(1), "{}", both(&result));
        says(&result, sentence);
        assert!(!output.exists(), "{sentence}");
    }
    for (files, more, sentence) in [
        (all, &["--mass", "loaded.csv=0"][..], "stated as nothing"),
        (
            all,
            &["--mass", "loaded.csv=6200", "--mass", "loaded.csv=6300"],
            "is stated twice",
        ),
        (&["flat.csv", "flat.csv"], &[], "is named twice"),
    ] {
        let (result, output) = recordings.calibrate(files, more);
        assert_eq!(result.status.code(), Some(2), "{}", both(&result));
        says(&result, sentence);
        assert!(!output.exists(), "{sentence}");
    }
}
