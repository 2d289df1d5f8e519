//! A sensor that repeats one value although its noise forbids it.
//!
//! Noise makes the increments of a signal change their sign from sample to sample; the motion of a joint, or
//! a coarse step of the sensor, does not. A signal that was noisy and then says exactly the same for half a
//! second is not measured any more: a cable, a bus or a gateway repeats its last word.

/// Samples of exactly one value that are taken for a fault (0.5 s at 100 Hz; the fastest source needs more).
const REPEATS: u32 = 50;
/// Share of increments of alternating sign above which a signal is noisy; white noise has two thirds.
const NOISY: f64 = 0.45;
/// Share of one sample in that mean.
const MEMORY: f64 = 0.02;

/// One signal.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Repetition {
    last: Option<f64>,
    increment: f64,
    /// Share of increments that alternate.
    alternating: f64,
    repeats: u32,
}

impl Repetition {
    /// The value as it counts: missing while the sensor is frozen.
    pub(in crate::excavator) fn pass(&mut self, value: Option<f64>) -> Option<f64> {
        let value = value?;
        let increment = value - self.last.replace(value).unwrap_or(value);
        if increment == 0.0 {
            self.repeats = self.repeats.saturating_add(1);
        } else {
            let alternates = increment * self.increment < 0.0;
            self.alternating += MEMORY * (f64::from(u8::from(alternates)) - self.alternating);
            self.increment = increment;
            // Repeats that end are steps of the sensor, not noise.
            let steps = f64::from(self.repeats.min(10));
            self.alternating *= 1.0 - MEMORY * steps;
            self.repeats = 0;
        }
        (!self.is_frozen()).then_some(value)
    }

    /// Whether it repeats one value against its own noise.
    pub(in crate::excavator) fn is_frozen(&self) -> bool {
        self.repeats >= REPEATS && self.alternating > NOISY
    }
}
