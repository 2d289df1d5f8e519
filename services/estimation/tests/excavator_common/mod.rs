//! Reading of the golden files, shared by the excavator tests.
#![allow(dead_code, reason = "each test binary uses its part")]

use estimation::excavator::{Columns, Method, Sample, Settings};
use std::collections::HashMap;

/// A CSV with `#` lines before its header.
pub struct Table {
    columns: HashMap<String, usize>,
    /// Cells as written.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a golden file.
    pub fn golden(name: &str) -> Self {
        let path = format!(
            "{}/../../tests/golden/excavator_{name}",
            env!("CARGO_MANIFEST_DIR")
        );
        Self::read(&path).unwrap_or_else(|| panic!("{path}"))
    }

    /// Reads any file, if it is there.
    pub fn read(path: &str) -> Option<Self> {
        let text = std::fs::read_to_string(path).ok()?;
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let header = lines.next()?;
        let columns = header.split(',').enumerate();
        Some(Self {
            columns: columns.map(|(i, name)| (name.to_string(), i)).collect(),
            rows: lines
                .map(|line| line.split(',').map(str::to_string).collect())
                .collect(),
        })
    }

    /// Cell as a number; `None` where it is empty or the column does not exist.
    pub fn get(&self, row: usize, name: &str) -> Option<f64> {
        let column = *self.columns.get(name)?;
        self.rows[row].get(column)?.parse().ok()
    }

    /// A whole column without gaps.
    pub fn column(&self, name: &str) -> Vec<f64> {
        (0..self.rows.len())
            .map(|i| self.get(i, name).unwrap_or_else(|| panic!("{name} {i}")))
            .collect()
    }
}

/// The rows of a golden input.
pub fn samples(table: &Table) -> Vec<Sample> {
    (0..table.rows.len())
        .map(|i| Sample {
            time: table.get(i, "t").unwrap(),
            velocity: table.get(i, "swing_velocity"),
            angle: None,
            torque: table.get(i, "swing_torque"),
            posture: ["boom_angle", "arm_angle", "bucket_angle"].map(|name| table.get(i, name)),
            inclination: [None; 2],
            ..Sample::default()
        })
        .collect()
}

/// All columns of the golden inputs.
pub const COLUMNS: Columns = Columns {
    velocity: true,
    angle: false,
    torque: true,
    posture: true,
};

/// Settings of the golden runs: no calibration, and the torque noise as if the means of two samples
/// were independent.
pub fn golden_settings() -> Settings {
    let mut settings = Settings::calibrated();
    settings.estimator.calibrate_at_rest = false;
    settings.estimator.torque_noise_divisor = 1.41;
    settings
}

/// `a` and `b` agree relatively, or absolutely near zero.
pub fn close(a: f64, b: f64, relative: f64, absolute: f64) -> bool {
    (a - b).abs() <= (relative * b.abs()).max(absolute)
}

/// The method's columns only.
pub fn columns_for(method: Method) -> Columns {
    Columns {
        torque: matches!(
            method,
            Method::PostureTorque | Method::Torque | Method::SvfRls
        ),
        posture: matches!(method, Method::PostureTorque | Method::Posture),
        ..COLUMNS
    }
}
