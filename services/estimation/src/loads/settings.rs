//! Settings of the ledger.

use crate::CommonError;

/// Settings of the ledger.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Payload of a full bucket, roughly \[kg\].
    pub rated: f64,
    /// Errors common to all payloads; the standard deviations of the payloads include them.
    pub common: CommonError,
    /// The same of payloads that a lift arm weighs, where none of them has shown the errors yet: an emptied bucket does.
    pub lift_arm: Option<CommonError>,
    /// Target weight of a truck \[kg\].
    pub target: Option<f64>,
    /// Pause between two loads after which another truck begins; 0: never \[s\].
    pub pause: f64,
    /// Time of a midnight, from which days are counted \[s\].
    pub midnight: f64,
}

impl Settings {
    /// Range of the rated payload \[kg\].
    pub const RATED: [f64; 2] = [1e-3, 1e7];

    /// No target, a new truck after five minutes, days from time 0.
    pub fn with_rated(rated: f64) -> Self {
        Self {
            rated,
            common: CommonError::default(),
            lift_arm: None,
            target: None,
            pause: 300.0,
            midnight: 0.0,
        }
    }

    /// The same, with unusable numbers replaced.
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
            lift_arm: self.lift_arm.filter(|common| common.std(1.0).is_finite()),
            target: self.target.filter(|t| t.is_finite()),
            ..self
        }
    }
}
