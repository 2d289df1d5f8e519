//! Gain kappa of the drive, force on the body over force of the reported torques, identified while the torques drive.

/// Memory of the gain: integral of the squared specific pull over the time of driving [m^2/s^3]. It starts with a tenth of it.
const MEMORY: f64 = 10.0;
/// Range of kappa by tolerances of mass and torque.
const RANGE: (f64, f64) = (0.75, 1.33);
/// Largest force per mass of a drive [m/s^2].
pub const LARGEST: f64 = 5.0;

/// Least squares of kappa, with forgetting.
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
    /// Adds `dt` in which the torques alone pull: `needed` is the force that the motion shows, `pull` that of the torques, both per
    /// mass [m/s^2].
    pub fn see(&mut self, needed: f64, pull: f64, dt: f64) {
        if pull.abs() < LARGEST && needed.abs() < LARGEST {
            let forget = 1.0 - (pull * pull * dt / MEMORY).min(1.0);
            self.sums[0] = forget * self.sums[0] + needed * pull * dt;
            self.sums[1] = forget * self.sums[1] + pull * pull * dt;
        }
    }

    /// Kappa, limited to what tolerances explain.
    pub fn value(&self) -> f64 {
        self.found().clamp(RANGE.0, RANGE.1)
    }

    /// Whether the torques move the machine otherwise than its mass explains, beyond tolerances.
    pub fn misfits(&self) -> bool {
        !(RANGE.0..=RANGE.1).contains(&self.found())
    }

    fn found(&self) -> f64 {
        self.sums[0] / self.sums[1]
    }
}
