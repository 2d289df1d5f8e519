//! Estimates of an excavator's estimator for rows of a simulation.

use estimation::excavator::{Columns, Estimate, Method, Sample, Settings, SwingEstimator};
use sim::excavator::Row;

const COLUMNS: Columns = Columns {
    velocity: true,
    angle: false,
    torque: true,
    posture: true,
};

/// Each row with its estimate.
pub fn estimates(
    rows: impl Iterator<Item = Row>,
    settings: &Settings,
    method: Method,
) -> Vec<(Row, Estimate)> {
    let mut estimator = SwingEstimator::new(settings, method, COLUMNS).expect("an estimator");
    let estimates = rows.map(|row| {
        let sample = Sample {
            time: row.time,
            velocity: row.swing_velocity,
            torque: row.swing_torque,
            posture: row.posture,
            ..Sample::default()
        };
        (row, estimator.step(&sample))
    });
    estimates.collect()
}
