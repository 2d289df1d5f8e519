//! How probable it is that a sensor of the arm shows otherwise than it did.
//!
//! Two hypotheses, weighed by Bayes' rule wherever a step of the moment stays (`steps`) and wherever a bucket has been emptied and shows x:
//! ```text
//! step that stays:   o += CHANGES/BLOWS
//! emptied bucket:    o = [o max N(x; c, S) + (T/T_c)/C] / [(1 - p) N(x; t, S) + p/C]
//! ```
//! | symbol | meaning | unit |
//! |---|---|---|
//! | o | odds that a sensor has changed, q/(1 - q) | 1 |
//! | t | what emptied buckets showed before, 0 where none did | kg |
//! | c | what they show if a sensor has changed: as foretold by the step, as a zero or as a scale, or as the last one did | kg |
//! | S | variance of what rows, what sticks and what is known of t or c leave open | kg^2 |
//! | p | share of the dumps that leave a part of the load, any | 1 |
//! | T, T_c | time since the last emptied bucket, and between two changes of a sensor | s |
//! | C | what the bucket may carry | kg |
//!
//! So one emptied bucket that weighs what it did takes a blow back. One that weighs what the step foretold confirms it. Where no step was seen, the
//! second emptied bucket that shows the same wrong weight tells.

use super::content::Motion;
use super::steps::Stepped;
use crate::Quantity;
use crate::math::{exp, norm, sqrt};

/// Blows that look like a change of a sensor are as frequent as such changes.
const CHANGES_OVER_BLOWS: f64 = 1.0;
/// Time between two changes of a sensor: a hundred hours of work [s].
const BETWEEN_CHANGES: f64 = 3.6e5;
/// Share of the dumps that leave a part of the load in the bucket.
const PARTS: f64 = 0.1;
/// What sticks in an emptied bucket, standard deviation as a share of the capacity.
const STICKS: f64 = 0.03;
/// What rows may leave open of a bucket that tells, as a share of the capacity.
const TOLD: f64 = 0.05;
/// From this share of the capacity on a bucket holds a load.
const LOADED: f64 = 0.2;
/// A bucket that turned so far below the horizontal, in the air, was tipped: loose material slides from half a radian on [rad].
const TIPPED: f64 = -0.5;
/// Probability beyond which the sensor is not believed.
pub(super) const DOUBTED: f64 = 0.05;
/// Odds beyond which nothing is more certain.
const MOST: f64 = 1e6;

/// Memory of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Changed {
    odds: f64,
    /// What emptied buckets show as long as nothing has changed, once one did [kg].
    tare: Option<Quantity>,
    /// What they show if something has [kg].
    others: [f64; 2],
    /// It held a load, and was tipped since.
    loaded: bool,
    tipped: bool,
    /// Time since the last emptied bucket [s].
    since: f64,
}

/// What is seen of a bucket in a row.
pub(super) struct Bucket<'a> {
    /// What the rows show of its content [kg].
    pub shown: Quantity,
    /// By how much the drawing may be off [kg].
    pub drawn: f64,
    pub motion: &'a Motion,
    /// Its angle to the horizontal where it is in the air [rad].
    pub in_the_air: Option<f64>,
    /// It was emptied in another way.
    pub is_empty: bool,
    /// What it may carry [kg].
    pub capacity: f64,
}

impl Changed {
    /// A step has stayed; `empty` is what the cylinders carry of arm and bucket alone [kg].
    pub fn step(&mut self, step: Stepped, empty: f64) {
        if self.odds == 0.0 {
            self.others = [self.tare.map_or(0.0, |tare| tare.value); 2];
        }
        self.odds = (self.odds + CHANGES_OVER_BLOWS).min(MOST);
        self.others[0] += step.by;
        self.others[1] += step.share * empty;
    }

    /// Takes a row, `dt` after the last.
    pub fn see(&mut self, bucket: &Bucket<'_>, dt: f64) {
        self.since += dt;
        let Bucket {
            shown,
            motion,
            capacity,
            ..
        } = *bucket;
        if motion.held {
            self.tipped = false;
        }
        self.tipped |= self.loaded && bucket.in_the_air.is_some_and(|angle| angle < TIPPED);
        if motion.open || motion.changing > 0.0 || shown.std > TOLD * capacity {
            return;
        }
        if self.tipped || self.loaded && bucket.is_empty {
            (self.loaded, self.tipped) = (false, false);
            self.emptied(shown, bucket.drawn, capacity);
        } else {
            self.loaded |= shown.value > LOADED * capacity;
        }
    }

    /// An emptied bucket shows this.
    fn emptied(&mut self, shown: Quantity, drawn: f64, capacity: f64) {
        let rows = norm(&[shown.std, STICKS * capacity]);
        let before = self.tare.unwrap_or(Quantity {
            value: 0.0,
            std: drawn,
        });
        let density = |mean: f64, std: f64| {
            let z = (shown.value - mean) / std;
            exp(-0.5 * z * z) / (2.5 * std)
        };
        let known = norm(&[rows, before.std]);
        let whole = (1.0 - PARTS) * density(before.value, known);
        let same = whole + PARTS / capacity;
        let as_foretold = self.others.map(|other| density(other, known));
        let changed = self.odds * as_foretold[0].max(as_foretold[1]);
        let anew = core::mem::take(&mut self.since) / BETWEEN_CHANGES / capacity;
        self.odds = ((changed + anew) / same).min(MOST);
        self.others = [shown.value; 2];
        if self.is_doubted() {
            return;
        }
        let away = (shown.value - before.value) / known;
        if away * away < 4.0 {
            // It weighs what it did.
            self.odds = 0.0;
            let gain = before.std * before.std / (known * known);
            self.tare = Some(Quantity {
                value: before.value + gain * (shown.value - before.value),
                std: sqrt(1.0 - gain) * before.std,
            });
        }
    }

    /// Probability that a sensor has changed.
    pub fn probability(&self) -> f64 {
        self.odds / (1.0 + self.odds)
    }

    /// It is too probable to be believed.
    pub fn is_doubted(&self) -> bool {
        self.probability() > DOUBTED
    }
}
