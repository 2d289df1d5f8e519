//! Golden files of the loader, and their machine.
#![allow(dead_code)] // each test file uses its part

pub mod explicit;

use estimation::loader::LoadTransfer;
use estimation::loader::wheel_dynamics::{Tyres, WheelDynamics};
use serde_json::Value;

/// The machine of the paper, on rigid tyres that never skid.
pub fn dynamics(load_transfer: LoadTransfer) -> WheelDynamics {
    WheelDynamics {
        gravity: 9.81,
        mass: 4700.0,
        empty_mass: 4700.0,
        wheel_radius: 0.55,
        axle_inertia: 3.33,
        wheelbase: 2.3,
        bucket_reach: 1.7,
        rolling_resistance: 0.02,
        friction: f64::INFINITY,
        radius_load_sensitivity: 0.0,
        minimum_speed: 0.3,
        load_transfer,
        tyres: Tyres::ALIKE,
    }
}

/// A golden JSON file.
pub fn golden(name: &str) -> Value {
    serde_json::from_str(&text(name)).unwrap()
}

/// A golden file as text.
pub fn text(name: &str) -> String {
    let path = format!("{}/../../tests/golden/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// A number.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// A row of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

/// Rows of numbers.
pub fn matrix(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

/// A row of known length.
pub fn array<const N: usize>(value: &Value) -> [f64; N] {
    numbers(value).try_into().unwrap()
}

/// Largest difference relative to the largest golden entry.
pub fn deviation(ours: &[Vec<f64>], golden: &[Vec<f64>]) -> f64 {
    assert_eq!(ours.len(), golden.len(), "rows");
    let largest = golden.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let mut worst = 0.0_f64;
    for (a, b) in ours.iter().zip(golden) {
        assert_eq!(a.len(), b.len(), "columns");
        for (x, y) in a.iter().zip(b) {
            worst = worst.max((x - y).abs());
        }
    }
    worst / largest
}

/// Asserts that a matrix agrees with its golden one.
#[track_caller]
pub fn assert_matrix<const N: usize>(
    what: &str,
    ours: &[[f64; N]],
    golden: &Value,
    tolerance: f64,
) {
    let ours: Vec<Vec<f64>> = ours.iter().map(|r| r.to_vec()).collect();
    let error = deviation(&ours, &matrix(golden));
    assert!(error <= tolerance, "{what}: {error:e} > {tolerance:e}");
}

/// Asserts that a row agrees with its golden one.
#[track_caller]
pub fn assert_row(what: &str, ours: &[f64], golden: &Value, tolerance: f64) {
    let error = deviation(&[ours.to_vec()], &[numbers(golden)]);
    assert!(error <= tolerance, "{what}: {error:e} > {tolerance:e}");
}
