//! Level: a content of the bucket that is constant for a while, and its best estimate.

use core::f64::consts::TAU;

use super::load::Weight;
use super::row::{Row, Witness};
use crate::math::{ln, norm, sqrt};
use crate::{CommonError, Quantity};

/// Distance of two values above which they are two contents, in standard deviations of the less certain one. Rows of one
/// filter share their errors, so the larger standard deviation bounds their difference.
const APART: f64 = 3.0;

/// Ratio of standard deviations below which a row replaces the estimate.
const MORE_CERTAIN: f64 = 0.99;
/// Standard deviation of two weighings of one content by one filter beside that of its estimates, as a share of the content: the angles
/// of arm and bucket differ.
const REPEATS: f64 = 0.04;
/// Averaging time of equally certain rows [s]: the first rows of a dump change the mean little.
const MEAN: f64 = 1.0;

/// A constant content.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Level {
    /// Best estimate: that of the row with the smallest standard deviation, trusted rows first.
    pub(super) weight: Weight,
    pub(super) trusted: bool,
    pub(super) why: u32,
    pub(super) witness: Witness,
    /// Value of its first row: a content that creeps away from it is another.
    pub(super) first: Quantity,
    /// Time over which equally certain rows have been averaged [s].
    pub(super) mean_of: f64,
    /// First and last row [s].
    pub(super) from: f64,
    pub(super) to: f64,
    /// Time at which the previous content was left [s].
    pub(super) left: f64,
    /// Whether another content has come.
    pub(super) is_over: bool,
    /// Whether it has been carried to where it may be dumped, and a change was detected there.
    pub(super) may_lack_a_part: bool,
}

impl Level {
    /// A level of one row.
    pub(super) fn new(row: &Row, value: Quantity, left: f64) -> Self {
        Self {
            weight: Weight::new(value, row.common),
            trusted: row.trusted,
            why: row.why,
            witness: row.witness,
            first: value,
            mean_of: 0.0,
            from: row.time,
            to: row.time,
            left,
            is_over: false,
            may_lack_a_part: false,
        }
    }

    /// Takes one more row: a more certain one replaces the estimate, an equally certain one joins the mean. The weight of a rest replaces
    /// none that is as trusted.
    pub(super) fn join(&mut self, row: &Row, value: Quantity) {
        let dt = row.time - self.to;
        self.to = row.time;
        let replaces = row.trusted && !self.trusted;
        if self.trusted && !row.trusted || !replaces && self.lacks_a_part(value) {
            return;
        }
        if (row.trusted && !self.trusted) || value.std < MORE_CERTAIN * self.weight.std {
            self.weight = Weight::new(value, row.common);
            (self.trusted, self.why, self.witness) = (row.trusted, row.why, row.witness);
            self.mean_of = 0.0;
        } else if value.std * MORE_CERTAIN <= self.weight.std {
            self.mean_of += dt;
            let share = dt / self.mean_of.min(MEAN).max(2.0 * dt);
            self.weight.kg += share * (value.value - self.weight.kg);
        }
    }

    /// Whether this value is rather that of a rest than of the whole. Both hypotheses are equally likely before:
    /// ```text
    /// whole   N(value; kg, b^2 - a^2 + (REPEATS kg)^2)      rest   uniform from 0 to kg
    /// ```
    /// b, a: standard deviations of the estimate and of the value. Of two estimates of one content by one filter, the later contains the
    /// information of the former. So the variance of their difference is the difference of their variances (Hausman 1978, theorem 2.1).
    fn lacks_a_part(&self, value: Quantity) -> bool {
        let Weight { kg, std, .. } = self.weight;
        if !self.may_lack_a_part || value.value >= kg {
            return false;
        }
        let gained = (std * std - value.std * value.std).max(0.0);
        let whole = Quantity {
            value: kg,
            std: norm(&[sqrt(gained), REPEATS * kg]),
        };
        let exact = Quantity { std: 0.0, ..value };
        // The constant of the normal density, which the likelihood omits, is on the other side.
        log_likelihood(exact, whole) < ln(sqrt(TAU) / kg)
    }

    /// Marks it as not weighed: without a better estimate it is an average load. The whole error is common to all loads.
    pub(super) fn guess(&mut self, any: Quantity) {
        if self.weight.std > any.std {
            (self.weight.kg, self.weight.std) = (any.value, any.std);
        }
        self.witness = Witness::Nothing;
        self.trusted = false;
        self.weight.common_std = self.weight.std;
        self.weight.known = CommonError::default();
    }

    /// Whether a value may belong to this content; differences up to `floor` count as none.
    pub(super) fn holds(&self, value: Quantity, floor: f64) -> bool {
        let near = |kg: f64, std: f64| {
            let apart = APART * value.std.max(std);
            (value.value - kg).abs() <= apart.max(floor)
        };
        near(self.weight.kg, self.weight.std) && near(self.first.value, self.first.std)
    }

    /// Duration for which it has been seen [s].
    pub(super) fn age(&self) -> f64 {
        self.to - self.from
    }
}

/// Logarithm of the likelihood of a value under a normal distribution `truth`, without the constant.
pub(super) fn log_likelihood(value: Quantity, truth: Quantity) -> f64 {
    let std = norm(&[value.std, truth.std]);
    let off = (value.value - truth.value) / std;
    -0.5 * off * off - ln(std)
}
