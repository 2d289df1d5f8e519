//! Resolution of a quantised signal, estimated as the smallest change so far.
//!
//! A quantised signal changes by whole quanta q, and its error has a variance of q^2/12. In a noisy signal the smallest change soon
//! is close to zero.

/// Changes below this are rounding, in the unit of the signal.
const ROUNDING: f64 = 1e-9;

/// Last value and smallest change of a signal.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Quantum {
    last: Option<f64>,
    least: Option<f64>,
}

impl Quantum {
    /// Takes the next value; returns whether it has changed.
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
