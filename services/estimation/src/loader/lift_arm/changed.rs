//! Probability that a sensor of the arm has changed, from steps of the moment and from the weights of emptied buckets.
//!
//! Bayes' rule updates the odds of two hypotheses (changed, unchanged) where a step of the moment stays (`steps`), and where an emptied
//! bucket shows x:
//! ```text
//! step that stays:   o += CHANGES/BLOWS
//! emptied bucket:    o = [o/2 max N(x; c, S) + (T/T_c)/C] / [(1 - p) N(x; t, S) + p/C]
//! ```
//! | symbol | meaning | unit |
//! |---|---|---|
//! | o | odds that a sensor has changed, q/(1 - q) | 1 |
//! | t | expected x without a change: what earlier emptied buckets showed, 0 before the first | kg |
//! | c | expected x after a change: predicted from the step, as a zero or as a scale, or the last x | kg |
//! | S | variance of the rows, scaled by how well buckets repeat ([`Repeats`]), of sticking material, and of t | kg^2 |
//! | p | share of tipped buckets that retain a part of their load, uniform over C; 0 for x below t | 1 |
//! | T, T_c | time since the last emptied bucket, mean time between two changes of a sensor | s |
//! | C | what the bucket may carry | kg |
//!
//! A bucket tipped in the air is empty, whatever it showed before. It is used once, by its row of least deviation until it turns again.
//! S is smaller for x below t: no more can be missing than what stuck in the bucket before.
//!
//! The variance of t grows with time, since zeros drift as they warm up. It also grows where the arm's posture differs from that of the
//! earlier buckets, since errors of the drawing then have another effect.
//!
//! So an emptied bucket with its former weight revokes a step: it was a blow. One with the weight predicted by the step confirms the change.
//! Without a step, the second emptied bucket with the same wrong weight indicates a change. A bucket of equal likelihood under both
//! hypotheses halves the odds.

use super::content::Motion;
use super::doubt::Doubts;
use super::numbers::NUMBERS;
use super::steps::Stepped;
use crate::Quantity;
use crate::math::{exp, norm, sqrt};
use crate::repeats::{BETWEEN_CHANGES, Repeats};

/// Odds that a step which stays is a change of a sensor: blows that look like one are as frequent.
const CHANGES_OVER_BLOWS: f64 = 1.0;
/// The same of steps that work makes too: a low bucket of a standing machine that shows less than 0 afterwards has probably been put down
/// at once, and a jolt turns the friction of the seals.
const CHANGES_OVER_WORK: f64 = 0.04;
/// Random walk of an emptied bucket's weight as zeros warm up, as a share of the capacity [1/s^.5]: a bar of each pressure, .0125, in a
/// quarter of an hour.
const WARMS: f64 = 4.2e-4;
/// Share of tipped buckets that retain a part of their load: frozen or sticky material.
const PARTS: f64 = 0.03;
/// Standard deviation of the material sticking in an emptied bucket, as a share of the capacity.
const STICKS: f64 = 0.03;
/// The same for a bucket lighter than before: no more can be missing than what stuck in it then.
const STUCK_BEFORE: f64 = 0.015;
/// Standard deviation of a row, as a share of the capacity: largest one that is used, and one at which no better row is awaited.
const TOLD: f64 = 0.05;
const SHARP: f64 = 0.02;
/// Share of the capacity beyond which a bucket holds a load.
const LOADED: f64 = 0.2;
/// Angle of the bucket in the air below which it is tipped [rad]: loose material slides from half a radian on.
const TIPPED: f64 = -0.5;
/// Squared normalised residual within which an emptied bucket agrees with the earlier ones.
const AGREES: f64 = 4.0;
/// Probability of a change beyond which the sensor is not trusted.
pub(super) const DOUBTED: f64 = 0.05;
/// Share of changed sensors for which neither a zero nor a scale predicts the weight of an emptied bucket.
const OTHERWISE: f64 = 0.5;
/// Largest odds.
const MOST: f64 = 1e6;

/// Odds of a change, and state of the bucket.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Changed {
    /// Odds that a sensor has changed.
    odds: f64,
    /// t: weight of emptied buckets without a change; none before the first [kg].
    tare: Option<Quantity>,
    /// Effect of each number of the drawing on those [kg].
    drawn: [f64; NUMBERS],
    repeats: Repeats,
    /// c: weight of an emptied bucket after a change, as a zero and as a scale [kg].
    others: [f64; 2],
    /// The bucket has held a load; it has been tipped in the air. Both are reset when it is used.
    loaded: bool,
    tipped: bool,
    /// The bucket is tipped in this row.
    down: bool,
    /// Weight of the emptied bucket with the least standard deviation so far [kg].
    sharpest: Option<Quantity>,
    /// Time since the last emptied bucket [s].
    since: f64,
}

/// Observation of the bucket in a row.
pub(super) struct Bucket<'a> {
    /// Its content by the rows [kg].
    pub shown: Quantity,
    /// Effects of the drawing's uncertain numbers on that.
    pub doubts: &'a Doubts,
    pub motion: &'a Motion,
    /// Its angle to the horizontal; none where it is not in the air [rad].
    pub in_the_air: Option<f64>,
    /// It was emptied by another criterion (`tare`).
    pub is_empty: bool,
    /// The ground may carry a part of it.
    pub rests: bool,
    /// Capacity [kg].
    pub capacity: f64,
}

impl Changed {
    /// Updates with a step that stays. `empty`: weight of arm and bucket alone at the cylinders [kg]; `works`: work makes such steps
    /// too.
    pub fn step(&mut self, step: Stepped, empty: f64, works: bool) {
        if self.odds == 0.0 {
            self.others = [self.tare.map_or(0.0, |tare| tare.value); 2];
        }
        self.odds = if works {
            self.odds.max(CHANGES_OVER_WORK)
        } else {
            (self.odds + CHANGES_OVER_BLOWS).min(MOST)
        };
        self.others[0] += step.by;
        self.others[1] += step.share * empty;
    }

    /// Updates with a row, `dt` after the last.
    pub fn see(&mut self, bucket: &Bucket<'_>, dt: f64) {
        self.since += dt;
        let Bucket {
            shown,
            motion,
            capacity,
            ..
        } = *bucket;
        let is_open = motion.open || motion.changing > 0.0;
        if let Some(sharpest) = self.sharpest
            && (is_open || sharpest.std < SHARP * capacity)
        {
            (self.sharpest, self.loaded, self.tipped) = (None, false, false);
            self.emptied(sharpest, bucket.doubts, capacity);
        }
        if motion.held {
            self.tipped = false;
        }
        // A tipped bucket is empty, whatever it held; one that stays tipped counts once.
        let down = bucket.in_the_air.is_some_and(|angle| angle < TIPPED);
        self.tipped |= down & !core::mem::replace(&mut self.down, down);
        if is_open || bucket.rests || shown.std > TOLD * capacity {
            return;
        }
        if self.tipped || self.loaded && bucket.is_empty {
            let sharper = self.sharpest.is_none_or(|last| shown.std < last.std);
            if sharper {
                self.sharpest = Some(shown);
            }
        } else {
            self.loaded |= shown.value > LOADED * capacity;
        }
    }

    /// Expected weight of an emptied bucket without a change; `warmed`: drift of the zeros since the last one [kg].
    fn expected(&self, doubts: &Doubts, warmed: f64) -> Quantity {
        let Some(Quantity { value, std }) = self.tare else {
            return Quantity {
                value: 0.0,
                std: doubts.shown(),
            };
        };
        let elsewhere = doubts.between(&self.drawn);
        Quantity {
            value,
            std: norm(&[std, warmed, elsewhere]),
        }
    }

    /// Updates the odds with the weight of an emptied bucket.
    #[cold]
    #[inline(never)]
    fn emptied(&mut self, shown: Quantity, doubts: &Doubts, capacity: f64) {
        let since = core::mem::take(&mut self.since);
        let before = self.expected(doubts, WARMS * sqrt(since) * capacity);
        let away = shown.value - before.value;
        // Retained material makes it heavier; it is lighter by no more than what stuck in it before.
        let (sticks, parts) = if away > 0.0 {
            (STICKS, PARTS / capacity)
        } else {
            (STUCK_BEFORE, 0.0)
        };
        let rows = sqrt(self.repeats.share()) * shown.std;
        let known = norm(&[rows, sticks * capacity, before.std]);
        let density = |away: f64| {
            let z = away / known;
            exp(-0.5 * z * z) / (2.5 * known)
        };
        let same = (1.0 - PARTS) * density(away) + parts;
        let as_foretold = self.others.map(|other| density(shown.value - other));
        let changed = OTHERWISE * self.odds * as_foretold[0].max(as_foretold[1]);
        let recent = since / BETWEEN_CHANGES / capacity;
        self.odds = ((changed + recent) / same.max(f64::MIN_POSITIVE)).min(MOST);
        if recent > changed {
            self.others = [shown.value; 2];
        }
        if self.is_doubted() {
            return;
        }
        let agrees = away * away < AGREES * known * known;
        if self.tare.is_some() {
            self.repeats.see(away / shown.std, agrees);
        }
        if agrees {
            self.odds = 0.0;
            let gain = before.std * before.std / (known * known);
            self.tare = Some(Quantity {
                value: before.value + gain * away,
                std: sqrt(1.0 - gain) * before.std,
            });
            for (drawn, here) in self.drawn.iter_mut().zip(doubts.of_payloads()) {
                *drawn += gain * (here - *drawn);
            }
        }
    }

    /// Probability that a sensor has changed.
    pub fn probability(&self) -> f64 {
        self.odds / (1.0 + self.odds)
    }

    /// A change is so probable that the sensor is not trusted.
    pub fn is_doubted(&self) -> bool {
        self.probability() > DOUBTED
    }
}

#[cfg(test)]
mod tests {
    use super::super::numbers::{BASE, HEAD_ZERO};
    use super::*;

    const CAPACITY: f64 = 1500.0;
    /// Weight of arm and bucket at the cylinders [kg].
    const EMPTY: f64 = 600.0;

    /// A drawing with an error of this standard deviation [kg].
    fn drawn(std: f64) -> Doubts {
        let mut doubts = Doubts::default();
        doubts.put(HEAD_ZERO, [std, 0.0, 0.0]);
        doubts
    }

    /// Tips a load of this weight; the emptied bucket shows `shown` [kg].
    fn dump(changed: &mut Changed, load: f64, shown: f64) {
        let doubts = drawn(60.0);
        let motion = |open| Motion {
            turning: open,
            changing: f64::from(open),
            open,
            ..Motion::default()
        };
        let rows = [
            (load, 0.8, false),
            (load, -0.7, true),
            (shown, -0.7, false),
            (shown, 0.1, true),
        ];
        for (value, angle, open) in rows {
            let bucket = Bucket {
                shown: Quantity { value, std: 40.0 },
                doubts: &doubts,
                motion: &motion(open),
                in_the_air: Some(angle),
                is_empty: false,
                rests: false,
                capacity: CAPACITY,
            };
            changed.see(&bucket, 10.0);
        }
    }

    fn stepped(by: f64, share: f64) -> Stepped {
        Stepped {
            by,
            share,
            level: by,
        }
    }

    #[test]
    fn a_step_that_work_makes_too_needs_an_emptied_bucket() {
        let mut landed = sound();
        (0..5).for_each(|_| landed.step(stepped(-500.0, -0.8), EMPTY, true));
        assert!(landed.probability() < DOUBTED);
        let mut in_the_air = sound();
        in_the_air.step(stepped(-500.0, -0.8), EMPTY, false);
        assert!(in_the_air.probability() > DOUBTED);
    }

    /// After three loads of a sound machine.
    fn sound() -> Changed {
        let mut changed = Changed::default();
        for shown in [30.0, -10.0, 20.0] {
            dump(&mut changed, 1000.0, shown);
        }
        assert_eq!(changed.probability(), 0.0);
        changed
    }

    #[test]
    fn a_step_is_doubted_until_an_emptied_bucket_identifies_its_cause() {
        for share in [-0.4, 1.0] {
            let step = stepped(share * (1000.0 + EMPTY), share);
            let mut blow = sound();
            blow.step(step, EMPTY, false);
            assert!(blow.probability() > DOUBTED);
            dump(&mut blow, 1000.0, 15.0);
            assert_eq!(blow.probability(), 0.0, "it weighs what it did");
            for shown in [share * EMPTY, step.by] {
                let mut sensor = sound();
                sensor.step(step, EMPTY, false);
                dump(&mut sensor, 1000.0, shown);
                assert!(sensor.probability() > 0.9, "{share} {shown}");
            }
        }
    }

    #[test]
    fn the_second_emptied_bucket_with_the_same_wrong_weight_is_a_change_without_a_step() {
        let mut changed = sound();
        dump(&mut changed, 1000.0, 600.0);
        assert!(changed.probability() < DOUBTED, "a part of a load");
        dump(&mut changed, 1000.0, 600.0);
        assert!(changed.probability() > DOUBTED);
        (0..2).for_each(|_| dump(&mut changed, 1000.0, 10.0));
        assert_eq!(changed.probability(), 0.0, "it was mended");
        let mut less = sound();
        dump(&mut less, 1000.0, -300.0);
        assert!(less.probability() > DOUBTED, "nothing weighs so");
        let mut parts = sound();
        for shown in [200.0, 500.0, 20.0, 350.0] {
            dump(&mut parts, 1000.0, shown);
        }
        assert!(parts.probability() < DOUBTED);
    }

    #[test]
    fn a_bucket_that_weighs_a_little_less_is_found_once_buckets_have_agreed() {
        let found_after = |buckets: u32| {
            let mut changed = Changed::default();
            (0..buckets).for_each(|k| dump(&mut changed, 1000.0, f64::from(k % 3) * 15.0));
            let less = (1..9).find(|_| {
                dump(&mut changed, 1000.0, -105.0);
                changed.is_doubted()
            });
            less.expect("it is found")
        };
        assert!(found_after(40) <= 2, "{}", found_after(40));
        assert!(found_after(3) > 2, "nothing is known of them yet");
    }

    /// Normal deviates from a fixed seed.
    fn normal() -> impl FnMut() -> f64 {
        let mut seed = 1_u64;
        move || {
            let uniform = core::iter::repeat_with(|| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (seed >> 11) as f64 / (1_u64 << 53) as f64
            });
            uniform.take(12).sum::<f64>() - 6.0
        }
    }

    #[test]
    fn sound_buckets_that_retain_varying_amounts_are_trusted() {
        let (mut normal, mut changed) = (normal(), Changed::default());
        let mut mud = 0.0;
        let doubted = (0..20_000).filter(|k| {
            if k % 10 == 0 {
                mud = 0.5 * STICKS * CAPACITY * normal().abs();
            }
            dump(&mut changed, 1000.0, mud + 25.0 * normal());
            changed.is_doubted()
        });
        let doubted = doubted.count();
        assert!(doubted < 20, "{doubted}");
    }

    #[test]
    fn where_the_arm_stands_otherwise_the_drawing_may_show_otherwise() {
        let shows = |number: usize| {
            let mut changed = sound();
            (0..20).for_each(|_| dump(&mut changed, 1000.0, 10.0));
            let mut doubts = drawn(60.0);
            doubts.put(number, [60.0, 0.0, 0.0]);
            let shown = Quantity {
                value: -140.0,
                std: 20.0,
            };
            for _ in 0..2 {
                changed.since = 20.0;
                changed.emptied(shown, &doubts, CAPACITY);
            }
            changed.is_doubted()
        };
        assert!(shows(HEAD_ZERO), "it stands as before");
        assert!(!shows(BASE));
    }

    #[test]
    fn odds_fade_where_both_hypotheses_are_equally_likely() {
        let mut changed = sound();
        changed.step(stepped(40.0, 0.04), EMPTY, false);
        (0..8).for_each(|_| dump(&mut changed, 1000.0, 15.0));
        assert_eq!(changed.probability(), 0.0);
    }

    #[test]
    fn a_load_that_shows_as_none_is_tipped_all_the_same() {
        let mut halved = sound();
        for _ in 0..2 {
            dump(&mut halved, 150.0, -330.0);
        }
        assert!(halved.probability() > 0.9);
    }

    #[test]
    fn one_tipping_counts_once_by_its_sharpest_row() {
        let mut changed = sound();
        let (motion, doubts) = (Motion::default(), drawn(60.0));
        let still = |value, std, angle| Bucket {
            shown: Quantity { value, std },
            doubts: &doubts,
            motion: &motion,
            in_the_air: Some(angle),
            is_empty: false,
            rests: false,
            capacity: CAPACITY,
        };
        changed.see(&still(1000.0, 40.0, 0.8), 10.0);
        for std in [70.0, 50.0, 29.0] {
            changed.see(&still(500.0, std, -0.7), 0.01);
        }
        assert_eq!(changed.sharpest.map(|shown| shown.std), Some(29.0));
        changed.see(&still(500.0, 28.0, -0.7), 0.01);
        let once = changed.odds;
        assert!(once > 0.0);
        for _ in 0..100 {
            changed.see(&still(500.0, 20.0, -0.7), 0.01);
        }
        assert_eq!(changed.odds, once);
    }
}
