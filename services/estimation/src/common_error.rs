//! Errors common to all weights of a machine.

use crate::math::sqrt;

/// Standard deviations of the errors common to all weights of a machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CommonError {
    /// Standard deviation of the scale factor, relative.
    pub scale_std: f64,
    /// Standard deviation of the zero \[kg\].
    pub zero_std: f64,
}

impl CommonError {
    /// Variance that these errors give a weight `kg` [kg^2].
    #[must_use]
    pub fn variance(&self, kg: f64) -> f64 {
        let scale = self.scale_std * kg;
        scale * scale + self.zero_std * self.zero_std
    }

    /// Standard deviation that these errors give a weight `kg` \[kg\].
    #[must_use]
    pub fn std(&self, kg: f64) -> f64 {
        sqrt(self.variance(kg))
    }
}
