//! What the ledger is given.

use crate::CommonError;

/// What the ledger is given.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Payload of a full bucket, roughly \[kg\].
    pub rated: f64,
    /// What all payloads are off together; their own deviations hold it too.
    pub common: CommonError,
    /// What a truck shall hold \[kg\].
    pub target: Option<f64>,
    /// A load this long after the one before goes to another truck; 0 never \[s\].
    pub pause: f64,
    /// Time of a midnight, from which days are counted \[s\].
    pub midnight: f64,
}

impl Settings {
    /// No bucket holds less or more \[kg\].
    pub const RATED: [f64; 2] = [1e-3, 1e7];

    /// No target, a new truck after five minutes, days from time 0.
    pub fn with_rated(rated: f64) -> Self {
        Self {
            rated,
            common: CommonError::default(),
            target: None,
            pause: 300.0,
            midnight: 0.0,
        }
    }

    /// The same with numbers that can be used.
    pub(super) fn usable(self) -> Self {
        Self {
            rated: if self.rated.is_finite() {
                self.rated.clamp(Self::RATED[0], Self::RATED[1])
            } else {
                1.0
            },
            common: if self.common.std(1.0).is_finite() {
                self.common
            } else {
                CommonError::default()
            },
            target: self.target.filter(|t| t.is_finite()),
            ..self
        }
    }
}
