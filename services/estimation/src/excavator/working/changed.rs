//! How probable it is that the boom's pressures show otherwise than they did.
//!
//! An emptied bucket holds next to nothing. Who weighs it by what earlier ones told of span, zero and friction finds what he found then,
//! unless a sensor shows otherwise. Bayes' rule with each emptied bucket:
//! ```text
//! o <- [o/2 N(r; c, S) + (T/T_c)/R] / [(1 - p) N(r; 0, S) + p/R],   S = lambda C^2 V
//! ```
//! | symbol | meaning | unit |
//! |---|---|---|
//! | o | odds that a sensor has changed | 1 |
//! | r | what it shows, by the states as the buckets that were like each other left them | kg |
//! | c | what the first one showed since they may have changed | kg |
//! | V, C | variance that the filter claims of r, and by which share of its root buckets differ at first | kg^2, 1 |
//! | lambda | by how much more or less they have differed since ([`Repeats`]) | 1 |
//! | p | share of the emptied buckets that keep a part of their load, any | 1 |
//! | T, T_c | time since the last emptied bucket, and between two changes of a sensor | s |
//! | R | rated payload | kg |
//!
//! One bucket that is unlike the others may have kept a part. A second one that shows the same tells. What neither hypothesis tells apart
//! fades by a half. The filter takes in what it is shown: without the earlier states a sensor that has changed would be as ever after some loads.

use super::filter::{BUCKET, HELD, LINKS, SPAN, Vector, ZERO};
use crate::Quantity;
use crate::math::{exp, sqrt};
use crate::repeats::{BETWEEN_CHANGES, Repeats};

/// What emptied buckets tell of, and loads hardly.
const TOLD: [usize; 5] = [SPAN, ZERO, HELD, BUCKET, LINKS];
/// A claim beyond this share of the rated payload tells nothing.
const SHARP: f64 = 0.2;
/// Emptied buckets differ by this share of the deviation that is claimed, until they have shown by how much: .31 to .53 on eight machines of
/// others, .13 to .15 on ours.
const CLAIMED: f64 = 0.55;
/// Share of the emptied buckets that keep a part of their load: frozen, sticky.
const PARTS: f64 = 0.03;
/// Square of the standard deviations within which an emptied bucket is like the others.
const ALIKE: f64 = 4.0;
/// What the earlier states take at least of what a bucket like the others leaves: zeros warm up, soil dries.
const LEAST_GAIN: f64 = 0.2;
/// Share of the changed sensors that show the next bucket as they showed the last.
const STAYS: f64 = 0.5;
/// Odds beyond which the pressures are not believed (probability .05), and those beyond which nothing is more certain.
const DOUBTED: f64 = 0.05 / 0.95;
const MOST: f64 = 1e3;

/// Memory of emptied buckets.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Changed {
    /// The states as buckets that were like each other left them, in the mean; so many.
    known: Option<Vector>,
    count: f64,
    repeats: Repeats,
    odds: f64,
    /// What the first one showed since the pressures may have changed [kg].
    other: f64,
    /// Time since the last emptied bucket \[s\].
    since: f64,
}

impl Changed {
    /// Time passes.
    pub(super) fn wait(&mut self, period: f64) {
        self.since += period;
    }

    /// What these states make of a measurement of `row x` beyond what the earlier ones do.
    pub(super) fn apart(&self, row: &[(usize, f64)], x: &Vector) -> f64 {
        let Some(known) = &self.known else {
            return 0.0;
        };
        let told = row.iter().filter(|(i, _)| TOLD.contains(i));
        told.map(|&(i, entry)| entry * (x[i] - known[i])).sum()
    }

    /// An emptied bucket shows this by the earlier states, and leaves these. One of which nobody knows whether it is the same bucket tells
    /// nothing where it is unlike the others.
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
        let alike = shown.value * shown.value < ALIKE * std * std;
        if !is_same && !alike {
            return;
        }
        if !alike && shown.value < 0.0 && self.count < 2.0 {
            // Nothing weighs less than an empty bucket: the first one had kept a part.
            (self.known, self.count, self.since) = (Some(*x), 1.0, 0.0);
            return;
        }
        let density = |away: f64| {
            let z = away / std;
            exp(-0.5 * z * z) / (2.5 * std)
        };
        let same = (1.0 - PARTS) * density(shown.value) + PARTS / rated;
        let changed = STAYS * self.odds * density(shown.value - self.other);
        let anew = core::mem::take(&mut self.since) / BETWEEN_CHANGES / rated;
        self.odds = ((changed + anew) / same).min(MOST);
        if anew > changed {
            self.other = shown.value;
        }
        if self.odds > DOUBTED {
            return;
        }
        self.repeats.see(shown.value / claimed, alike);
        if alike {
            self.count += 1.0;
            let gain = LEAST_GAIN.max(1.0 / self.count);
            for (known, x) in known.iter_mut().zip(x) {
                *known += gain * (x - *known);
            }
        }
    }

    /// Another bucket: the next emptied one is the first.
    pub(super) fn forget(&mut self) {
        (self.known, self.odds) = (None, 0.0);
    }

    /// Odds that a sensor has changed.
    pub(super) fn odds(&self) -> f64 {
        self.odds
    }

    /// A change is too probable for the pressures to be believed.
    pub(super) fn is_doubted(&self) -> bool {
        self.odds > DOUBTED
    }
}

#[cfg(test)]
mod tests {
    use super::super::filter::N;
    use super::*;

    /// After emptied buckets that show this [kg], each 20 s after the one before, by rows that claim 25 kg.
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
    fn two_buckets_that_show_the_same_tell_and_one_does_not() {
        let sound = [3.0, -4.0, 6.0, 2.0, 5.0, -3.0];
        assert!(after(&sound, true).odds() < 1e-3);
        let with = |more: &[f64]| after(&[&sound, more].concat(), true);
        assert!(!with(&[60.0]).is_doubted());
        assert!(with(&[60.0, 55.0]).odds() > 1.0);
        // It kept a part, once.
        assert!(!with(&[60.0, 2.0]).is_doubted());
        assert!(!with(&[60.0, 2.0, 200.0, -5.0]).is_doubted());
        // A bucket of which nobody knows whether it is the same.
        let other = after(&[&sound[..], &[60.0; 9]].concat(), false);
        assert!(other.odds() < 1e-3);
    }

    #[test]
    fn buckets_that_differ_by_what_is_claimed_are_alike() {
        let sticky = [30.0, -20.0, 40.0, 10.0, -35.0, 25.0, 45.0, 40.0, -10.0];
        for told in 1..=sticky.len() {
            assert!(!after(&sticky[..told], true).is_doubted(), "{told}");
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
