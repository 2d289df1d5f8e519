//! A signal in steps: the smallest change ever seen is taken for the quantum of the sensor.
//!
//! A quantised signal changes by whole quanta q, and its error has a variance of q^2/12. A signal with noise soon changes by next
//! to nothing.

/// Changes below this are rounding, in the unit of the signal.
const ROUNDING: f64 = 1e-9;

/// What has been seen of a signal.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Quantum {
    last: Option<f64>,
    least: Option<f64>,
}

impl Quantum {
    /// Takes the next value; whether it is another one.
    #[inline(always)]
    pub(crate) fn see(&mut self, new: f64) -> bool {
        let change = self
            .last
            .replace(new)
            .map_or(0.0, |last| (new - last).abs());
        let changes = change > ROUNDING;
        if changes {
            self.least = Some(self.least.map_or(change, |least| least.min(change)));
        }
        changes
    }

    /// The smallest change so far.
    pub(crate) fn least(&self) -> Option<f64> {
        self.least
    }
}
