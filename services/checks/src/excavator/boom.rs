//! Detects a boom angle of opposite sign.

use messages::{ExcavatorSensors, excavator_bits as bits};
use recording::Finding;

/// Counts swinging samples in which the boom points into the ground. No machine can swing like that.
#[derive(Default)]
pub(super) struct Boom {
    down: usize,
    all: usize,
}

impl Boom {
    /// Least swing velocity of a swinging sample [rad/s].
    const SWINGS: f64 = 0.1;
    /// Boom angle below which the boom points into the ground \[rad\].
    const DOWN: f64 = -0.2;
    /// Fewest samples for a verdict.
    const FEWEST: usize = 50;
}

impl Boom {
    pub(super) fn add(&mut self, s: &ExcavatorSensors) {
        let measured = bits::BOOM_ANGLE | bits::SWING_VELOCITY;
        if s.valid & measured == measured && s.swing_velocity.abs() > Self::SWINGS {
            self.all += 1;
            self.down += usize::from(s.boom_angle < Self::DOWN);
        }
    }

    pub(super) fn fault(&self) -> Option<Finding> {
        (self.all >= Self::FEWEST && 10 * self.down > 9 * self.all).then(|| {
            Finding::new(
                "boom_angle seems to have the other sign, or another zero: the boom points into the ground while the machine swings",
                "in the signal map `sign = -1`, or `offset` (up from the horizontal is positive)",
            )
        })
    }
}
