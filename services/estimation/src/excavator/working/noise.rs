//! How much of the torque the model leaves out: the factor by which the innovations are white.
//!
//! What no state explains shows as innovations that keep their sign for a while. Their sum over a tenth of a
//! second, normalised, has variance 1 where the assumed noise is right; the logarithm of the noise follows
//! what is too much or too little of it (gradient of the likelihood).

use crate::math::{exp, ln, sqrt};

/// Ticks of a sum.
const BLOCK: u32 = 10;
/// Step of the logarithm per sum and unit of excess.
const RATE: f64 = 0.1;
/// Smallest and largest factor of the variance.
const RANGE: [f64; 2] = [0.25, 400.0];

/// Factor of the variance of the torque.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Noise {
    logarithm: f64,
    scale: f64,
    sum: f64,
    count: u32,
}

impl Noise {
    pub(super) fn new() -> Self {
        Self {
            logarithm: 0.0,
            scale: 1.0,
            sum: 0.0,
            count: 0,
        }
    }

    /// One normalised innovation.
    pub(super) fn push(&mut self, z: f64) {
        self.sum += z.clamp(-4.0, 4.0);
        self.count += 1;
        if self.count == BLOCK {
            let z = self.sum / sqrt(f64::from(BLOCK));
            let [least, most] = RANGE.map(ln);
            self.logarithm = (self.logarithm + RATE * ((z * z).min(9.0) - 1.0)).clamp(least, most);
            self.scale = exp(self.logarithm);
            self.rest();
        }
    }

    /// The sum begins anew.
    pub(super) fn rest(&mut self) {
        self.sum = 0.0;
        self.count = 0;
    }

    /// Factor of the variance.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }
}
