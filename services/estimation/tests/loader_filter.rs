//! Whole filter runs against `tests/golden/loader_filter_*.json`, through the public estimator.

mod loader_common;

use estimation::loader::settings::{Estimator, Machine, Prior, Settings};
use estimation::loader::{CgEstimator, Columns, LoadTransfer, Method, Sample, Status};
use loader_common::{golden, matrix, number, numbers, text};
use serde_json::Value;

/// The rows and the columns of an input file.
fn samples(file: &str) -> (Vec<Sample>, Columns) {
    let text = text(file);
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let has = |name: &str| names.contains(&name);
    let columns = Columns {
        acceleration: has("acceleration"),
    };
    let rows = lines.map(|line| sample(&names, line)).collect();
    (rows, columns)
}

fn sample(names: &[&str], line: &str) -> Sample {
    let mut s = Sample {
        time: f64::NAN,
        ..Sample::default()
    };
    for (name, cell) in names.iter().zip(line.split(',')) {
        let value = cell.trim().parse().ok();
        match *name {
            "t" => s.time = value.unwrap_or(f64::NAN),
            "speed" => s.speed = value,
            "front_wheel_speed" => s.front_wheel_speed = value,
            "rear_wheel_speed" => s.rear_wheel_speed = value,
            "front_torque" => s.front_torque = value,
            "rear_torque" => s.rear_torque = value,
            "slope" => s.slope = value,
            "acceleration" => s.acceleration = value,
            "mass" => s.mass = value,
            "spade_force_x" => s.spade_force_x = value,
            "spade_force_z" => s.spade_force_z = value,
            "boom_moving" => s.boom_moving = value == Some(1.0),
            _ => {}
        }
    }
    s
}

/// Method and settings of a golden run.
fn configuration(name: &str) -> (Method, Settings) {
    let paper = Settings::PAPER;
    let printed_sign = Settings {
        estimator: Estimator {
            load_transfer: LoadTransfer::Printed,
            ..paper.estimator
        },
        ..paper
    };
    let specified = Settings::SPECIFIED;
    let close_points = Settings {
        estimator: Estimator {
            alpha: 0.01,
            ..specified.estimator
        },
        ..specified
    };
    match name {
        "isr_printed_physical_sign" => (Method::IsrUkfPrinted, paper),
        "isr_printed_printed_sign" => (Method::IsrUkfPrinted, printed_sign),
        "isr_consistent_n6" => (Method::IsrUkf, paper),
        "ekf_n6" => (Method::Ekf, paper),
        "tuned_n6" => (Method::IsrUkf, Settings::TUNED),
        "recommended_n10" => (Method::Full, specified),
        "recommended_n10_alpha001" => (Method::Full, close_points),
        "recommended_n10_ekf" => (Method::FullEkf, specified),
        other => panic!("unknown run {other}"),
    }
}

fn stated(file: &Value, settings: Settings, stated_sensitivity: f64) -> Settings {
    let initial = &file["initial_state"];
    Settings {
        machine: Machine {
            radius_load_sensitivity: stated_sensitivity,
            radius_load_sensitivity_std: 0.001,
            ..Machine::default()
        },
        prior: Prior {
            slip_stiffness: number(&initial["K"]),
            cg_height: number(&initial["h"]),
            cg_ratio: number(&initial["lambda"]),
            slip_stiffness_std: 2.0,
            cg_height_std: 0.10,
            cg_ratio_std: 0.05,
            ..Prior::default()
        },
        ..settings
    }
}

fn state_std(estimator: &CgEstimator) -> Vec<f64> {
    (0..estimator.state().len())
        .map(|i| estimator.state_std(i))
        .collect()
}

/// Compares states in units of the golden standard deviation, and standard deviations relatively.
#[track_caller]
fn compare(what: &str, ours: (&[f64], &[f64]), golden: (&[f64], &[f64]), tolerance: (f64, f64)) {
    for i in 0..golden.0.len() {
        let error = (ours.0[i] - golden.0[i]).abs() / golden.1[i];
        assert!(
            error <= tolerance.0,
            "{what}, quantity {i}: {} {} off by {error:e} sd",
            ours.0[i],
            golden.0[i]
        );
        let error = (ours.1[i] / golden.1[i] - 1.0).abs();
        assert!(
            error <= tolerance.1,
            "{what}, sd {i}: {} {} off by {error:e}",
            ours.1[i],
            golden.1[i]
        );
    }
}

fn check_run(
    file: &Value,
    samples: &[Sample],
    columns: Columns,
    name: &str,
    sensitivity: f64,
) -> Vec<Status> {
    let run = &file["filters"][name];
    // The tolerance is that of the file: alpha = 0.01 amplifies rounding.
    let tolerance = if run["tolerance"].as_str().unwrap().contains("1e-5") {
        (1e-5, 1e-7)
    } else {
        (1e-8, 1e-9)
    };
    let (method, settings) = configuration(name);
    let mut estimator =
        CgEstimator::new(&stated(file, settings, sensitivity), method, columns).unwrap();
    let mut first_rows = run["first_rows"].as_array().unwrap().iter().peekable();
    let mut rows = matrix(&run["rows"]).into_iter().peekable();
    let mut statuses = Vec::new();
    for (k, sample) in samples.iter().enumerate() {
        let answer = estimator.step(sample);
        statuses.push(answer.status);
        let (x, sd) = (estimator.state().to_vec(), state_std(&estimator));
        let what = format!("{name}, row {k}");
        if let Some(first) = first_rows.next_if(|r| number(&r["row"]) as usize == k) {
            compare(
                &what,
                (&x, &sd),
                (&numbers(&first["x"]), &numbers(&first["sd"])),
                tolerance,
            );
            let used = if x.len() == 10 { 4.0 } else { 3.0 };
            let nis = number(&first["nis"]);
            // The NIS of a row may be near zero by cancellation: the tolerance is relative to at least 1.
            assert!(
                (answer.nis * used - nis).abs() <= 10.0 * tolerance.0 * nis.max(1.0),
                "{what}: nis"
            );
        }
        if let Some(row) = rows.next_if(|r| r[0] as usize == k) {
            let pick = |v: &[f64]| [v[0], v[3], v[4], v[5]];
            compare(
                &what,
                (&pick(&x), &pick(&sd)),
                (&row[1..5], &row[5..9]),
                tolerance,
            );
        }
    }
    assert!(
        rows.next().is_none() && first_rows.next().is_none(),
        "{name}: rows left over"
    );
    let (x, sd) = (estimator.state().to_vec(), state_std(&estimator));
    let final_sd: Vec<f64> = matrix(&run["final_sqrt_cov"])
        .iter()
        .map(|row| row.iter().map(|x| x * x).sum::<f64>().sqrt())
        .collect();
    compare(
        &format!("{name}, end"),
        (&x, &sd),
        (&numbers(&run["final_state"]), &final_sd),
        tolerance,
    );
    statuses
}

fn check_file(name: &str, sensitivity: f64) {
    let file = golden(name);
    let (samples, columns) = samples(file["input_file"].as_str().unwrap());
    for run in file["filters"].as_object().unwrap().keys() {
        check_run(&file, &samples, columns, run, sensitivity);
    }
}

#[test]
fn every_filter_follows_the_reference_on_a_bumpy_drive() {
    check_file("loader_filter_S1_tierA.json", 0.0);
}

#[test]
fn every_filter_follows_the_reference_on_a_real_machine_that_accelerates_and_brakes() {
    check_file("loader_filter_S4_tierB.json", 0.0105);
}

#[test]
fn every_filter_follows_the_reference_on_a_work_cycle() {
    check_file("loader_filter_S6_60s_tierA.json", 0.0);
}

#[test]
fn bad_rows_are_treated_as_the_reference_treats_them() {
    let file = golden("loader_filter_bad_20s.json");
    let (samples, columns) = samples(file["input_file"].as_str().unwrap());
    let statuses = check_run(&file, &samples, columns, "recommended_n10", 0.0);
    let special: Vec<(usize, &str)> = statuses
        .iter()
        .enumerate()
        .filter_map(|(k, status)| match status {
            Status::First => Some((k, "first")),
            Status::Refused => Some((k, "ignored")),
            Status::Gap => Some((k, "gap")),
            Status::Updated => None,
            other => panic!("row {k}: {other:?}"),
        })
        .collect();
    let golden: Vec<(usize, &str)> = file["filters"]["recommended_n10"]["row_status"]
        .as_array()
        .unwrap()
        .iter()
        .map(|r| (number(&r[0]) as usize, r[1].as_str().unwrap()))
        .collect();
    assert_eq!(special, golden);
}
