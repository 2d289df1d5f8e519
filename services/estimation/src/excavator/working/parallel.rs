//! Is the torque's gain another one than stated?
//!
//! A torque that is wrong by a factor, and a velocity that is by its inverse, look like another inertia: what the bucket holds is
//! not known, and neither are upper body and bucket exactly. So a second filter runs in parallel with the gain opened, does all that the
//! first does, and the likelihoods of the innovations of both distinguish them (Bayes; a generalised likelihood ratio: Willsky,
//! Jones 1976). It may be as wrong as before, or a sensor has just broken: with each swing the second filter begins as the mixture of
//! both (moments of a mixture: generalised pseudo-Bayes of first order; Blom, Bar-Shalom 1988). The interval is that of the mixture
//! with the first ([`crate::mixture`]), and the filter that is far more probable is the estimate.

use super::super::doubts::Doubts;
use super::super::geometry::Inertia;
use super::super::size::Sticking;
use super::filter::{Filter, GAIN, Input};
use crate::kalman::Innovation;
use crate::math::{exp, ln, sqrt};
use crate::mixture::{POSSIBLE, spread};

/// Standard deviation of the factor by which a sensor may be wrong.
const GAIN_STD: f64 = 0.3;
/// Logarithm of the odds that a sensor has broken since the last swing.
const PRIOR_LOG_ODDS: f64 = -7.0;
/// The same of a torque that nobody has calibrated: of another machine, or in another unit (one machine in eleven).
const UNCALIBRATED_LOG_ODDS: f64 = -2.3;
/// The same where two pressures weigh too: one of the three is wrong on one machine in four.
const WEIGHED_LOG_ODDS: f64 = -1.0;
/// A gain that is stated more closely than this was calibrated; so was one that was found together with the masses.
const CALIBRATED_GAIN_STD: f64 = 0.01;
/// Logarithm of the odds at which it is the estimate: what the model leaves out makes the innovations say more than they know.
const ACCEPTED_LOG_ODDS: f64 = 5.0;
/// One measurement says no more than this.
const MAX_LOG_RATIO: f64 = 8.0;

/// The second filter.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ParallelFilter {
    pub(super) filter: Filter,
    /// Logarithm of its probability over the other's.
    odds: f64,
    /// The same where only the description is known.
    first: f64,
    /// Pressures that begin to weigh may be wrong, too.
    may_be_joined: bool,
    idle: bool,
    /// A torque has told something: before, both filters know the same.
    driven: bool,
}

impl ParallelFilter {
    /// At the start.
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

    /// Pressures weigh beside the torque from now on: wrong ones look like another gain.
    pub(super) fn is_joined_by_pressures(&mut self) {
        if core::mem::take(&mut self.may_be_joined) {
            self.odds += WEIGHED_LOG_ODDS - UNCALIBRATED_LOG_ODDS;
            self.first = WEIGHED_LOG_ODDS;
        }
    }

    /// Before anything has told the gain: it is known to this standard deviation, and may be another one.
    pub(super) fn knows_gain(&mut self, std: f64) {
        let variance = std * std + GAIN_STD * GAIN_STD;
        self.filter.set(GAIN, 0.0, variance, &mut None);
    }

    /// What both know is this from now on, and a sensor may have broken.
    pub(super) fn begins(&mut self, filter: &Filter) {
        self.filter = opened(filter);
        self.odds = PRIOR_LOG_ODDS;
    }

    /// What both know is the description: another gain is as likely as at the start.
    pub(super) fn is_as_described(&mut self) {
        self.odds = self.first;
    }

    /// The machine moves: what was known of the sensors may have changed while it stood.
    pub(super) fn set_off(&mut self, filter: &Filter) {
        if core::mem::take(&mut self.idle) {
            let [kept, broken] = [self.odds, PRIOR_LOG_ODDS].map(exp);
            self.filter = opened(filter).mixed(&self.filter, kept / (kept + broken));
            self.odds = ln(kept + broken);
        }
    }

    /// The machine stands; whether it did not before.
    pub(super) fn is_over(&mut self) -> bool {
        !core::mem::replace(&mut self.idle, true)
    }

    /// One tick of motion, and the velocity with its variance. `other`: the innovation of the other filter, and the ratio by which
    /// variances disagree; none where the motion says nothing of the torque.
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

    /// Innovations of both filters to one measurement, as variances disagree by a factor.
    pub(super) fn weigh(&mut self, both: [Innovation; 2], gate: f64, disagreement: f64) {
        self.weigh_anew(both, gate, disagreement, 0.0);
    }

    /// The same of a measurement that was weighed before, and is known better now; what it says, of which `before` is in the odds.
    pub(super) fn weigh_anew(
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
        let said = 0.5 * (squares[0] - squares[1] + volumes) / disagreement;
        let said = said.clamp(-MAX_LOG_RATIO, MAX_LOG_RATIO);
        self.odds = (self.odds + said - before).clamp(-50.0, 50.0);
        said
    }

    /// Changes places with the other filter where it is the more probable one.
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

    /// Another explanation, with these odds beforehand (logarithm), takes them from the gain that is off.
    pub(super) fn is_rivalled(&mut self, before: f64) {
        self.odds -= before;
    }

    /// Whether a torque has told something.
    pub(super) fn is_driven(&self) -> bool {
        self.driven
    }

    /// Variances that the mixture adds to those of the other filter: of payload [kg^2] and inertia [(kg m^2)^2].
    pub(super) fn variances(
        &self,
        sticks: &Sticking,
        payload: f64,
        inertia: f64,
        now: &Inertia,
    ) -> [f64; 2] {
        if !self.driven || self.odds <= POSSIBLE {
            return [0.0; 2];
        }
        let [variance, own] = self.filter.variances(now, sticks);
        let weight = self.filter.payload(sticks);
        let heavier = self.filter.inertia(now, self.filter.load()) - inertia;
        let probability = self.probability();
        [(weight - payload, variance), (heavier, own)].map(|(away, variance)| {
            let spread = spread(probability, away, sqrt(variance));
            spread * spread
        })
    }

    /// Whether its numbers are numbers.
    pub(super) fn is_finite(&self) -> bool {
        self.filter.is_finite() && self.odds.is_finite()
    }
}

/// Whether somebody has compared the torque.
pub(super) fn is_calibrated(doubts: &Doubts) -> bool {
    doubts.found.is_some() || doubts.gain_std <= CALIBRATED_GAIN_STD
}

fn opened(filter: &Filter) -> Filter {
    let mut parallel = filter.clone();
    parallel.p[GAIN][GAIN] += GAIN_STD * GAIN_STD;
    parallel
}
