//! What all weights of a machine are off together.

use crate::math::sqrt;

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
    /// Variance of one weight \[kg\] by it [kg^2].
    #[must_use]
    pub fn variance(&self, kg: f64) -> f64 {
        let scale = self.scale_std * kg;
        scale * scale + self.zero_std * self.zero_std
    }

    /// Standard deviation of one weight \[kg\] by it \[kg\].
    #[must_use]
    pub fn std(&self, kg: f64) -> f64 {
        sqrt(self.variance(kg))
    }
}
