//! What no upper body and no drive of one can do is missing.

use crate::leap::{Leap, SteadyTorque};

/// No upper body accelerates more, but for the shock of a backlash [rad/s^2].
const ACCELERATION: f64 = 10.0;
/// Coarse sensors step by this much [rad/s].
const COARSE: f64 = 0.03;
/// Differences of so many standard deviations of the noise are noise.
const NOISE: f64 = 8.0;
/// The largest torque is at least so many times its noise.
const LARGEST: f64 = 50.0;

/// Swing velocity and torque without their leaps.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Steady {
    velocity: Leap,
    torque: SteadyTorque,
}

impl Steady {
    /// The swing velocity of a row as it counts; `std` is that of its noise [rad/s].
    pub(in crate::excavator) fn velocity(
        &mut self,
        velocity: Option<f64>,
        std: f64,
        period: f64,
    ) -> Option<f64> {
        let noise = COARSE + NOISE * std;
        self.velocity.pass(velocity, ACCELERATION, noise, period)
    }

    /// The swing torque of a row as it counts; `std` is that of its noise [N m].
    pub(in crate::excavator) fn torque(
        &mut self,
        torque: Option<f64>,
        std: f64,
        period: f64,
    ) -> Option<f64> {
        let limits = [LARGEST * std, NOISE * std];
        self.torque.pass(torque, limits, period)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;

    /// A velocity that swings up and down at 1 rad/s^2, 100 Hz, changed by `wrong`: the rows that are missing.
    fn missing(wrong: impl Fn(u32, f64) -> f64) -> Vec<u32> {
        let mut steady = Steady::default();
        let swing = |k: u32| (0.01 * f64::from(k) % 2.0 - 1.0).abs();
        (0..600)
            .filter(|&k| {
                steady
                    .velocity(Some(wrong(k, swing(k))), 0.003, 0.01)
                    .is_none()
            })
            .collect()
    }

    #[test]
    fn a_word_that_is_no_velocity_is_missing_as_long_as_it_is_said() {
        assert!(missing(|_, w| w).is_empty());
        for rows in [1, 5, 100] {
            let said = 360..360 + rows;
            for word in [0.0, -2.0, 4.9] {
                let found = missing(|k, w| if said.contains(&k) { word } else { w });
                assert_eq!(found, said.clone().collect::<Vec<_>>(), "{word}");
            }
        }
    }

    #[test]
    fn a_velocity_that_is_another_one_is_believed_a_moment_later() {
        let found = missing(|k, w| if k < 300 { w } else { w - 1.5 });
        assert!(!found.is_empty() && found.len() < 20, "{found:?}");
    }
}
