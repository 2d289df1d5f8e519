//! Detects unrecorded friction brakes as a bend in the balance of force.
//!
//! Least squares of the residuals of the balance at the fit, on the specific force P of the torques:
//! ```text
//! residual = c_0 + c_1 P + c_2 |P|
//! ```
//! -2 c_2 is the difference of braking and driving in force per torque; gain and rolling resistance absorb the rest.

use faer::Mat;

use super::drives::Drives;
use super::residuals::pairs;
use crate::algebra;
use crate::fit::values;
use crate::model::Model;

/// Smallest reported difference between braking and driving, relative and in standard deviations.
const WORTH: f64 = 0.04;
const SURE: f64 = 5.0;

/// Reports a difference between braking and driving.
pub fn differ(model: &Drives, place: &[f64]) -> Option<String> {
    let points = points(model, place);
    let matrix = Mat::from_fn(points.len(), 3, |i, j| {
        let pull = points[i].0;
        [1.0, pull, pull.abs()][j]
    });
    let curvature = matrix.transpose() * &matrix;
    let covariance = algebra::inverse(&curvature)?;
    let right: Vec<f64> = points.iter().map(|p| p.1).collect();
    let c = algebra::least_squares(&matrix, &right);
    let rest = points
        .iter()
        .map(|(pull, r)| (r - c[0] - c[1] * pull - c[2] * pull.abs()).powi(2));
    let variance = rest.sum::<f64>() / points.len().saturating_sub(3).max(1) as f64;
    let difference = -2.0 * c[2];
    let std = 2.0 * (variance * covariance[(2, 2)]).max(0.0).sqrt();
    (difference.abs() > WORTH.max(SURE * std)).then(|| {
        format!(
            "per torque, braking differs from driving by {:+.0} ± {:.0} %: friction brakes act that are not recorded, or the torques are not those of the wheels; brake with the drive alone, or record when the brake acts (column brake)",
            100.0 * difference,
            100.0 * std
        )
    })
}

/// Specific force of the torques, and the residual of the balance [m/s^2], of every bin. Without an accelerometer the residual is that of
/// the motion of every pair of windows.
fn points(model: &Drives, place: &[f64]) -> Vec<(f64, f64)> {
    let values = values(model, place);
    let mut points = Vec::new();
    for (block, drive, stretch) in model.stretches() {
        let mut innovations = Vec::new();
        model.innovations(block, &values, &mut innovations);
        let bins = drive.bins(stretch);
        let mut add = |rows: &[(usize, f64)], residual: f64| {
            let weight: f64 = rows.iter().map(|(_, w)| w).sum();
            let torque = |k: usize| drive.torques[0][k] + drive.torques[1][k];
            let torque: f64 = rows.iter().map(|(k, w)| w * torque(*k)).sum();
            let forward = drive.wheels[0][rows[0].0].signum();
            let pull = super::GRAVITY * forward * torque / weight / model.torque_of_weight();
            if pull.is_finite() {
                points.push((pull, forward * residual));
            }
        };
        if drive.has_acceleration {
            for (bin, of) in bins.into_iter().zip(innovations.chunks(3)) {
                let rows: Vec<_> = bin.map(|k| (k, 1.0)).collect();
                add(&rows, of[2].value);
            }
        } else {
            let motion = &innovations[2 * bins.len()..];
            for (pair, of) in pairs(drive, stretch).iter().zip(motion) {
                let rows: Vec<_> = pair.steps().collect();
                let time =
                    |(k, weight): &(usize, f64)| weight * (drive.time[k + 1] - drive.time[*k]);
                add(&rows, of.value / rows.iter().map(time).sum::<f64>());
            }
        }
    }
    points
}
