//! Angle, torque and velocity of the same instant from an encoder.
//!
//! The direction of friction needs a velocity, and a causal one is late: at a reversal a few
//! milliseconds shift the estimated friction and damping by several percent. So the velocity is the
//! central difference over 2D samples, and angle and torque are delayed by D samples to match it. D is
//! as small as the noise of the angle permits.

use crate::excavator::settings::Settings;
use crate::math::sqrt;

/// Largest D.
const LARGEST: usize = 32;
const RING: usize = 2 * LARGEST + 1;

/// Signals of one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::excavator) struct Aligned {
    /// Angle [rad].
    pub(in crate::excavator) angle: f64,
    /// Torque [N m].
    pub(in crate::excavator) torque: f64,
    /// Velocity [rad/s].
    pub(in crate::excavator) velocity: f64,
}

/// Stores the last samples.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Aligner {
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    ring: [(f64, f64, f64); RING],
    count: usize,
    half: usize,
}

impl Aligner {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        let (s, e) = (&settings.sensors, &settings.estimator);
        // With 2D samples the standard deviation of the difference is half the width of the friction's sign.
        let noise = 2.0 * sqrt(2.0) * s.swing_angle_std * s.rate;
        let samples = noise / e.svf_friction_width;
        Self {
            ring: [(0.0, 0.0, 0.0); RING],
            count: 0,
            half: (0.5 * samples.min(1e6) + 0.999) as usize,
        }
        .limited()
    }

    fn limited(mut self) -> Self {
        self.half = self.half.clamp(1, LARGEST);
        self
    }

    /// Takes one sample. Before the first 2D samples, the difference uses those that are there.
    pub(in crate::excavator) fn push(&mut self, time: f64, angle: f64, torque: f64) -> Aligned {
        self.ring[self.count % RING] = (time, angle, torque);
        self.count += 1;
        let back = |n: usize| self.ring[(self.count - 1 - n.min(self.count - 1)) % RING];
        let (then, earlier, _) = back(2 * self.half);
        let span = time - then;
        Aligned {
            angle: back(self.half).1,
            torque: back(self.half).2,
            velocity: if span > 0.0 {
                (angle - earlier) / span
            } else {
                0.0
            },
        }
    }
}
