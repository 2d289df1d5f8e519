//! Rejects velocities and torques that change faster than an upper body and its drive can.

use crate::leap::{Leap, SteadyTorque};

/// Largest acceleration of an upper body, except for shocks of backlash [rad/s^2].
const ACCELERATION: f64 = 10.0;
/// Step of a coarse sensor [rad/s].
const COARSE: f64 = 0.03;
/// Largest difference that counts as noise, in standard deviations of the noise.
const NOISE: f64 = 8.0;
/// Least value of the largest torque, in standard deviations of its noise.
const LARGEST: f64 = 50.0;

/// Filter of leaps of swing velocity and torque.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Steady {
    velocity: Leap,
    torque: SteadyTorque,
}

impl Steady {
    /// The swing velocity of a row; missing where it leaps. `std`: standard deviation of its noise [rad/s].
    pub(in crate::excavator) fn velocity(
        &mut self,
        velocity: Option<f64>,
        std: f64,
        period: f64,
    ) -> Option<f64> {
        let noise = COARSE + NOISE * std;
        self.velocity.pass(velocity, ACCELERATION, noise, period)
    }

    /// The swing torque of a row; missing where it leaps. `std`: standard deviation of its noise [N m].
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

    /// Missing rows of a velocity at 100 Hz that swings up and down at 1 rad/s^2, changed by `wrong`.
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
    fn a_value_that_is_no_velocity_is_missing_as_long_as_it_lasts() {
        assert!(missing(|_, w| w).is_empty());
        for rows in [1, 5, 100] {
            let faulty = 360..360 + rows;
            for word in [0.0, -2.0, 4.9] {
                let found = missing(|k, w| if faulty.contains(&k) { word } else { w });
                assert_eq!(found, faulty.clone().collect::<Vec<_>>(), "{word}");
            }
        }
    }

    #[test]
    fn a_velocity_that_is_another_one_is_accepted_a_moment_later() {
        let found = missing(|k, w| if k < 300 { w } else { w - 1.5 });
        assert!(!found.is_empty() && found.len() < 20, "{found:?}");
    }
}
