//! Parallel filter for a torque gain other than the stated one.
//!
//! A torque that is wrong by a factor, or a velocity wrong by its inverse, looks like another inertia. Content, upper body and bucket are
//! not known exactly, so the inertia does not reveal it. A second filter therefore runs in parallel with the gain opened. The likelihoods
//! of the innovations of both distinguish the hypotheses (Bayes; a generalised likelihood ratio: Willsky, Jones 1976). The gain may be as
//! wrong as before, or a sensor may just have failed. With each swing the second filter therefore begins as a mixture: of itself, and of
//! the first one with the gain opened again. Its moments are those of the mixture (generalised pseudo-Bayes of first order; Blom,
//! Bar-Shalom 1988). The interval is that of the mixture with the first filter ([`crate::mixture`]), and the filter that is far more
//! probable is the estimate.

use super::super::doubts::Doubts;
use super::super::geometry::Inertia;
use super::super::size::Sticking;
use super::filter::{Filter, GAIN, Input};
use crate::kalman::Innovation;
use crate::math::{exp, ln, sqrt};
use crate::mixture::{POSSIBLE, spread};

/// Standard deviation of the gain of a failed sensor.
const GAIN_STD: f64 = 0.3;
/// Log odds that a sensor has failed since the last swing.
const PRIOR_LOG_ODDS: f64 = -7.0;
/// Log odds of a wrong gain where the torque is not calibrated: of another machine, or in another unit (one machine in eleven).
const UNCALIBRATED_LOG_ODDS: f64 = -2.3;
/// The same where two pressures weigh too: one of the three is wrong on one machine in four.
const WEIGHED_LOG_ODDS: f64 = -1.0;
/// Stated standard deviation of the gain up to which it counts as calibrated. A gain that was found together with the masses does too.
const CALIBRATED_GAIN_STD: f64 = 0.01;
/// Log odds at which the second filter becomes the estimate: unmodelled effects make the innovations more decisive than they should be.
const ACCEPTED_LOG_ODDS: f64 = 5.0;
/// Limit of the log likelihood ratio of one measurement.
const MAX_LOG_RATIO: f64 = 8.0;

/// The second filter.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ParallelFilter {
    pub(super) filter: Filter,
    /// Log odds of the second filter against the first.
    odds: f64,
    /// Log odds where only the description is known.
    first: f64,
    /// The odds rise when pressures begin to weigh, since these may be wrong too.
    may_be_joined: bool,
    /// The machine stands.
    idle: bool,
    /// A torque has informed the filters; before, both know the same.
    driven: bool,
}

impl ParallelFilter {
    /// Starts from a filter, with the gain opened.
    pub(super) fn new(filter: &Filter, doubts: &Doubts) -> Self {
        let calibrated = is_calibrated(doubts);
        let first = if calibrated {
            PRIOR_LOG_ODDS
        } else {
            UNCALIBRATED_LOG_ODDS
        };
        Self {
            filter: opened(filter),
            odds: first,
            first,
            may_be_joined: !calibrated,
            idle: true,
            driven: false,
        }
    }

    /// Raises the odds where pressures join the torque: wrong ones look like another gain.
    pub(super) fn is_joined_by_pressures(&mut self) {
        if core::mem::take(&mut self.may_be_joined) {
            self.odds += WEIGHED_LOG_ODDS - UNCALIBRATED_LOG_ODDS;
            self.first = WEIGHED_LOG_ODDS;
        }
    }

    /// Resets a gain that nothing has informed: stated to `std`, and opened.
    pub(super) fn knows_gain(&mut self, std: f64) {
        let variance = std * std + GAIN_STD * GAIN_STD;
        self.filter.set(GAIN, 0.0, variance, &mut None);
    }

    /// Restarts from the knowledge of a filter; a sensor may have failed.
    pub(super) fn begins(&mut self, filter: &Filter) {
        self.filter = opened(filter);
        self.odds = PRIOR_LOG_ODDS;
    }

    /// Restarts from the description: another gain is as likely as at the start.
    pub(super) fn is_as_described(&mut self) {
        self.odds = self.first;
    }

    /// Starts a motion: a sensor may have failed while the machine stood.
    pub(super) fn set_off(&mut self, filter: &Filter) {
        if core::mem::take(&mut self.idle) {
            let [earlier, broken] = [self.odds, PRIOR_LOG_ODDS].map(exp);
            self.filter = opened(filter).mixed(&self.filter, earlier / (earlier + broken));
            self.odds = ln(earlier + broken);
        }
    }

    /// Ends a motion; returns whether there was one.
    pub(super) fn is_over(&mut self) -> bool {
        !core::mem::replace(&mut self.idle, true)
    }

    /// Processes one tick of motion and the velocity with its variance. `other`: innovation of the first filter, and ratio of the
    /// observed to its predicted variance; `None` where the motion carries no information about the torque.
    pub(super) fn step(
        &mut self,
        input: &Input,
        (width, least): (f64, f64),
        measured: Option<(f64, f64)>,
        gate: f64,
        other: Option<(Innovation, f64)>,
    ) {
        self.driven = true;
        self.filter.predict(input, width, least, &mut None);
        if let Some((velocity, variance)) = measured {
            let own = self.filter.correct(velocity, variance, gate, &mut None);
            if let Some((innovation, disagreement)) = other {
                self.weigh([innovation, own], gate, disagreement);
            }
        }
    }

    /// Updates the odds with the innovations of both filters to one measurement; `disagreement`: ratio of observed to predicted variance.
    pub(super) fn weigh(&mut self, both: [Innovation; 2], gate: f64, disagreement: f64) {
        self.weigh_again(both, gate, disagreement, 0.0);
    }

    /// The same for a measurement that was weighed before and is known better now. `before`: its log likelihood ratio that the odds
    /// include; returns the new one.
    pub(super) fn weigh_again(
        &mut self,
        both: [Innovation; 2],
        gate: f64,
        disagreement: f64,
        before: f64,
    ) -> f64 {
        if both.iter().any(|i| i.variance <= 0.0) {
            return before;
        }
        let squares = both.map(|i| i.nis().min(gate * gate));
        let volumes = ln(both[0].variance / both[1].variance);
        let ratio = 0.5 * (squares[0] - squares[1] + volumes) / disagreement;
        let ratio = ratio.clamp(-MAX_LOG_RATIO, MAX_LOG_RATIO);
        self.odds = (self.odds + ratio - before).clamp(-50.0, 50.0);
        ratio
    }

    /// Exchanges the filters where the second one is accepted as the more probable.
    pub(super) fn overtakes(&mut self, filter: &mut Filter) -> bool {
        let won = self.odds > ACCEPTED_LOG_ODDS;
        if won {
            core::mem::swap(&mut self.filter, filter);
            self.odds = -self.odds;
        }
        won
    }

    fn probability(&self) -> f64 {
        let odds = exp(self.odds.min(ACCEPTED_LOG_ODDS));
        odds / (1.0 + odds)
    }

    /// Raises the odds against a first filter that adopts a rival explanation, by the prior log odds `before` of that explanation
    /// (negative).
    pub(super) fn is_rivalled(&mut self, before: f64) {
        self.odds -= before;
    }

    /// Returns whether a torque has informed the filters.
    pub(super) fn is_driven(&self) -> bool {
        self.driven
    }

    /// Variances that the mixture adds to those of the first filter: of payload [kg^2], inertia [(kg m^2)^2] and gain.
    pub(super) fn variances(
        &self,
        sticks: &Sticking,
        [payload, inertia, gain]: [f64; 3],
        now: &Inertia,
    ) -> [f64; 3] {
        if !self.driven || self.odds <= POSSIBLE {
            return [0.0; 3];
        }
        let [variance, own] = self.filter.variances(now, sticks);
        let weight = self.filter.payload(sticks);
        let heavier = self.filter.inertia(now, self.filter.load()) - inertia;
        let probability = self.probability();
        let more = self.filter.x[GAIN] - gain;
        let gain = self.filter.p[GAIN][GAIN];
        let all = [(weight - payload, variance), (heavier, own), (more, gain)];
        all.map(|(away, variance)| {
            let spread = spread(probability, away, sqrt(variance));
            spread * spread
        })
    }

    /// Returns whether all numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.filter.is_finite() && self.odds.is_finite()
    }
}

/// Returns whether the torque has been compared with a reference.
pub(super) fn is_calibrated(doubts: &Doubts) -> bool {
    doubts.found.is_some() || doubts.gain_std <= CALIBRATED_GAIN_STD
}

/// Returns a copy with the gain opened.
fn opened(filter: &Filter) -> Filter {
    let mut parallel = filter.clone();
    parallel.p[GAIN][GAIN] += GAIN_STD * GAIN_STD;
    parallel
}
