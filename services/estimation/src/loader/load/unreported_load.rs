//! Probability that an unreported load has replaced the one under which the ratio was estimated.
//!
//! A loader fills and empties its bucket slowly. Force over acceleration identifies the load as soon as the torques move the machine, at
//! any speed. Two filters of kappa, c and z (`inertia`) start from the estimate before the machine was idle: one with the same load, one
//! with another, which moves kappa by d. Bayes' rule weights them (an interacting multiple model; Blom, Bar-Shalom 1988):
//! ```text
//! idle:     q+ = q + (1 - q) dt/T,   and the other filter mixes with the first one's state, moved by d, by that share of q
//! moving:   q/(1 - q) *= N(y_other; 0, S_other)/N(y_same; 0, S_same)
//! ```
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | q | `probability` | the load is another one | 1 |
//! | T | `BETWEEN` | idle time between two changes: the machine stands, or is slow while a force acts that the torques do not explain | s |
//! | d | - | change of kappa by another load | 1 |
//! | y, S | - | innovation of the acceleration in either filter, and its variance | m/s^2 |
//!
//! Both filters start with z unknown, so resistance in the other direction and the accelerometer's zero favour neither of them.

use super::inertia::{Force, LARGEST};
use crate::math::{exp, ln, sqrt};
use crate::mixture::mix;

/// Speed below which a bucket may be filled against the ground [m/s]: penetration in a V cycle.
pub const SLOW: f64 = 1.5;
/// Mean idle time between two changes [s]: a V cycle of 40 s has two, and is idle for half of it.
pub const BETWEEN: f64 = 10.0;
/// The same where each row states a mass that has never changed [s]: one change in a hundred is not in it.
pub const BETWEEN_STATED: f64 = 1000.0;
/// Usual load, as a share of the loaded machine: rated payload over operating mass with it.
const USUAL_LOAD: f64 = 0.22;
/// Share of the usual load beyond which the machine counts as loaded.
const HALF: f64 = 0.5;
/// Standard deviation of d: from a third of a bucket to a heaped one.
const OTHER_STD: f64 = 0.08;
/// Probability below which another load is neglected, and least distance from 1: the noise model is not exact.
const LEAST: f64 = 1e-3;

/// Probability of another load, and the two filters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct UnreportedLoad {
    /// q.
    probability: f64,
    /// Filters with the same load and with another, since the machine was idle.
    filters: Option<[Force; 2]>,
}

impl UnreportedLoad {
    /// Updates with a row of smoothed `signals`; `known`: kappa after it. `idle`: the row's idle time over the mean one between two changes;
    /// it `counts` where the torques alone move the machine.
    pub fn see(&mut self, signals: [f64; 3], known: &Force, idle: f64, counts: bool, dt: f64) {
        if idle > 0.0 {
            self.idle(known, idle);
        }
        let Some([same, other]) = &mut self.filters else {
            return;
        };
        if !counts {
            return;
        }
        let [first, second] = [same, other].map(|filter| filter.see(signals, dt));
        if first[0].abs().min(second[0].abs()) < LARGEST {
            let unlikely = |[y, s]: [f64; 2]| y * y / s + ln(s);
            let likelier = 0.5 * (unlikely(first) - unlikely(second));
            let unchanged = (1.0 - self.probability).max(LEAST) * exp(-likelier);
            self.probability = (self.probability / (self.probability + unchanged)).min(1.0 - LEAST);
        }
        // Once the probability is negligible, or not a number, the test ends.
        let least = LEAST * USUAL_LOAD * USUAL_LOAD;
        if self.probability.is_nan() || self.square() < least && idle == 0.0 {
            self.settle();
        }
    }

    /// Predicts over a share of the mean idle time between two changes.
    fn idle(&mut self, known: &Force, share: f64) {
        let changes = (1.0 - self.probability) * share;
        self.probability += changes;
        let [same, other] = self.filters.get_or_insert_with(|| {
            let mut known = *known;
            known.open_zero();
            [known; 2]
        });
        let loaded = same.state[0] < 1.0 - HALF * USUAL_LOAD;
        let by = if loaded { USUAL_LOAD } else { -USUAL_LOAD };
        let weight = changes / self.probability.max(f64::MIN_POSITIVE);
        let mut moved = *same;
        moved.state[0] += by;
        moved.covariance[0][0] += OTHER_STD * OTHER_STD;
        let moved = (&moved.state, &moved.covariance);
        mix(&mut other.state, &mut other.covariance, moved, weight);
    }

    /// Ends the test: the ratio is that of the present load.
    pub fn settle(&mut self) {
        *self = Self::default();
    }

    /// Root-mean-square change of the load by the mixture, as a share of the machine.
    pub fn share(&self) -> f64 {
        sqrt(self.square())
    }

    /// Mean square of that change.
    fn square(&self) -> f64 {
        self.filters.map_or(0.0, |[same, other]| {
            let away = other.state[0] - same.state[0];
            self.probability * (away * away + other.covariance[0][0])
        })
    }

    /// Probability of another load.
    #[cfg(test)]
    fn probability(&self) -> f64 {
        self.probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stands for `slow` seconds, then drives with this kappa, speed and zero of the accelerometer. Returns the probability before and after
    /// driving.
    fn drive(slow: u32, kappa: f64, speed: f64, zero: f64) -> [f64; 2] {
        let mut known = Force::default();
        known.covariance[0][0] = 1e-4;
        let mut unreported_load = UnreportedLoad::default();
        (0..100 * slow).for_each(|_| {
            unreported_load.see([zero, 0.0, 1.0], &known, 0.01 / BETWEEN, false, 0.01)
        });
        let before = unreported_load.probability();
        for k in 0..600 {
            let pull = f64::from(k % 300 < 200) * 0.8_f64.copysign(speed);
            let resists = 0.2_f64.copysign(speed);
            let signals = [kappa * pull - resists + zero, pull, 1.0_f64.copysign(speed)];
            unreported_load.see(signals, &known, 0.0, true, 0.01);
        }
        [before, unreported_load.probability()]
    }

    #[test]
    fn an_idle_machine_may_hold_another_load_and_a_driven_one_shows_it() {
        assert_eq!(drive(0, 1.0, 2.0, 0.0), [0.0; 2]);
        let [slow, same] = drive(10, 1.0, 2.0, 0.0);
        assert!((0.6..0.7).contains(&slow) && same < 0.05, "{slow} {same}");
        let [_, loaded] = drive(10, 1.0 - USUAL_LOAD, 2.0, 0.0);
        assert!(loaded > 0.95, "{loaded}");
    }

    #[test]
    fn the_zero_of_the_accelerometer_is_no_load_of_a_machine_that_turns_round() {
        for zero in [-0.1, 0.1] {
            let [_, same] = drive(10, 1.0, -2.0, zero);
            let [_, loaded] = drive(10, 1.0 - USUAL_LOAD, -2.0, zero);
            assert!(same < 0.2 && loaded > 0.8, "{zero} {same} {loaded}");
        }
    }
}
