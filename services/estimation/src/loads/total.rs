//! Sums of loads. Ten loads are not ten times as certain: what all share (span, zero, gain, description) adds up, what
//! each has of its own averages out.
//!
//! ```text
//! var = sum_i own_i^2 + (sum_i common_i)^2
//! ```

use super::load::Load;
use super::row::Witness;
use crate::math::sqrt;

/// A sum with its two kinds of errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Total {
    /// Loads.
    pub loads: u32,
    /// Of them those that may not be believed.
    pub untrusted: u32,
    /// Of them those that nothing weighed before they left.
    pub unweighed: u32,
    /// What they delivered \[kg\].
    pub kg: f64,
    /// Sum of the variances that each load has of its own [kg^2].
    pub own_variance: f64,
    /// Sum of the standard deviations that all loads share \[kg\].
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

    /// The sum with one more load.
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
