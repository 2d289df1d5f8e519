//! Indices of the drawing's numbers in its arrays.

pub(super) const LENGTH: usize = 0;
pub(super) const MASS: usize = 1;
pub(super) const MASS_DISTANCE: usize = 2;
pub(super) const BUCKET: usize = 3;
pub(super) const LOAD_DISTANCE: usize = 4;
pub(super) const HEAD_AREA: usize = 5;
pub(super) const ROD_AREA: usize = 6;
pub(super) const BASE: usize = 7;
pub(super) const EYE: usize = 8;
pub(super) const CYLINDER_ANGLE: usize = 9;
pub(super) const PIVOT_X: usize = 10;
pub(super) const PIVOT_Z: usize = 11;
pub(super) const EMPTY_MASS: usize = 12;
pub(super) const EMPTY_RATIO: usize = 13;
pub(super) const EMPTY_HEIGHT: usize = 14;
pub(super) const FRICTION: usize = 15;
pub(super) const HEAD_ZERO: usize = 16;
pub(super) const ROD_ZERO: usize = 17;
pub(super) const LIFT_ZERO: usize = 18;
pub(super) const TILT_ZERO: usize = 19;
/// Mass of the bucket beyond that of the one with which the empty machine was weighed.
pub(super) const EXCHANGED: usize = 20;
/// Turn of the bucket per turn of the arm, tilt cylinder held.
pub(super) const TURN: usize = 21;
/// Relative error of the moment, by the pressures' gain or after a calibration; zero error of the force, by a calibration alone.
pub(super) const SPAN: usize = 22;
pub(super) const OFFSET: usize = 23;
/// Number of them.
pub(super) const NUMBERS: usize = 24;

/// Which results depend on a number: only these are computed again when it moves.
pub(super) struct Moves {
    /// Places of masses and cylinder.
    pub stance: bool,
    /// Payload by the pressures.
    pub moment: bool,
    /// Centre of gravity of the empty machine.
    pub centre: bool,
}

impl Moves {
    /// Results that depend on this number.
    pub const fn of(number: usize) -> Self {
        let (stance, moment, centre) = match number {
            LENGTH | MASS_DISTANCE | LOAD_DISTANCE | LIFT_ZERO | TILT_ZERO => (true, true, true),
            BASE | EYE | CYLINDER_ANGLE => (true, true, false),
            MASS | BUCKET | EXCHANGED => (false, true, true),
            PIVOT_X | PIVOT_Z | EMPTY_MASS | EMPTY_RATIO | EMPTY_HEIGHT => (false, false, true),
            _ => (false, true, false),
        };
        Self {
            stance,
            moment,
            centre,
        }
    }
}
