//! Sums of loads. Their relative error does not fall as that of independent loads: common errors (span, zero, gain, description)
//! add up, independent ones average out.
//!
//! ```text
//! var = sum_i own_i^2 + (sum_i common_i)^2
//! ```

use super::load::Load;
use super::row::Witness;
use crate::math::sqrt;

/// A sum with its common and independent errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Total {
    /// Number of loads.
    pub loads: u32,
    /// Number of those that are not trusted.
    pub untrusted: u32,
    /// Number of those that nothing weighed before they left.
    pub unweighed: u32,
    /// Delivered weight \[kg\].
    pub kg: f64,
    /// Sum of the independent variances of the loads [kg^2].
    pub own_variance: f64,
    /// Sum of the common standard deviations of the loads \[kg\].
    pub common_std: f64,
}

impl Total {
    /// Adds a load.
    pub fn add(&mut self, load: &Load) {
        let delivered = load.delivered();
        self.loads = self.loads.saturating_add(1);
        self.untrusted = self.untrusted.saturating_add(u32::from(!load.trusted));
        let unweighed = load.witness == Witness::Nothing;
        self.unweighed = self.unweighed.saturating_add(u32::from(unweighed));
        self.kg += delivered.kg;
        self.own_variance += delivered.own_variance();
        self.common_std += delivered.common_std;
    }

    /// Returns the sum with one more load.
    #[must_use]
    pub fn with(mut self, load: Option<&Load>) -> Self {
        if let Some(load) = load {
            self.add(load);
        }
        self
    }

    /// Standard deviation of the sum \[kg\].
    pub fn std(&self) -> f64 {
        sqrt(self.own_variance + self.common_std * self.common_std)
    }
}
