//! Errors common to all weights of a machine.

use crate::math::{norm, sqrt};

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

    /// The same in proportion, so that a weight `kg` has at most the standard deviation `most` by them \[kg\].
    #[must_use]
    pub fn at_most(&self, most: f64, kg: f64) -> Self {
        let std = self.std(kg);
        let by = if std > most { most / std } else { 1.0 };
        Self {
            scale_std: by * self.scale_std,
            zero_std: by * self.zero_std,
        }
    }

    /// These errors and others that are independent of them.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self {
            scale_std: norm(&[self.scale_std, other.scale_std]),
            zero_std: norm(&[self.zero_std, other.zero_std]),
        }
    }
}
