//! Has a coupler changed the attachment?
//!
//! An emptied bucket that weighs something holds what sticks, or is another one: a mass beyond the known one, N(0, b²), which came while
//! nobody looked, so often an hour. As a content z ± sqrt(V) both hypotheses differ by one prior, N(0, a²) against N(0, a² + b²), so the
//! second needs no filter of its own: the ratio of the evidences is that of the densities of z (Dickey 1971; the same form as
//! [`super::tail`]). The interval is that of the mixture ([`crate::mixture`]). Where another attachment has more than half, the bucket's
//! mass is open by b from then on, and the content that was the difference becomes the bucket's.

use super::filter::{BUCKET, Filter, M, inertia_row};
use super::trail::Trail;
use crate::excavator::geometry::Inertia;
use crate::math::{exp, ln, sqrt};
use crate::mixture::spread;

/// Standard deviation of the masses of the buckets of one machine, as a share of the described one: from .5 (narrow) to 1.6 (for rock).
const OTHERS: f64 = 0.4;
/// So often is it changed [1/s]: once in an hour of work.
const CHANGES: f64 = 1.0 / 3600.0;
/// Logarithm of the odds below which another attachment adds nothing to an interval (1 in 20), and beyond which it is all the same.
const POSSIBLE: f64 = -2.95;
const MOST: f64 = 20.0;
/// Share of the variance of an emptied bucket's content below which anything else tells it.
const TOLD: f64 = 0.9;
/// An emptied bucket that weighs less than so many standard deviations is no question.
const STRANGE: f64 = 2.0;

/// The hypothesis that the attachment is another one.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Attachment {
    /// Standard deviation of the mass of another one \[kg\].
    pub(super) other: f64,
    /// Time since an emptied bucket was weighed last \[s\].
    since: f64,
    /// Logarithm of the odds, by what the bucket weighs now.
    odds: f64,
    /// Content that weighs as much as a kilogram of bucket \[kg\].
    share: f64,
    /// What the mixture adds to the variances of payload [kg^2] and inertia [(kg m^2)^2].
    added: [f64; 2],
    /// Nothing hangs on the coupler, or something that nobody has weighed.
    pub(super) bare: bool,
}

/// A content by everything but the prior of an emptied bucket, value and variance [kg, kg^2].
struct Weighed {
    value: f64,
    variance: f64,
}

impl Weighed {
    /// By a filter that has taken in that it is N(0, `emptied`), or has not.
    fn of(filter: &Filter, emptied: f64, tared: bool) -> Option<Self> {
        let (x, p) = (filter.x[M], filter.p[M][M]);
        if !tared {
            return Some(Self {
                value: x,
                variance: p,
            });
        }
        let left = emptied - p;
        (p > 0.0 && p < TOLD * emptied).then(|| Self {
            value: x * emptied / left,
            variance: p * emptied / left,
        })
    }

    fn is_strange(&self, emptied: f64, usual: f64) -> bool {
        self.value * self.value > STRANGE * STRANGE * (self.variance * usual + emptied)
    }
}

impl Attachment {
    pub(super) fn new(bucket: f64) -> Self {
        Self {
            other: OTHERS * bucket,
            since: 0.0,
            odds: f64::NEG_INFINITY,
            share: 0.0,
            added: [0.0; 2],
            bare: false,
        }
    }

    /// Time passes.
    pub(super) fn wait(&mut self, period: f64) {
        self.since += period;
    }

    /// The bucket holds something else.
    pub(super) fn forget(&mut self) {
        self.odds = f64::NEG_INFINITY;
        self.added = [0.0; 2];
    }

    /// Another attachment cannot be excluded.
    pub(super) fn is_possible(&self) -> bool {
        self.odds > POSSIBLE
    }

    /// It is the more probable one.
    pub(super) fn is_another(&self) -> bool {
        self.odds > 0.0
    }

    pub(super) fn probability(&self) -> f64 {
        let odds = exp(self.odds);
        odds / (1.0 + odds)
    }

    /// Logarithm of the odds, now and beforehand.
    pub(super) fn odds(&self) -> [f64; 2] {
        [self.odds, self.prior()]
    }

    pub(super) fn prior(&self) -> f64 {
        ln((CHANGES * self.since).min(0.5))
    }

    /// An emptied bucket weighs nothing: it is the one that it was.
    pub(super) fn is_known(&mut self) {
        self.since = 0.0;
        self.bare = false;
        self.forget();
    }

    /// Asks a filter of an emptied bucket, which holds N(0, `emptied`), `tared` or not yet; `usual`: ratio by which variances disagree. Whether
    /// another attachment is possible.
    pub(super) fn ask(
        &mut self,
        filter: &Filter,
        (emptied, tared): (f64, bool),
        usual: f64,
        now: &Inertia,
    ) -> bool {
        let weighed = Weighed::of(filter, emptied, tared);
        let Some(weighed) = weighed.filter(|weighed| weighed.is_strange(emptied, usual)) else {
            self.forget();
            return false;
        };
        self.share = now.per_bucket / now.per_payload.max(f64::MIN_POSITIVE);
        let share = self.share * self.other;
        let (z, v) = (weighed.value, weighed.variance * usual);
        let (same, other) = (v + emptied, v + emptied + share * share);
        let said = 0.5 * (ln(same / other) + z * z * (1.0 / same - 1.0 / other));
        self.odds = (self.prior() + said).min(MOST);
        if !self.is_possible() {
            self.added = [0.0; 2];
            return false;
        }
        let probability = self.probability();
        // Of the content proper, and of what content and bucket weigh more than thought.
        let (x, p) = (filter.x[M], filter.p[M][M]);
        let content = (z * emptied / other, emptied * (other - emptied) / other);
        let both = (z * (other - v) / other, v * (other - v) / other);
        let row = inertia_row(now);
        let per: f64 = row.iter().map(|(i, a)| a * filter.p[M][*i]).sum::<f64>() / p;
        let (_, own) = filter.combination(&row);
        let inertia = (
            per * (both.0 - x),
            (own + per * per * (both.1 - p)).max(0.0),
        );
        self.added = [(content.0 - x, content.1), inertia].map(|(away, variance)| {
            let std = spread(probability, away, sqrt(variance));
            std * std
        });
        true
    }

    /// What the mixture adds to the variances of payload [kg^2] and inertia [(kg m^2)^2].
    pub(super) fn variances(&self) -> [f64; 2] {
        self.added
    }

    /// What a filter has taken in, that an emptied bucket holds N(0, `emptied`), is taken back, where anything else tells its content.
    pub(super) fn take_back(&self, filter: &mut Filter, emptied: f64, trail: &mut Option<Trail>) {
        if filter.p[M][M] < TOLD * emptied {
            filter.without(M, (0.0, emptied), trail);
        }
    }

    /// The bucket's mass is open, and what bucket and content weigh together is not.
    pub(super) fn open(&self, filter: &mut Filter) {
        let (share, variance) = (self.share, self.other * self.other);
        filter.p[BUCKET][BUCKET] += variance;
        filter.p[M][M] += share * share * variance;
        filter.p[M][BUCKET] -= share * variance;
        filter.p[BUCKET][M] -= share * variance;
    }

    /// The mixture of both by its moments, where the content is over.
    pub(super) fn mix(&self, filter: &mut Filter, (emptied, tared): (f64, bool), gate: f64) {
        let mut other = filter.clone();
        if tared {
            self.take_back(&mut other, emptied, &mut None);
        }
        self.open(&mut other);
        let tare = |filter: &mut Filter| {
            let value = -filter.x[M];
            filter.measure([(M, 1.0)], value, emptied, gate, &mut None);
        };
        tare(&mut other);
        if !tared {
            tare(filter);
        }
        *filter = filter.clone().mixed(&other, self.probability());
    }
}
