//! Start of the likelihood fit: equally filtered least squares (faer QR).
//!
//! The equation of motion is weighted with smooth windows phi that vanish at their ends (Shinbrot's
//! modulating functions), so that every signal has the same filter and none is differentiated:
//! ```text
//! int phi' w dJ_u + s int phi' L w + k int phi' B w + m int phi' g w
//!   + c_d int phi T_d + c_b int phi T_b - o int phi - b int phi w - T_f int phi sgn w = 0
//! ```
//! with c_d = eta/gain, c_b = 1/(eta gain), and the description with its tolerances as further rows.
//! Noise in the regressors leaves a bias of a few percent, which the likelihood removes.

use core::f64::consts::PI;

use faer::Mat;

use super::filter::Guess;
use super::series::{Load, Series, Swing};
use super::swings::{Role, Swings};
use crate::algebra;
use crate::model::Model;

/// Length of a window and distance between them [s].
const WINDOW: f64 = 0.4;
const SHIFT: f64 = 0.15;
/// Step and number of the delays that are tried, in either direction [s].
const DELAY_STEP: f64 = 0.005;
const DELAYS: i32 = 16;
/// Number of the equation's unknowns.
const UNKNOWNS: usize = 8;

/// Start of the fit, in prior standard deviations from the prior mean.
#[must_use]
pub fn start(swings: &Swings, blocks: &[usize], fixed: &[bool]) -> Vec<f64> {
    let mean: Vec<f64> = swings.parameters.iter().map(|p| p.mean).collect();
    let delay_free = swings.index(Role::Delay).is_some_and(|i| !fixed[i]);
    let delays = if delay_free { -DELAYS..=DELAYS } else { 0..=0 };
    let tries = delays.map(|k| f64::from(k) * DELAY_STEP);
    let best = tries
        .filter_map(|delay| solve(swings, blocks, fixed, &mean, delay))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let values = best.map_or(mean, |(_, values)| values);
    let parameters = swings.parameters.iter().zip(fixed).zip(&values);
    parameters
        .map(|((p, fixed), v)| if *fixed { 0.0 } else { p.place(*v) })
        .collect()
}

/// Sum of squares, prior included, and values of the parameters with one delay.
fn solve(
    swings: &Swings,
    blocks: &[usize],
    fixed: &[bool],
    mean: &[f64],
    delay: f64,
) -> Option<(f64, Vec<f64>)> {
    let mut rows: Vec<([f64; UNKNOWNS], f64)> = Vec::new();
    for &block in blocks {
        let recording = swings.recording(block);
        let guess = Guess {
            delay,
            ..swings.guess(recording, mean)
        };
        let (series, swing) = swings.swing(block);
        windows(series, swing, &guess, &mut rows);
    }
    let roles = [
        Role::Inertia,
        Role::Links,
        Role::Bucket,
        Role::Damping,
        Role::Friction,
        Role::Offset,
    ];
    let known: Vec<(f64, f64)> = roles
        .iter()
        .map(|role| prior(swings, fixed, *role))
        .chain(drive(swings, fixed))
        .collect();
    let count = rows.len();
    if count == 0 {
        return None;
    }
    let matrix = Mat::from_fn(count + UNKNOWNS, UNKNOWNS, |i, j| match rows.get(i) {
        Some((row, _)) => row[j] * known[j].1,
        None => f64::from(i - count == j),
    });
    // All relative to the prior: the solution is the distance from it.
    let right: Vec<f64> = (0..count + UNKNOWNS)
        .map(|i| match rows.get(i) {
            Some((row, right)) => right - row.iter().zip(&known).map(|(r, k)| r * k.0).sum::<f64>(),
            None => 0.0,
        })
        .collect();
    let found = algebra::least_squares(&matrix, &right);
    let residual: f64 = (0..count)
        .map(|i| {
            let fitted: f64 = (0..UNKNOWNS).map(|j| matrix[(i, j)] * found[j]).sum();
            (right[i] - fitted).powi(2).min(100.0)
        })
        .sum();
    // All torques and masses near zero fit any motion, so the prior counts too.
    let distance: f64 = found.iter().map(|x| x * x).sum();
    let at = |j: usize| known[j].0 + known[j].1 * found[j];
    let mut values = mean.to_vec();
    for (j, role) in roles.iter().enumerate() {
        set(swings, &mut values, *role, at(j));
    }
    let (driving, braking) = (at(6), at(7));
    if driving > 0.0 && braking > 0.0 {
        set(
            swings,
            &mut values,
            Role::Gain,
            1.0 / (driving * braking).sqrt(),
        );
        set(
            swings,
            &mut values,
            Role::Efficiency,
            (driving / braking).sqrt(),
        );
    }
    set(swings, &mut values, Role::Delay, delay);
    Some((residual + distance, values))
}

fn set(swings: &Swings, values: &mut [f64], role: Role, value: f64) {
    if let Some(i) = swings.index(role) {
        values[i] = value;
    }
}

/// Prior of an unknown: mean and standard deviation, 0 where it is held.
fn prior(swings: &Swings, fixed: &[bool], role: Role) -> (f64, f64) {
    match swings.index(role) {
        Some(i) if fixed[i] => (swings.parameters[i].mean, 0.0),
        Some(i) => (swings.parameters[i].mean, swings.parameters[i].std),
        None => (f64::from(matches!(role, Role::Links | Role::Bucket)), 0.0),
    }
}

/// The same for c_d and c_b, whose standard deviations are those of gain and efficiency.
fn drive(swings: &Swings, fixed: &[bool]) -> [(f64, f64); 2] {
    let one = |role| match swings.index(role) {
        Some(_) => prior(swings, fixed, role),
        None => (1.0, 0.0),
    };
    let ((gain, gain_std), (efficiency, efficiency_std)) = (one(Role::Gain), one(Role::Efficiency));
    let std = (gain_std.powi(2) + efficiency_std.powi(2)).sqrt();
    [(efficiency / gain, std), (1.0 / (efficiency * gain), std)]
}

/// The equation over the windows of a swing, divided by its noise.
fn windows(series: &Series, swing: &Swing, guess: &Guess, rows: &mut Vec<([f64; UNKNOWNS], f64)>) {
    let time = &series.time;
    let end = time[swing.rows.end - 1];
    let mut from = time[swing.rows.start];
    let load = match swing.load {
        Load::Stated => guess.payload,
        Load::Empty => 0.0,
    };
    while from + WINDOW <= end {
        let first = time.partition_point(|t| *t < from);
        let last = time.partition_point(|t| *t <= from + WINDOW);
        let mut row = [0.0; UNKNOWNS];
        let (mut moved, mut noise) = (0.0, 0.0);
        let mut cursor = series.torque.cursor(from - guess.delay);
        for k in first.max(1)..last {
            let dt = time[k] - time[k - 1];
            let phase = 2.0 * PI * (0.5 * (time[k] + time[k - 1]) - from) / WINDOW;
            let phi = 0.5 * (1.0 - phase.cos());
            let slope = PI / WINDOW * phase.sin();
            let velocity = 0.5 * (series.velocity[k] + series.velocity[k - 1]);
            let torque = series
                .torque
                .until(time[k] - guess.delay, &mut cursor)
                .since(&series.torque.until(time[k - 1] - guess.delay, &mut cursor));
            let [links, bucket] =
                [&series.links, &series.bucket].map(|part| 0.5 * (part[k] + part[k - 1]));
            let leverage = 0.5 * (series.leverage[k] + series.leverage[k - 1]);
            row[0] += slope * velocity * dt;
            row[1] += slope * velocity * links * dt;
            row[2] += slope * velocity * bucket * dt;
            row[3] -= phi * velocity * dt;
            row[4] -= phi * swing.direction * dt;
            row[5] -= phi * dt;
            row[6] += phi * torque.driving;
            row[7] += phi * torque.braking;
            let inertia = guess.upper_inertia + links + bucket + load * leverage;
            moved -= slope * velocity * load * leverage * dt;
            noise += (slope * inertia * guess.motion_std * dt).powi(2)
                + (phi * guess.torque_std * dt).powi(2);
        }
        let noise = noise.sqrt();
        if noise > 0.0 {
            rows.push((row.map(|r| r / noise), moved / noise));
        }
        from += SHIFT;
    }
}
