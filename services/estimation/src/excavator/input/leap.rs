//! A swing velocity or torque that leaps further than an upper body or its drive can.
//!
//! A loose contact, a bus that drops out or a gateway that fills gaps says 0 or the end of a range for some rows. What is too far from
//! the last value is missing, and so is the same word again. With time every value comes within reach, so that a shock or a
//! sensor that begins anew is believed a moment later.

/// No upper body accelerates more, but for the shock of a backlash [rad/s^2].
const ACCELERATION: f64 = 10.0;
/// Coarse sensors step by this much [rad/s].
const COARSE: f64 = 0.03;
/// Differences of so many standard deviations of the noise are noise.
const NOISE: f64 = 8.0;
/// No drive goes faster from nothing to its largest torque [1/s]; twice what was recorded.
const RISE: f64 = 30.0;
/// The largest torque is at least so many times its noise.
const LARGEST: f64 = 50.0;

/// The values that were believed.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Leap {
    last: Option<f64>,
    /// Time since it was new [s].
    age: f64,
    /// What was not believed since then.
    refused: Option<f64>,
}

impl Leap {
    /// The value as it counts: missing where it leaps by more than what may `change` in a second, and the noise.
    fn pass(&mut self, value: Option<f64>, change: f64, noise: f64, period: f64) -> Option<f64> {
        self.age += period;
        let value = value?;
        let reach = change * self.age + noise;
        let leaps = self.last.is_some_and(|last| (value - last).abs() > reach);
        if leaps || self.refused == Some(value) {
            self.refused = Some(value);
            return None;
        }
        self.refused = None;
        if self.last.replace(value) != Some(value) {
            self.age = 0.0;
        }
        Some(value)
    }
}

/// A swing velocity without its leaps.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct SteadyVelocity(Leap);

impl SteadyVelocity {
    /// The velocity of a row as it counts; `std` is that of its noise [rad/s].
    pub(in crate::excavator) fn pass(
        &mut self,
        velocity: Option<f64>,
        std: f64,
        period: f64,
    ) -> Option<f64> {
        let noise = COARSE + NOISE * std;
        self.0.pass(velocity, ACCELERATION, noise, period)
    }
}

/// A swing torque without its leaps.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct SteadyTorque {
    leap: Leap,
    /// Largest torque so far [N m].
    largest: f64,
}

impl SteadyTorque {
    /// The torque of a row as it counts; `std` is that of its noise [N m].
    pub(in crate::excavator) fn pass(
        &mut self,
        torque: Option<f64>,
        std: f64,
        period: f64,
    ) -> Option<f64> {
        let largest = self.largest.max(LARGEST * std);
        let believed = self.leap.pass(torque, RISE * largest, NOISE * std, period);
        self.largest = self.largest.max(believed.unwrap_or(0.0).abs());
        believed
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;

    /// A velocity that swings up and down at 1 rad/s^2, 100 Hz, changed by `wrong`: the rows that are missing.
    fn missing(wrong: impl Fn(u32, f64) -> f64) -> Vec<u32> {
        let mut leap = SteadyVelocity::default();
        let swing = |k: u32| (0.01 * f64::from(k) % 2.0 - 1.0).abs();
        (0..600)
            .filter(|&k| leap.pass(Some(wrong(k, swing(k))), 0.003, 0.01).is_none())
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
