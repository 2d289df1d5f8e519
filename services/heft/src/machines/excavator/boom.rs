//! A boom angle with the other sign.

use messages::{ExcavatorSensors, excavator_bits as bits};

/// Does the boom point into the ground in nearly every sample in which an excavator swings? No machine can.
#[derive(Default)]
pub(super) struct Boom {
    down: usize,
    all: usize,
}

impl Boom {
    /// Swinging from this velocity on [rad/s].
    const SWINGS: f64 = 0.1;
    /// Down from this angle on \[rad\].
    const DOWN: f64 = -0.2;
    /// Fewest samples that tell.
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

    pub(super) fn fault(&self) -> Option<String> {
        (self.all >= Self::FEWEST && 10 * self.down > 9 * self.all).then(|| {
            "boom_angle seems to have the other sign, or another zero: the boom points into the ground while the machine swings\n  \
             what to do: in the signal map `sign = -1`, or `offset` (up from the horizontal is positive)"
                .into()
        })
    }
}
