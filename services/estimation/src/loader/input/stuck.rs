//! Detection of a stuck sensor: a value that never changes although it would have to.
//!
//! Noise changes a value with every row. So a value that repeats is either quantised coarsely or no measurement any more. The size
//! of the changes distinguishes them:
//!
//! * Changes have often been smaller than the stated noise: a value that holds for longer than an input stays fresh is stuck.
//! * Changes are larger (steps of an encoder, a constant torque command): the value is stuck when the motion shows that it must have
//!   changed. Another speed has moved by several steps, or the acceleration is not the one that the torques give.
//!
//! A machine at rest may repeat every value, so nothing is stuck below the freezing speed.

use crate::loader::sample::Sample;

/// The signals that are watched, in this order: speed, front and rear wheel speed, front and rear torque, slope,
/// specific force.
pub const WATCHED: usize = 7;

/// Changes below this, relative to the value, are rounding.
const ROUNDING: f64 = 1e-12;
/// Change of a reference, in standard deviations and steps, beyond which the signal must have changed.
const MOVED: f64 = 5.0;
/// Number of changes below the stated noise from which on the signal must show noise.
const NOISY: u32 = 50;

/// Changes of one signal so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Trace {
    last: Option<f64>,
    /// Time without a change [s].
    unchanged: f64,
    /// Smallest change so far.
    step: Option<f64>,
    /// Number of changes below the stated noise.
    small: u32,
    /// Reference at the last change.
    reference: f64,
}

/// Motion shown by other signals, as a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// The machine moves.
    pub moving: bool,
    /// Speeds, each from the other signals: speed [m/s], front and rear wheel speed [rad/s].
    pub speeds: [f64; 3],
    /// The acceleration is not the one that the torques give.
    pub unexplained: bool,
    /// Stated noise of each signal; 0 where it is none (torques: relative).
    pub std: [f64; WATCHED],
    /// Time for which a value may repeat [s].
    pub patience: f64,
}

/// State of the watched signals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Stuck {
    traces: [Trace; WATCHED],
    /// Whether each is stuck.
    pub now: [bool; WATCHED],
}

impl Stuck {
    /// Updates with a plausible row `dt` after the one before, and removes stuck values from it.
    pub fn watch(&mut self, sample: &mut Sample, witness: &Witness, dt: f64) {
        let signals = [
            &mut sample.speed,
            &mut sample.front_wheel_speed,
            &mut sample.rear_wheel_speed,
            &mut sample.front_torque,
            &mut sample.rear_torque,
            &mut sample.slope,
            &mut sample.acceleration,
        ];
        for (j, signal) in signals.into_iter().enumerate() {
            // A gap neither frees a stuck value nor makes one.
            let Some(value) = *signal else { continue };
            let reference = witness.speeds.get(j).copied().unwrap_or(0.0);
            let trace = &mut self.traces[j];
            trace.take(value, reference, witness.std[j], dt);
            self.now[j] = trace.is_stuck(witness, j);
            if self.now[j] {
                *signal = None;
            }
        }
    }

    /// The first signal that is stuck.
    pub fn first(&self) -> Option<usize> {
        self.now.iter().position(|stuck| *stuck)
    }
}

impl Trace {
    fn take(&mut self, value: f64, reference: f64, std: f64, dt: f64) {
        let Some(last) = self.last.replace(value) else {
            self.reference = reference;
            return;
        };
        let change = (value - last).abs();
        if change > ROUNDING * value.abs() {
            self.unchanged = 0.0;
            self.reference = reference;
            if self.step.is_none_or(|step| change < step) {
                self.step = Some(change);
            }
            self.small = self.small.saturating_add(u32::from(change < std));
        } else {
            self.unchanged += dt;
        }
    }

    fn is_stuck(&self, witness: &Witness, j: usize) -> bool {
        if !witness.moving || self.unchanged < witness.patience {
            return false;
        }
        let (std, step) = (witness.std[j], self.step.unwrap_or(0.0));
        let moved = match witness.speeds.get(j) {
            Some(now) => (now - self.reference).abs() > MOVED * (std + step),
            // Torques: slope and specific force have noise.
            None => std == 0.0 && witness.unexplained,
        };
        moved || self.small >= NOISY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn witness(speed: f64) -> Witness {
        Witness {
            moving: true,
            speeds: [speed, speed / 0.55, speed / 0.55],
            unexplained: false,
            std: [0.02, 0.002, 0.002, 0.0, 0.0, 0.002, 0.05],
            patience: 0.25,
        }
    }

    fn stuck_after(rows: i32, value: impl Fn(i32) -> f64, speed: impl Fn(i32) -> f64) -> bool {
        let mut stuck = Stuck::default();
        for k in 0..rows {
            let mut sample = Sample {
                front_wheel_speed: Some(value(k)),
                ..Sample::default()
            };
            stuck.watch(&mut sample, &witness(speed(k)), 0.01);
        }
        stuck.now[1]
    }

    #[test]
    fn a_noisy_signal_that_stops_to_change_is_stuck_after_a_quarter_of_a_second() {
        let noisy = |k: i32| 5.0 + 0.0003 * f64::from(k.min(150) * 7 % 11);
        assert!(!stuck_after(174, noisy, |_| 2.75));
        assert!(stuck_after(178, noisy, |_| 2.75));
    }

    #[test]
    fn coarse_steps_are_stuck_only_when_the_machine_changes_its_speed() {
        let coarse = |k: i32| if k < 50 { f64::from(k / 10) * 0.5 } else { 2.5 };
        assert!(!stuck_after(300, coarse, |_| 1.4));
        assert!(stuck_after(300, coarse, |k| 1.4 + 0.01 * f64::from(k)));
    }
}
