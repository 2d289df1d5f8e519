//! What all weights of a machine are off together.

use crate::math::norm;

/// Standard deviations of the errors that all weights of a machine share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CommonError {
    /// Of their scale, relative.
    pub scale_std: f64,
    /// Of their zero \[kg\].
    pub zero_std: f64,
}

impl CommonError {
    /// Of one weight \[kg\].
    #[must_use]
    pub fn std(&self, kg: f64) -> f64 {
        norm(&[self.scale_std * kg, self.zero_std])
    }
}
