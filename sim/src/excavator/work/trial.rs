//! What a calibration asks for: swings with the arm in and out, then slow full lifts while the upper body stands. The load stays.

use super::super::path::Posture;

/// Swings to and fro before the lifts.
pub(super) const CYCLES: u32 = 12;
/// Boom in the swings: down on the way there, up on the way back \[rad\].
const BOOM: [f64; 2] = [0.6, 0.9];
/// Arm in and out \[rad\].
const ARM: [f64; 2] = [-2.2, -1.4];
/// The bucket holds its load \[rad\].
const BUCKET: f64 = -1.45;
/// Lowest and highest boom of a lift \[rad\], time of a way and of the stands between \[s\].
const LIFT: [f64; 2] = [0.25, 1.0];
const WAY: f64 = 9.0;
const STAND: f64 = 2.0;

/// Posture that is aimed at in a cycle, on the way there or back.
pub(super) fn posture(cycle: u32, there: bool) -> Posture {
    let arm = ARM[(cycle / 2 % 2) as usize];
    [BOOM[usize::from(!there)], arm, BUCKET]
}

/// The same, so long after the lifts began \[s\]: up and down with the arm in and with the arm out, without end.
pub(super) fn lift(since: f64) -> Posture {
    let [low, high] = LIFT;
    let leg = since / (STAND + WAY);
    let done = (leg.fract() * (STAND + WAY) - STAND).max(0.0) / WAY;
    let up = (leg as u32).is_multiple_of(2);
    let share = if up { done } else { 1.0 - done };
    let arm = ARM[(leg as u32 / 2 % 2) as usize];
    [low + share * (high - low), arm, BUCKET]
}
