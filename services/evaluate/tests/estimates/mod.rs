//! What an excavator's estimator says of rows.

use estimation::excavator::{Columns, Estimate, Method, Sample, Settings, SwingEstimator};
use sim::excavator::Row;

const COLUMNS: Columns = Columns {
    velocity: true,
    angle: false,
    torque: true,
    posture: true,
};

/// Each row with what is said of it.
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
