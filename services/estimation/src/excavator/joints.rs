//! How far the joints of an excavator turn.

use core::f64::consts::{PI, TAU};

/// Arm and bucket turn up beyond the line of the link before them by no more [rad]; a boom may point anywhere. Recorded: none of the
/// arms reaches the line, buckets turn 0.3 beyond it.
const BEYOND: [f64; 3] = [TAU, 0.35, 1.2];

/// Whether boom, arm and bucket may be at these angles.
pub(in crate::excavator) fn possible(posture: [f64; 3]) -> [bool; 3] {
    core::array::from_fn(|i| turned(posture[i]) <= BEYOND[i])
}

/// The same angle within half a turn.
pub(in crate::excavator) fn turned(angle: f64) -> f64 {
    if angle.abs() <= PI {
        return angle;
    }
    let angle = angle % TAU;
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}
