//! What the ledger is given.

/// What the ledger is given.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Payload of a full bucket, roughly \[kg\].
    pub rated: f64,
    /// Relative standard deviation of all payloads together; their own holds it too.
    pub scale_std: f64,
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
            scale_std: 0.0,
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
            scale_std: if self.scale_std.is_finite() {
                self.scale_std
            } else {
                0.0
            },
            target: self.target.filter(|t| t.is_finite()),
            ..self
        }
    }
}
