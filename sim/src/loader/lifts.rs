//! Slow lifts for a calibration: the machine stands, and its arm moves fully up and down, twice.

use super::arm::Stance;
use crate::blend::transition;

/// Duration [s].
pub(super) const DURATION: f64 = 64.0;
/// Arm and bucket at the beginning [rad]; moves of the arm: from, to [s], by [rad].
const START: Stance = Stance {
    lift: -0.62,
    bucket: 0.85,
};
const MOVES: &[(f64, f64, f64)] = &[
    (2.0, 16.0, 1.1),
    (18.0, 31.0, -1.1),
    (33.0, 47.0, 1.1),
    (49.0, 62.0, -1.1),
];

/// Stance at a time; the linkage keeps the bucket level.
pub(super) fn stance(t: f64) -> Stance {
    let moved: f64 = MOVES.iter().map(|m| m.2 * transition(t, m.0, m.1)).sum();
    Stance {
        lift: START.lift + moved,
        ..START
    }
}

/// Whether the arm moves.
pub(super) fn moves(t: f64) -> bool {
    MOVES.iter().any(|m| (m.0..m.1).contains(&t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arm_ends_where_it_began_and_never_hurries() {
        assert!((stance(0.0).lift - stance(DURATION).lift).abs() < 1e-9);
        let rate = |t: f64| (stance(t + 0.01).lift - stance(t).lift) / 0.01;
        let fastest = (0..6400).map(|k| rate(0.01 * f64::from(k)).abs());
        assert!(fastest.fold(0.0, f64::max) < 0.17);
        assert!(moves(3.0) && !moves(17.0));
    }
}
