//! One load.

use core::f64::consts::TAU;

use super::row::Witness;
use crate::math::{exp, norm, sqrt};
use crate::{CommonError, HALF_WIDTH_95, Quantity};

/// Share of a payload's variance that is common to all loads of a machine, where the estimator does not separate it.
const COMMON: f64 = 0.7;

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
    /// The part of them whose scale and zero are known: a zero cancels in a difference of two weights.
    pub known: CommonError,
}

impl Weight {
    /// A weight with its common errors; `None` where the estimator does not separate them.
    pub(super) fn new(value: Quantity, common: Option<CommonError>) -> Self {
        let known = common.filter(|common| common.std(value.value).is_finite());
        let known = known.map(|common| common.at_most(value.std, value.value));
        Self {
            kg: value.value,
            std: value.std,
            common_std: known.map_or(sqrt(COMMON) * value.std, |k| k.std(value.value)),
            known: known.unwrap_or_default(),
        }
    }

    /// The same with the errors common to all weights added.
    pub(super) fn with_common(self, more: &CommonError) -> Self {
        let together = more.std(self.kg);
        Self {
            std: norm(&[self.std, together]),
            common_std: norm(&[self.common_std, together]),
            known: self.known.and(more),
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

    /// Variance of the common errors whose scale and zero are not known [kg^2].
    fn shared_variance(&self) -> f64 {
        (self.common_std * self.common_std - self.known.variance(self.kg)).max(0.0)
    }

    /// The difference to `other`. Of the common errors a known zero cancels, and a known scale is that of the difference. The others cancel
    /// partly; since their correlation is unknown, no cancellation is assumed.
    pub(super) fn without(&self, other: &Self) -> Self {
        let kg = self.kg - other.kg;
        let known = CommonError {
            zero_std: 0.0,
            ..self.known
        };
        let shared = self.shared_variance() + other.shared_variance();
        let common = shared + known.variance(kg);
        Self {
            kg,
            std: sqrt(self.own_variance() + other.own_variance() + common),
            common_std: sqrt(common),
            known,
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
    /// Whether that rest is what an emptied bucket keeps, and no part of the load that was left in it.
    pub is_emptied: bool,
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

/// What stays in the bucket after a dump: mean of the dumps so far, and variance about it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct CarryBack {
    mean: f64,
    variance: f64,
    common: f64,
    count: f64,
    /// Least variance: no two dumps are alike.
    least: f64,
}

/// Standard deviation before any is weighed, in rated payloads. Wet soil leaves up to a tenth.
const CARRY_BACK_STD: f64 = 0.05;
/// Least standard deviation about the mean, in rated payloads.
const CARRY_BACK_LEAST: f64 = 0.015;
/// Memory of the averages, in dumps.
const CARRY_BACK_MEMORY: f64 = 8.0;
/// Share of the dumps that leave a part of the load on purpose.
const IN_PARTS: f64 = 0.1;

impl CarryBack {
    pub(super) fn new(rated: f64) -> Self {
        let [std, least] = [CARRY_BACK_STD, CARRY_BACK_LEAST].map(|share| share * rated);
        Self {
            mean: 0.0,
            variance: std * std,
            common: 0.0,
            count: 0.0,
            least: least * least,
        }
    }

    /// Takes the weight of an emptied bucket.
    pub(super) fn add(&mut self, weight: &Weight) {
        self.count = (self.count + 1.0).min(CARRY_BACK_MEMORY);
        let share = 1.0 / (self.count + 1.0);
        let off = weight.kg - self.mean;
        self.mean += share * off;
        let beyond_noise = (off * off - weight.own_variance()).max(self.least);
        self.variance += share * (beyond_noise - self.variance);
        self.common += (weight.common_std - self.common) / self.count;
    }

    /// Expected rest where none is weighed.
    pub(super) fn expected(&self) -> Weight {
        Weight {
            kg: self.mean,
            std: sqrt(self.variance + self.common * self.common),
            common_std: self.common,
            ..Weight::default()
        }
    }

    /// Probability that a bucket which shows `rest` after a load of `kg` is emptied. A part of the load may be anything up to all of it.
    pub(super) fn is_emptied(&self, rest: &Weight, kg: f64) -> f64 {
        let variance = self.shown_variance(rest) + rest.own_variance();
        let off = rest.kg - self.mean;
        let density = exp(-0.5 * off * off / variance) / sqrt(TAU * variance);
        let part = IN_PARTS / kg.max(sqrt(variance));
        let emptied = (1.0 - IN_PARTS) * density;
        emptied / (emptied + part)
    }

    /// What an emptied bucket shows, by its weight `shown` and by the dumps before.
    ///
    /// Its content r and the error z that all weights share are as far from the mean as `shown_variance` says; `shown` adds its own error n.
    /// What reached the truck is load - (r + z), so r + z is estimated:
    /// ```text
    /// r + z = mean + k (shown - mean),   k = var(r + z)/(var(r + z) + var(n))
    /// ```
    pub(super) fn weighed(&self, shown: &Weight) -> Weight {
        let before = self.shown_variance(shown);
        let gain = before / (before + shown.own_variance());
        let common = shown.common_std * shown.common_std;
        Weight {
            kg: self.mean + gain * (shown.kg - self.mean),
            std: sqrt(gain * shown.own_variance() + common),
            ..*shown
        }
    }

    /// Variance of content and common error of an emptied bucket.
    fn shown_variance(&self, shown: &Weight) -> f64 {
        self.variance + shown.common_std * shown.common_std
    }
}
