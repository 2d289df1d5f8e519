//! Odds that a boom pressure sensor has changed.
//!
//! An emptied bucket holds next to nothing. Weighed by span, zero and friction as earlier buckets left them, it shows the same as those,
//! unless a sensor has changed. Bayes' rule at each emptied bucket:
//! ```text
//! o <- [o/2 N(r; c, S) + (T/T_c)/R] / [(1 - p) N(r; 0, S) + p/R],   S = lambda C^2 V
//! ```
//! | symbol | meaning | unit |
//! |---|---|---|
//! | o | odds that a sensor has changed | 1 |
//! | r | mass that the bucket shows, by the states as the consistent buckets before left them | kg |
//! | c | mass that the first bucket showed since a possible change | kg |
//! | V, C | variance of r by the filter; share of its root by which buckets scatter at first | kg^2, 1 |
//! | lambda | factor of that variance by the scatter observed since ([`Repeats`]) | 1 |
//! | p | share of the emptied buckets that retain part of their load, of any size | 1 |
//! | T, T_c | time since the last emptied bucket, and between two changes of a sensor | s |
//! | R | rated payload | kg |
//!
//! A single deviating bucket may have retained part of its load. A second one with the same deviation indicates the sensor. Where both
//! hypotheses explain a bucket equally, the odds halve. The filter takes in what it is shown. Without the earlier states as a reference,
//! a sensor change would be absorbed after some loads.

use super::filter::{BUCKET, HELD, LINKS, SPAN, Vector, ZERO};
use crate::Quantity;
use crate::math::{exp, sqrt};
use crate::repeats::{BETWEEN_CHANGES, Repeats};

/// States that emptied buckets identify, and loads hardly.
const IDENTIFIED: [usize; 5] = [SPAN, ZERO, HELD, BUCKET, LINKS];
/// Standard deviation above which a bucket carries no information, as a share of the rated payload.
const SHARP: f64 = 0.2;
/// Scatter of emptied buckets as a share of the filter's standard deviation, until it has been observed. It is .31 to .53 on eight
/// machines of independent simulators, .13 to .15 on heft's own.
const CLAIMED: f64 = 0.55;
/// Share of the emptied buckets that retain part of their load: frozen or sticky soil.
const PARTS: f64 = 0.03;
/// Square of the gate within which an emptied bucket is consistent with earlier ones [standard deviations squared].
const CONSISTENT: f64 = 4.0;
/// Least gain with which the reference follows a consistent bucket: zeros warm up, soil dries.
const LEAST_GAIN: f64 = 0.2;
/// Share of the changed sensors that show the next bucket as they showed the last.
const STAYS: f64 = 0.5;
/// Odds above which the pressures are not trusted (probability .05).
const DOUBTED: f64 = 0.05 / 0.95;
/// Upper limit of the odds.
const MOST: f64 = 1e3;

/// Memory of emptied buckets.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Changed {
    /// Reference: mean of the states that consistent buckets left.
    known: Option<Vector>,
    /// Number of those buckets.
    count: f64,
    repeats: Repeats,
    odds: f64,
    /// Mass that the first bucket showed since the pressures may have changed [kg].
    other: f64,
    /// Time since the last emptied bucket \[s\].
    since: f64,
}

impl Changed {
    /// Advances the time.
    pub(super) fn wait(&mut self, period: f64) {
        self.since += period;
    }

    /// Returns by how much these states change a measurement of `row x` against the reference, as far as emptied buckets identify them.
    pub(super) fn apart(&self, row: &[(usize, f64)], x: &Vector) -> f64 {
        let Some(known) = &self.known else {
            return 0.0;
        };
        let identified = row.iter().filter(|(i, _)| IDENTIFIED.contains(i));
        identified
            .map(|&(i, entry)| entry * (x[i] - known[i]))
            .sum()
    }

    /// Updates with an emptied bucket: the mass `shown` by the reference, and the states that it leaves. Where it may be another bucket
    /// (not `is_same`), it counts only if consistent with the others.
    pub(super) fn emptied(&mut self, shown: Quantity, x: &Vector, is_same: bool, rated: f64) {
        let is_sharp = shown.std < SHARP * rated;
        if !is_sharp {
            return;
        }
        let Some(known) = &mut self.known else {
            (self.known, self.count, self.since) = (Some(*x), 1.0, 0.0);
            return;
        };
        let claimed = CLAIMED * shown.std;
        let std = sqrt(self.repeats.ratio()) * claimed;
        let consistent = shown.value * shown.value < CONSISTENT * std * std;
        if !is_same && !consistent {
            return;
        }
        if !consistent && shown.value < 0.0 && self.count < 2.0 {
            // No bucket weighs less than an empty one: the first one had retained a part.
            (self.known, self.count, self.since) = (Some(*x), 1.0, 0.0);
            return;
        }
        let density = |away: f64| {
            let z = away / std;
            exp(-0.5 * z * z) / (2.5 * std)
        };
        let same = (1.0 - PARTS) * density(shown.value) + PARTS / rated;
        let changed = STAYS * self.odds * density(shown.value - self.other);
        let new_change = core::mem::take(&mut self.since) / BETWEEN_CHANGES / rated;
        self.odds = ((changed + new_change) / same).min(MOST);
        if new_change > changed {
            self.other = shown.value;
        }
        if self.odds > DOUBTED {
            return;
        }
        self.repeats.see(shown.value / claimed, consistent);
        if consistent {
            self.count += 1.0;
            let gain = LEAST_GAIN.max(1.0 / self.count);
            for (known, x) in known.iter_mut().zip(x) {
                *known += gain * (x - *known);
            }
        }
    }

    /// Resets for another bucket: the next emptied one is the reference.
    pub(super) fn forget(&mut self) {
        (self.known, self.odds) = (None, 0.0);
    }

    /// Odds that a sensor has changed.
    pub(super) fn odds(&self) -> f64 {
        self.odds
    }

    /// Returns whether a change is too probable for the pressures to be trusted.
    pub(super) fn is_doubted(&self) -> bool {
        self.odds > DOUBTED
    }
}

#[cfg(test)]
mod tests {
    use super::super::filter::N;
    use super::*;

    /// State after emptied buckets that show these masses [kg], 20 s apart, with a standard deviation of 25 kg by the filter.
    fn after(shown: &[f64], is_same: bool) -> Changed {
        let mut changed = Changed::default();
        for &value in shown {
            changed.wait(20.0);
            let shown = Quantity { value, std: 25.0 };
            changed.emptied(shown, &[0.0; N], is_same, 800.0);
        }
        changed
    }

    #[test]
    fn two_equal_deviations_indicate_the_sensor_and_one_does_not() {
        let sound = [3.0, -4.0, 6.0, 2.0, 5.0, -3.0];
        assert!(after(&sound, true).odds() < 1e-3);
        let with = |more: &[f64]| after(&[&sound, more].concat(), true);
        assert!(!with(&[60.0]).is_doubted());
        assert!(with(&[60.0, 55.0]).odds() > 1.0);
        // It retained a part, once.
        assert!(!with(&[60.0, 2.0]).is_doubted());
        assert!(!with(&[60.0, 2.0, 200.0, -5.0]).is_doubted());
        // A bucket that may be another one.
        let other = after(&[&sound[..], &[60.0; 9]].concat(), false);
        assert!(other.odds() < 1e-3);
    }

    #[test]
    fn buckets_that_scatter_as_claimed_are_consistent() {
        let sticky = [30.0, -20.0, 40.0, 10.0, -35.0, 25.0, 45.0, 40.0, -10.0];
        for count in 1..=sticky.len() {
            assert!(!after(&sticky[..count], true).is_doubted(), "{count}");
        }
    }

    #[test]
    fn what_the_filter_has_taken_in_since_is_still_seen() {
        let mut changed = after(&[0.0, 2.0], true);
        let mut x = [0.0; N];
        (x[ZERO], x[SPAN]) = (200.0, 0.01);
        let row = [(ZERO, 0.5), (SPAN, 1000.0), (super::super::filter::M, 40.0)];
        assert!((changed.apart(&row, &x) - 110.0).abs() < 1e-9);
        changed.forget();
        assert_eq!(changed.apart(&row, &x), 0.0);
    }
}
