//! Force on the body over the force that the torques tell, kappa, learnt while they drive.

/// It is learnt over this many m/s^2 squared times seconds of driving, and starts with a tenth of it.
const MEMORY: f64 = 10.0;
/// What is beyond these is no tolerance of mass and torque.
const RANGE: (f64, f64) = (0.75, 1.33);
/// A force per mass beyond this is none of a drive [m/s^2].
pub const LARGEST: f64 = 5.0;

/// Memory of the driving.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gain {
    /// Sums of force times pull and of pull squared, per mass squared.
    sums: [f64; 2],
}

impl Default for Gain {
    fn default() -> Self {
        Self {
            sums: [0.1 * MEMORY; 2],
        }
    }
}

impl Gain {
    /// Takes `dt` in which the torques alone pull, and the force that the motion shows, both per mass [m/s^2].
    pub fn see(&mut self, needed: f64, pull: f64, dt: f64) {
        if pull.abs() < LARGEST && needed.abs() < LARGEST {
            let forget = 1.0 - (pull * pull * dt / MEMORY).min(1.0);
            self.sums[0] = forget * self.sums[0] + needed * pull * dt;
            self.sums[1] = forget * self.sums[1] + pull * pull * dt;
        }
    }

    /// As far as tolerances explain it.
    pub fn value(&self) -> f64 {
        self.found().clamp(RANGE.0, RANGE.1)
    }

    /// The torques do not move the machine as its mass says.
    pub fn misfits(&self) -> bool {
        !(RANGE.0..=RANGE.1).contains(&self.found())
    }

    fn found(&self) -> f64 {
        self.sums[0] / self.sums[1]
    }
}
