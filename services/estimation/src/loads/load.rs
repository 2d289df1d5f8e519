//! One load.

use super::row::Witness;
use crate::math::{norm, sqrt};
use crate::{CommonError, HALF_WIDTH_95, Quantity};

/// A weight with its standard deviation, and the part of it that is common to all loads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Weight {
    /// Weight \[kg\].
    pub kg: f64,
    /// Standard deviation \[kg\].
    pub std: f64,
    /// Standard deviation of the errors common to all loads, at most `std` \[kg\].
    pub common_std: f64,
}

impl Weight {
    /// A weight with the standard deviation `common` of the common errors.
    pub(super) fn new(value: Quantity, common: f64) -> Self {
        Self {
            kg: value.value,
            std: value.std,
            common_std: common.clamp(0.0, value.std),
        }
    }

    /// The same with the errors common to all weights added.
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

    /// The difference to `other`. Common errors partly cancel; since the correlation is unknown, no cancellation is assumed.
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

/// Stage of a load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Stage {
    /// In the bucket; its estimate improves.
    #[default]
    Carried,
    /// Dumped: its weight is final; what stays in the bucket is not weighed yet.
    Dumped,
    /// Booked: what stays in the bucket is final too.
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
    /// Number, from 1.
    pub number: u32,
    /// Number of its truck, from 1.
    pub truck: u32,
    /// Number of its day: midnights since that of the settings.
    pub day: i64,
    /// Its stage.
    pub stage: Stage,
    /// Time since which the bucket is known to hold it, or since the machine set off where only motion is informative \[s\].
    pub filled: f64,
    /// Time at which it began to leave; `None` while it is in the bucket \[s\].
    pub dumped: Option<f64>,
    /// Content of the bucket before the dump.
    pub weight: Weight,
    /// Rest that stayed in the bucket.
    pub carry_back: Weight,
    /// Whether the rest was weighed after this load; else it is the average of earlier ones.
    pub carry_back_weighed: bool,
    /// Whether the weight is trusted.
    pub trusted: bool,
    /// Why the weight is not trusted, in the code of the rows.
    pub why: u32,
    /// Source of the weight.
    pub witness: Witness,
}

impl Load {
    /// Weight that the truck received.
    pub fn delivered(&self) -> Weight {
        self.weight.without(&self.carry_back)
    }
}

/// Mean and variance of what stays in the bucket after a dump.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct CarryBack {
    mean: f64,
    variance: f64,
    common: f64,
    count: f64,
}

/// Standard deviation before any is weighed, in rated payloads. Wet soil leaves up to a tenth.
const CARRY_BACK_STD: f64 = 0.05;
/// Memory of the averages, in dumps.
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

    /// Takes a weighed rest.
    pub(super) fn add(&mut self, weight: &Weight) {
        self.count = (self.count + 1.0).min(CARRY_BACK_MEMORY);
        let share = 1.0 / (self.count + 1.0);
        let off = weight.kg - self.mean;
        self.mean += share * off;
        self.variance += share * (off * off + weight.own_variance() - self.variance);
        self.common += (weight.common_std - self.common) / self.count;
    }

    /// Expected rest where none is weighed.
    pub(super) fn expected(&self) -> Weight {
        Weight {
            kg: self.mean,
            std: sqrt(self.variance + self.common * self.common),
            common_std: self.common,
        }
    }
}
