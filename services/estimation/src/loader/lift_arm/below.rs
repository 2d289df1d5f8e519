//! Detects a payload outside its physical range: below 0, or beyond what the rear axle balances. It shows that a stated number is off by
//! more than its standard deviation.
//!
//! ```text
//! z = max(-m_p, m_p - m_max)/sigma,   averaged over some seconds,   m_max: lam = 1
//! ```
//! Where the ground may carry a part of the bucket, a payload below 0 is possible and not tested.
//!
//! The data do not identify which number it is: a sensor's zero, the arm's weight, a cylinder's area. So the largest z beyond 1 multiplies
//! the effects of all of them on the answer. It decays over minutes.

use crate::Quantity;

/// Averaging time of z [s].
const MEMORY: f64 = 3.0;
/// Time constant with which the largest z decays [s].
const FADES: f64 = 300.0;
/// z beyond which the machine file is wrong: 1 in 40 by chance.
const WRONG: f64 = 2.0;

/// Average and largest z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Below {
    mean: f64,
    largest: f64,
}

impl Below {
    /// Updates with a payload and its whole standard deviation, `dt` after the last, while the content is known. `most`: payload that the
    /// rear axle balances; `rests`: the ground may carry a part.
    pub fn see(&mut self, payload: Quantity, most: f64, rests: bool, dt: f64) {
        self.largest *= 1.0 - (dt / FADES).min(1.0);
        let above = payload.value - most;
        let beyond = if rests {
            above
        } else {
            above.max(-payload.value)
        };
        let z = beyond / payload.std;
        // A payload well within the range carries no information.
        if z.is_finite() && z > -1.0 {
            self.mean += (dt / MEMORY).min(1.0) * (z - self.mean);
            self.largest = self.largest.max(self.mean);
        }
    }

    /// Factor of the standard deviations over the stated ones, at least 1.
    pub fn factor(&self) -> f64 {
        self.largest.max(1.0)
    }

    /// The stated deviations explain this payload, and those before.
    pub fn explains(&self, payload: Quantity) -> bool {
        !self.is_wrong() && payload.value > -WRONG * payload.std
    }

    /// The stated deviations do not explain the payloads.
    pub fn is_wrong(&self) -> bool {
        self.largest > WRONG
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(seconds: u32, value: f64) -> Below {
        let mut below = Below::default();
        for _ in 0..100 * seconds {
            below.see(Quantity { value, std: 100.0 }, 9000.0, false, 0.01);
        }
        below
    }

    #[test]
    fn a_payload_below_zero_widens_and_beyond_two_deviations_is_wrong() {
        assert_eq!(after(20, -80.0).factor(), 1.0);
        let low = after(20, -170.0);
        assert!((low.factor() - 1.7).abs() < 0.1 && !low.is_wrong());
        assert!(after(20, -260.0).is_wrong());
        let empty = Quantity {
            value: -170.0,
            std: 100.0,
        };
        assert!(low.explains(empty) && !after(20, -260.0).explains(empty));
        assert!(!low.explains(Quantity {
            value: -210.0,
            ..empty
        }));
        assert!(after(20, 9260.0).is_wrong(), "the rear axle would lift");
        // Loads, a missing value and half a second below zero carry no information.
        assert_eq!(after(60, 3000.0).factor(), 1.0);
        assert_eq!(after(60, f64::NAN).factor(), 1.0);
        let mut brief = Below::default();
        (0..50).for_each(|_| {
            brief.see(
                Quantity {
                    value: -300.0,
                    std: 100.0,
                },
                9000.0,
                false,
                0.01,
            )
        });
        assert_eq!(brief.factor(), 1.0);
    }
}
