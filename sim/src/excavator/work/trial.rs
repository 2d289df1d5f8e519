//! The course of a calibration: swings with the arm in and out, then slow full lifts while the upper body stands, with a constant
//! load.

use super::super::path::Posture;

/// Swings to and fro before the lifts.
pub(super) const CYCLES: u32 = 12;
/// Boom in the swings: down on the outward swing, up on the return \[rad\].
const BOOM: [f64; 2] = [0.6, 0.9];
/// Arm in and out \[rad\].
const ARM: [f64; 2] = [-2.2, -1.4];
/// Bucket angle that holds the load \[rad\].
const BUCKET: f64 = -1.45;
/// Lowest and highest boom of a lift \[rad\], time of a move and of the stop before it \[s\].
const LIFT: [f64; 2] = [0.25, 1.0];
const MOVE: f64 = 9.0;
const STAND: f64 = 2.0;

/// Target posture of a cycle, on the outward swing or the return.
pub(super) fn posture(cycle: u32, there: bool) -> Posture {
    let arm = ARM[(cycle / 2 % 2) as usize];
    [BOOM[usize::from(!there)], arm, BUCKET]
}

/// Target posture at a time since the begin of the lifts \[s\]: endless, up and down with the arm in and with the arm out.
pub(super) fn lift(since: f64) -> Posture {
    let [low, high] = LIFT;
    let leg = since / (STAND + MOVE);
    let done = (leg.fract() * (STAND + MOVE) - STAND).max(0.0) / MOVE;
    let up = (leg as u32).is_multiple_of(2);
    let share = if up { done } else { 1.0 - done };
    let arm = ARM[(leg as u32 / 2 % 2) as usize];
    [low + share * (high - low), arm, BUCKET]
}
