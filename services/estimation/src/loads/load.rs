//! One load.

use super::row::Witness;
use crate::math::{norm, sqrt};
use crate::{CommonError, HALF_WIDTH_95, Quantity};

/// A weight with its standard deviation, and the part of it that all loads share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Weight {
    /// Weight \[kg\].
    pub kg: f64,
    /// Standard deviation \[kg\].
    pub std: f64,
    /// Standard deviation of the errors that all loads share, at most `std` \[kg\].
    pub common_std: f64,
}

impl Weight {
    /// A weight of which `common` is shared.
    pub(super) fn new(value: Quantity, common: f64) -> Self {
        Self {
            kg: value.value,
            std: value.std,
            common_std: common.clamp(0.0, value.std),
        }
    }

    /// The same with what all weights are off together.
    pub(super) fn with_common(self, common: &CommonError) -> Self {
        let together = common.std(self.kg);
        Self {
            std: norm(&[self.std, together]),
            common_std: norm(&[self.common_std, together]),
            ..self
        }
    }

    /// Lower and upper end of the 95 % interval \[kg\].
    pub fn interval(&self) -> [f64; 2] {
        [
            self.kg - HALF_WIDTH_95 * self.std,
            self.kg + HALF_WIDTH_95 * self.std,
        ]
    }

    /// Variance of the errors of this load alone [kg^2].
    pub fn own_variance(&self) -> f64 {
        (self.std * self.std - self.common_std * self.common_std).max(0.0)
    }

    /// What is left of it without `other`. Errors that both share partly cancel; by how much nobody tells, so none do.
    pub(super) fn without(&self, other: &Self) -> Self {
        Self {
            kg: self.kg - other.kg,
            std: norm(&[self.std, other.std]),
            common_std: norm(&[self.common_std, other.common_std]),
        }
    }

    /// The value with its standard deviation.
    pub fn quantity(&self) -> Quantity {
        Quantity {
            value: self.kg,
            std: self.std,
        }
    }
}

/// How far a load has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Stage {
    /// In the bucket; its weight becomes better.
    #[default]
    Carried,
    /// Dumped: its weight is final, what stays in the bucket is not weighed yet.
    Dumped,
    /// What stays in the bucket is final too.
    Settled,
}

impl Stage {
    /// All of them, in the order of their codes.
    pub const ALL: [Self; 3] = [Self::Carried, Self::Dumped, Self::Settled];

    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Carried => "carried",
            Self::Dumped => "dumped",
            Self::Settled => "settled",
        }
    }

    /// Code in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }
}

/// One load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Load {
    /// Counts from 1.
    pub number: u32,
    /// Number of its truck, from 1.
    pub truck: u32,
    /// Number of its day: midnights since that of the settings.
    pub day: i64,
    /// How far it has come.
    pub stage: Stage,
    /// Since when the bucket is known to hold it; where only motion tells, since the machine set off \[s\].
    pub filled: f64,
    /// When it began to leave; `None` while it is in the bucket \[s\].
    pub dumped: Option<f64>,
    /// What was in the bucket.
    pub weight: Weight,
    /// What stayed in it.
    pub carry_back: Weight,
    /// That was weighed after this load; else it is what stayed after earlier ones.
    pub carry_back_weighed: bool,
    /// The weight may be believed.
    pub trusted: bool,
    /// Why not, in the code of the rows.
    pub why: u32,
    /// Source of the weight.
    pub witness: Witness,
}

impl Load {
    /// What the truck got.
    pub fn delivered(&self) -> Weight {
        self.weight.without(&self.carry_back)
    }
}

/// Mean and spread of what stays in the bucket after a dump.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct CarryBack {
    mean: f64,
    variance: f64,
    common: f64,
    count: f64,
}

/// Before any is weighed: standard deviation, in rated payloads. Wet soil leaves up to a tenth.
const CARRY_BACK_STD: f64 = 0.05;
/// The last so many count.
const CARRY_BACK_MEMORY: f64 = 8.0;

impl CarryBack {
    pub(super) fn new(rated: f64) -> Self {
        let std = CARRY_BACK_STD * rated;
        Self {
            mean: 0.0,
            variance: std * std,
            common: 0.0,
            count: 0.0,
        }
    }

    /// Takes one that was weighed.
    pub(super) fn add(&mut self, weight: &Weight) {
        self.count = (self.count + 1.0).min(CARRY_BACK_MEMORY);
        let share = 1.0 / (self.count + 1.0);
        let off = weight.kg - self.mean;
        self.mean += share * off;
        self.variance += share * (off * off + weight.own_variance() - self.variance);
        self.common += (weight.common_std - self.common) / self.count;
    }

    /// What is expected where none is weighed.
    pub(super) fn expected(&self) -> Weight {
        Weight {
            kg: self.mean,
            std: sqrt(self.variance + self.common * self.common),
            common_std: self.common,
        }
    }
}
