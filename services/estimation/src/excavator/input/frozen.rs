//! A sensor that repeats one value although its noise forbids it.
//!
//! Noise makes the increments of a signal change their sign from sample to sample; the motion of a joint, or
//! a coarse step of the sensor, does not. A signal that was noisy and then says exactly the same for half a
//! second is not measured any more: a cable, a bus or a gateway repeats its last word.

/// Samples of exactly one value that are taken for a fault: 0.5 s at 100 Hz.
const REPEATS: u32 = 50;
/// Share of increments of alternating sign, as a mean, above which a signal is noisy; white noise has two thirds.
const NOISY: f64 = 0.45;
/// Share of one sample in that mean.
const MEMORY: f64 = 0.02;
/// A signal that has changed so often and never repeated a value for so long is noisy too, however it moves [samples].
const CHANGES: u32 = 500;
const LONGEST: u32 = 5;

/// One signal.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Repetition {
    last: Option<f64>,
    increment: f64,
    /// Share of increments that alternate.
    alternating: f64,
    repeats: u32,
    /// Most repeats so far, but for a frozen sensor's, and changes.
    longest: u32,
    changes: u32,
}

impl Repetition {
    /// The value as it counts: missing while the sensor is frozen.
    pub(in crate::excavator) fn pass(&mut self, value: Option<f64>) -> Option<f64> {
        let value = value?;
        let increment = value - self.last.replace(value).unwrap_or(value);
        if increment == 0.0 {
            self.repeats = self.repeats.saturating_add(1);
            return (!self.is_frozen()).then_some(value);
        }
        if self.repeats > 0 {
            self.ends();
        }
        let alternates = increment * self.increment < 0.0;
        self.increment = increment;
        self.alternating += MEMORY * (f64::from(u8::from(alternates)) - self.alternating);
        self.changes = self.changes.saturating_add(1);
        Some(value)
    }

    /// Repeats that end are steps of the sensor, not noise.
    fn ends(&mut self) {
        if !self.is_frozen() {
            self.longest = self.longest.max(self.repeats);
        }
        self.alternating *= 1.0 - MEMORY * f64::from(self.repeats.min(10));
        self.repeats = 0;
    }

    /// Whether it repeats one value against its own noise.
    pub(in crate::excavator) fn is_frozen(&self) -> bool {
        let always = self.changes >= CHANGES && self.longest < LONGEST;
        self.repeats >= REPEATS && (self.alternating > NOISY || always)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a joint is frozen that moves by this much a sample, then repeats one value, and how it says its angle.
    fn frozen(moves: f64, said: impl Fn(f64) -> f64) -> bool {
        let mut sensor = Repetition::default();
        for k in 0..2000 {
            let noise = 0.001 * f64::from(k * 7919 % 13 - 6) / 6.0;
            sensor.pass(Some(said(moves * f64::from(k) + noise)));
        }
        let last = sensor.last;
        for _ in 0..60 {
            sensor.pass(last);
        }
        sensor.is_frozen()
    }

    #[test]
    fn a_sensor_that_never_repeated_a_value_is_frozen_when_it_does_even_where_motion_hides_its_noise()
     {
        assert!(frozen(0.0, |angle| angle));
        assert!(frozen(0.01, |angle| angle));
        // A coarse one repeats its values anyway.
        assert!(!frozen(0.001, |angle| (angle / 0.02).round() * 0.02));
    }
}
