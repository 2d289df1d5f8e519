//! Detects a sensor that repeats one value in spite of its noise.
//!
//! Noise makes the increments of a signal alternate in sign; the motion of a joint, or a coarse step of the sensor,
//! does not. If a noisy signal has exactly one value for half a second, it is no longer measured: a cable, a bus or a
//! gateway repeats the last value.

/// Number of equal samples that are a fault: 0.5 s at 100 Hz.
const REPEATS: u32 = 50;
/// Mean share of increments of alternating sign above which a signal is noisy; it is two thirds for white noise.
const NOISY: f64 = 0.45;
/// Weight of one sample in that mean.
const MEMORY: f64 = 0.02;
/// A signal with more than `CHANGES` changes and never `LONGEST` repeats is noisy too, however it moves [samples].
const CHANGES: u32 = 500;
const LONGEST: u32 = 5;
/// Largest increment that is rounding and no noise \[rad\]: a joint angle may be the difference of two. Noise of any signal is larger.
const ROUNDING: f64 = 1e-12;

/// Detector of one signal.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Repetition {
    last: Option<f64>,
    increment: f64,
    /// Mean share of increments of alternating sign.
    alternating: f64,
    repeats: u32,
    /// Longest repetition so far, other than by a frozen sensor; number of changes.
    longest: u32,
    changes: u32,
}

impl Repetition {
    /// The value; missing while the sensor is frozen.
    pub(in crate::excavator) fn pass(&mut self, value: Option<f64>) -> Option<f64> {
        let value = value?;
        let increment = value - self.last.replace(value).unwrap_or(value);
        if increment.abs() <= ROUNDING {
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

    /// A repetition that ends was a step of the sensor, not noise.
    fn ends(&mut self) {
        if !self.is_frozen() {
            self.longest = self.longest.max(self.repeats);
        }
        self.alternating *= 1.0 - MEMORY * f64::from(self.repeats.min(10));
        self.repeats = 0;
    }

    /// Whether the sensor repeats one value in spite of its noise.
    pub(in crate::excavator) fn is_frozen(&self) -> bool {
        let always = self.changes >= CHANGES && self.longest < LONGEST;
        self.repeats >= REPEATS && (self.is_noisy() || always)
    }

    /// Whether its increments alternate in sign as noise does, from row to row. A repetition keeps that.
    pub(in crate::excavator) fn is_noisy(&self) -> bool {
        self.alternating > NOISY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the detector reports a sensor as frozen after a motion of `moves` a sample; `shown` maps true to measured angles.
    fn frozen(moves: f64, shown: impl Fn(f64) -> f64) -> bool {
        let mut sensor = Repetition::default();
        for k in 0..2000 {
            let noise = 0.001 * f64::from(k * 7919 % 13 - 6) / 6.0;
            sensor.pass(Some(shown(moves * f64::from(k) + noise)));
        }
        let last = sensor.last;
        for _ in 0..60 {
            sensor.pass(last);
        }
        sensor.is_frozen()
    }

    #[test]
    fn the_rounding_of_a_difference_is_no_noise() {
        let mut bucket = Repetition::default();
        for k in 0..2000 {
            // The link before moves, and the last bits with it; then it is at rest.
            let bits = f64::from(k.min(1900) * 7919 % 13 - 6) * f64::EPSILON;
            bucket.pass(Some(-0.61 + bits));
        }
        assert!(!bucket.is_frozen());
    }

    #[test]
    fn a_sensor_that_never_repeated_a_value_is_frozen_when_it_does_even_where_motion_hides_its_noise()
     {
        assert!(frozen(0.0, |angle| angle));
        assert!(frozen(0.01, |angle| angle));
        // A coarse sensor repeats its values anyway.
        assert!(!frozen(0.001, |angle| (angle / 0.02).round() * 0.02));
    }
}
