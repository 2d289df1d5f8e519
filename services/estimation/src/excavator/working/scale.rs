//! Load by the boom's pressures alone, in a filter beside the one that has the torque too.
//!
//! Where torque and load contradict each other, the filter of both is wrong, and the failed sensor is unknown. Then this filter answers:
//! the torque errs most often, and has never informed it. With probability [`ERRS`] the pressures err in such a case, and the bucket may
//! hold anything. A load that no bucket can hold indicates that they do (Bayes): sensors on the wrong side of a load-holding valve show
//! less than nothing. An emptied bucket that weighs something indicates the same, by the likelihood ratio
//! ```text
//! p(z | they err)/p(z | they do not) = exp(z^2/2v)/sqrt(1 + A/v)
//! ```
//! with z the deviation of its first blocks from the expected moment, v its variance, and A the variance that any content of the bucket
//! adds.
//!
//! A filter that takes in both bends its constants until both fit. Where they begin to contradict each other, the torque therefore goes
//! on alone, and weighs each load beside this filter. The same ratio, for loads that both weigh and for emptied buckets, shows whether
//! they differ. Both are trusted again where they do not. Where the pressures err with odds of [`SURE`], the torque alone is trusted. An
//! emptied bucket may indicate that the pressures err before anything contradicts them. Then the torque goes on alone too, unless the
//! bucket may be another one: a coupler needs a stand ([`super::attachment`]).
//!
//! Differences between successive emptied buckets are more informative of a sensor that changes during work ([`super::changed`]).
//!
//! The filter has no motion, so a tick costs nothing: it updates with each block of the pressures.

use super::super::measurements::boom_moment::Moment;
use super::super::settings::Settings;
use super::super::size::Sticking;
use super::changed::Changed;
use super::filter::{Filter, GAIN, Input, M, SLOPE};
use super::weigh::{LASTS, Weigh, fits};
use crate::Quantity;
use crate::excavator::geometry::Inertia;
use crate::kalman::Innovation;
use crate::math::{exp, sqrt};

/// Probability that the pressures err where torque and load contradict each other, without other evidence.
const ERRS: f64 = 0.1;
/// Those odds, which are also the lower limit.
const LEAST_ODDS: f64 = ERRS / (1.0 - ERRS);
/// Upper limit of the odds.
const MOST_ODDS: f64 = 1e3;
/// Odds at which the pressures are taken to err: the 95 % interval leaves out as much.
const SURE: f64 = 20.0;
/// Variance of a load below which it is known, as a share of that of an unknown load.
const KNOWN: f64 = 0.1;
/// Limit of the log likelihood ratio of one emptied bucket or load.
const MAX_LOG_RATIO: f64 = 12.0;

/// Filter without motion.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Scale {
    pub(super) filter: Filter,
    /// Number of consecutive innovations beyond the gate.
    strange: u32,
    /// Odds that the pressures err.
    errs: f64,
    /// Torque and load contradict each other.
    contradicted: bool,
    /// The torque goes on alone.
    doubted: bool,
    /// Odds that torque and pressures weigh different loads.
    differs: f64,
    /// Difference between their weights of the present content.
    apart: Option<Innovation>,
    /// The bucket has been emptied, and has not been weighed since.
    asked: bool,
    /// An emptied bucket has just shown that the pressures err, and it is the bucket that weighed nothing before.
    misled: bool,
    changed: Changed,
}

impl Scale {
    /// Starts from the knowledge of a filter.
    pub(super) fn new(filter: &Filter) -> Self {
        let mut scale = Self {
            filter: filter.clone(),
            strange: 0,
            errs: LEAST_ODDS,
            contradicted: false,
            doubted: false,
            asked: false,
            misled: false,
            changed: Changed::default(),
            differs: LEAST_ODDS,
            apart: None,
        };
        scale.has_no_torque();
        scale
    }

    /// Restarts from the knowledge of a filter.
    pub(super) fn knows(&mut self, filter: &Filter) {
        self.filter = filter.clone();
        self.has_no_torque();
    }

    /// Fixes the gain: this filter weighs true masses.
    pub(super) fn has_no_torque(&mut self) {
        self.filter.set(GAIN, 0.0, 0.0, &mut None);
    }

    /// Sets another content of the bucket \[kg\]; `is_emptied`: the bucket has been emptied.
    pub(super) fn hold(&mut self, (value, std): (f64, f64), is_emptied: bool) {
        self.filter.set(M, value, std * std, &mut None);
        self.strange = 0;
        self.asked = is_emptied;
    }

    /// Removes the share of the load that leaves.
    pub(super) fn leave(&mut self, input: &Input) {
        self.filter.leave(input, &mut None);
    }

    /// Measures the slope by the inclinometer, unless its variance is below `known`; `variance`: of a sample.
    pub(super) fn incline(&mut self, slopes: [f64; 2], known: f64, variance: f64) {
        for (i, slope) in (SLOPE..).zip(slopes) {
            if self.filter.p[i][i] > known {
                let value = slope - self.filter.x[i];
                self.filter
                    .measure([(i, 1.0)], value, variance, 1e3, &mut None);
            }
        }
    }

    /// Resets the memory of emptied buckets, since the bucket may be another one.
    pub(super) fn has_another_bucket(&mut self) {
        self.changed.forget();
    }

    /// Updates with a block of the pressures; returns its innovation. `rated`: payload \[kg\]; `known`: the bucket cannot have been
    /// exchanged.
    pub(super) fn weigh(
        &mut self,
        weigh: &Weigh,
        settings: &Settings,
        moment: &Moment,
        (rated, known): (f64, bool),
    ) -> Innovation {
        self.changed.wait(moment.period);
        let apart = if self.asked {
            let (_, row) = weigh.model(&self.filter, moment);
            self.changed.apart(&row, &self.filter.x)
        } else {
            0.0
        };
        let innovation = weigh.measure(settings, moment, (&mut self.filter, true), &mut None);
        if moment.touches || fits(innovation) {
            self.strange = 0;
        } else {
            self.strange += 1;
        }
        let lasts = self.strange == LASTS;
        let per_payload = moment.per_payload;
        let anything = 0.25 * rated * rated;
        if self.asked && !moment.touches && (lasts || self.strange == 0) {
            self.asked = false;
            let moment_of_anything = anything * per_payload * per_payload;
            self.errs = weighed(self.errs, innovation, moment_of_anything);
            self.differs = weighed(self.differs, innovation, moment_of_anything);
            let shown = Quantity {
                value: (innovation.value + apart) / per_payload,
                std: sqrt(innovation.variance) / per_payload.abs(),
            };
            self.changed.emptied(shown, &self.filter.x, known, rated);
            self.errs = self.errs.max(self.changed.odds());
            self.misled = (self.errs >= SURE || self.changed.odds() > 1.0) && known;
        }
        if lasts {
            self.filter.p[M][M] += anything;
            self.strange = 0;
        }
        innovation
    }

    /// Returns whether an emptied bucket has just shown that the pressures err, and resets that.
    pub(super) fn is_misled(&mut self) -> bool {
        core::mem::take(&mut self.misled)
    }

    /// Updates whether the torque goes on alone, and returns whether this begins with the present block. It begins where torque and load
    /// begin to contradict each other, or where an emptied bucket shows that the pressures err. It ends where emptied buckets and loads
    /// show that both weigh equally.
    pub(super) fn doubts(&mut self, contradicted: bool) -> bool {
        let misled = self.is_misled() && !self.doubted;
        let begins = contradicted && !self.contradicted || misled;
        self.contradicted = contradicted;
        if begins {
            (self.differs, self.apart, self.doubted) = (1.0, None, true);
        }
        let errs = self.errs > 1.0 || self.changed.is_doubted();
        self.doubted &= self.differs > LEAST_ODDS || errs;
        begins
    }

    /// Returns whether the torque goes on alone.
    pub(super) fn is_doubted(&self) -> bool {
        self.doubted
    }

    /// Returns whether the filter of both may have taken in wrong measurements; `outright`: something is contradicted outright.
    pub(super) fn may_have_misled(&self, outright: bool) -> bool {
        self.doubted && (self.differs >= 1.0 || outright && self.differs > LEAST_ODDS)
    }

    /// Returns whether it is unknown which of both errs, or both are trusted although the pressures may have changed.
    pub(super) fn is_undecided(&self) -> bool {
        if self.doubted {
            self.errs < SURE
        } else {
            self.changed.is_doubted()
        }
    }

    /// Compares with a load weighed by the torque alone, still in the bucket, and its variance \[kg, kg^2\]; `anything`: variance of an
    /// unknown load [kg^2].
    pub(super) fn sees(&mut self, (load, variance): (f64, f64), anything: f64) {
        let own = self.filter.p[M][M];
        if variance.max(own) < KNOWN * anything {
            self.apart = Some(Innovation {
                value: self.filter.x[M] - load,
                variance: own + variance,
            });
        }
    }

    /// Ends a content: updates the odds that both weigh different loads.
    pub(super) fn compare(&mut self, anything: f64) {
        if let Some(apart) = self.apart.take() {
            self.differs = weighed(self.differs, apart, anything);
        }
    }

    /// Measures an emptied bucket as zero, with this variance [kg^2].
    pub(super) fn tare(&mut self, variance: f64, gate: f64) {
        let value = -self.filter.x[M];
        self.filter
            .measure([(M, 1.0)], value, variance, gate, &mut None);
    }

    /// Payload within the range of a bucket \[kg\], and inertia at a posture, each with its variance.
    pub(super) fn answer(
        &self,
        sticks: &Sticking,
        now: &Inertia,
        [least, most]: [f64; 2],
    ) -> [(f64, f64); 2] {
        let filter = &self.filter;
        let weight = filter.payload(sticks);
        let [left, variance] = filter.variances(now, sticks);
        let payload = weight.clamp(least, most);
        let beyond = weight - payload;
        let right = exp(-0.5 * beyond * beyond / left.max(1.0));
        let wrong = self.errs / (self.errs + right) * anything([least, most], payload);
        let g = now.per_payload;
        [
            (payload, left + wrong),
            (
                filter.inertia(now, filter.load() + payload - weight),
                variance + wrong * g * g,
            ),
        ]
    }
}

/// Variance of a content that may lie anywhere in a range, about an estimate [kg^2].
pub(super) fn anything([least, most]: [f64; 2], estimate: f64) -> f64 {
    let (width, away) = (most - least, estimate - 0.5 * (most + least));
    width * width / 12.0 + away * away
}

/// Updates the odds of any content against the expected one with an innovation; `anything`: variance that any content adds.
fn weighed(odds: f64, innovation: Innovation, anything: f64) -> f64 {
    let likelier = exp((0.5 * innovation.nis()).min(MAX_LOG_RATIO))
        / sqrt(1.0 + anything / innovation.variance);
    (odds * likelier).clamp(LEAST_ODDS, MOST_ODDS)
}

#[cfg(test)]
mod tests {
    use super::super::filter::{N, ZERO};
    use super::*;
    use crate::excavator::cylinder::Cylinder;
    use crate::excavator::keys::Description;

    const RATED: f64 = 1000.0;
    const ANYTHING: f64 = 0.25 * RATED * RATED;

    /// Weighs blocks of a moment with 40 N m per kilogram of load; returns the content.
    fn weigh(scale: &mut Scale, load: f64, blocks: u32) -> f64 {
        weigh_bucket(scale, load, blocks, false)
    }

    /// The same with a bucket that is `known` or not.
    fn weigh_bucket(scale: &mut Scale, load: f64, blocks: u32, known: bool) -> f64 {
        let mut d = Description::default();
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (1.0, 0.01, 0.007);
        (c.base_distance, c.rod_distance) = (0.6, 1.3);
        let weigh = Weigh::new(Cylinder::of_boom(&d).expect("a cylinder"));
        let moment = Moment {
            empty: 70e3,
            measured: 70e3 + 40.0 * load,
            per_payload: 40.0,
            lever: 0.5,
            variance: 1e6,
            period: 0.2,
            ..Moment::default()
        };
        let settings = Settings::of(&d);
        for _ in 0..blocks {
            scale.weigh(&weigh, &settings, &moment, (RATED, known));
        }
        scale.filter.x[M]
    }

    #[test]
    fn another_load_is_taken_when_it_lasts() {
        let mut std = [0.0; N];
        std[M] = 300.0;
        let mut scale = Scale::new(&Filter::new([0.0; N], &std));
        assert!((weigh(&mut scale, 400.0, 50) - 400.0).abs() < 40.0);
        scale.filter.p[M][M] = 100.0;
        let kept = weigh(&mut scale, 1100.0, LASTS - 1);
        assert!((kept - 400.0).abs() < 40.0, "{kept}");
        let other = weigh(&mut scale, 1100.0, 60);
        assert!((other - 1100.0).abs() < 60.0, "{other}");
    }

    #[test]
    fn one_time_in_ten_the_bucket_may_hold_anything_and_surely_where_the_load_is_impossible() {
        let mut std = [0.0; N];
        std[M] = 50.0;
        let mut scale = Scale::new(&Filter::new([0.0; N], &std));
        scale.hold((700.0, 50.0), false);
        let now = Inertia {
            empty: 40e3,
            per_payload: 30.0,
            ..Inertia::default()
        };
        let range = [0.0, 1500.0];
        let anything = range[1] * range[1] / 12.0 + 50.0 * 50.0;
        let [payload, inertia] = scale.answer(&Sticking::default(), &now, range);
        assert!((payload.1 / (2500.0 + ERRS * anything) - 1.0).abs() < 1e-12);
        assert_eq!((payload.0, inertia), (700.0, (61e3, 900.0 * payload.1)));
        // No bucket can hold this: the pressures err.
        scale.hold((-400.0, 50.0), false);
        let [payload, _] = scale.answer(&Sticking::default(), &now, range);
        let anything = range[1] * range[1] / 12.0 + 750.0 * 750.0;
        assert_eq!(payload.0, 0.0);
        assert!((payload.1 / (2500.0 + anything) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn an_emptied_bucket_that_weighs_something_shows_that_the_pressures_err() {
        let mut std = [0.0; N];
        std[M] = 30.0;
        let mut scale = Scale::new(&Filter::new([0.0; N], &std));
        let mut empty = |load: f64| {
            scale.hold((0.0, 30.0), true);
            weigh(&mut scale, load, 2 * LASTS);
            scale.errs
        };
        assert_eq!(empty(0.0), LEAST_ODDS);
        assert!(empty(300.0) > 9.0);
        // They show nothing again.
        for _ in 0..20 {
            empty(0.0);
        }
        assert_eq!(empty(0.0), LEAST_ODDS);
    }

    #[test]
    fn the_torque_goes_on_alone_where_a_known_bucket_weighs_something_when_it_is_emptied() {
        let goes_on_alone = |known: bool| {
            let mut std = [0.0; N];
            std[M] = 30.0;
            let mut scale = Scale::new(&Filter::new([0.0; N], &std));
            for load in [0.0, 300.0] {
                scale.hold((0.0, 30.0), true);
                weigh_bucket(&mut scale, load, 2 * LASTS, known);
                assert!(load > 0.0 || !scale.doubts(false));
            }
            scale.doubts(false) && scale.is_doubted() && !scale.is_undecided()
        };
        assert!(goes_on_alone(true));
        assert!(!goes_on_alone(false), "it may be another bucket");
    }

    #[test]
    fn the_torque_goes_on_alone_where_two_emptied_buckets_show_what_no_earlier_one_did() {
        let mut std = [0.0; N];
        (std[M], std[ZERO]) = (40.0, 2000.0);
        let mut scale = Scale::new(&Filter::new([0.0; N], &std));
        let mut emptied = |load: f64| {
            scale.hold((0.0, 40.0), true);
            weigh_bucket(&mut scale, load, 100, true);
            (scale.doubts(false), scale.is_undecided())
        };
        for load in [0.0, 4.0, -5.0, 3.0, 0.0, 2.0] {
            assert_eq!(emptied(load), (false, false));
        }
        // Too little for one bucket to indicate: the filter takes it for a zero.
        assert_eq!(emptied(90.0), (false, false));
        assert!(emptied(90.0).0);
    }

    #[test]
    fn the_torque_goes_on_alone_until_both_weigh_loads_equally() {
        let mut std = [0.0; N];
        std[M] = 30.0;
        let mut scale = Scale::new(&Filter::new([0.0; N], &std));
        let contradict = |scale: &mut Scale| {
            assert!(!scale.doubts(false) && scale.doubts(true));
            assert!(scale.is_doubted() && scale.is_undecided() && scale.may_have_misled(false));
        };
        let content = |scale: &mut Scale, load: f64, std: f64| {
            scale.hold((load, std), false);
            scale.sees((700.0, 900.0), ANYTHING);
            scale.compare(ANYTHING);
            scale.doubts(true);
            scale.is_doubted()
        };
        contradict(&mut scale);
        // A load that is hardly known carries no information. Loads that differ do not identify which of both errs.
        assert!((0..20).all(|_| content(&mut scale, 720.0, 250.0)));
        assert!((0..5).all(|_| content(&mut scale, 1000.0, 30.0)));
        assert!(scale.is_undecided() && scale.may_have_misled(false));
        assert!((0..20).any(|_| !content(&mut scale, 720.0, 30.0)));
        assert!(!scale.may_have_misled(true));
        // A moderate agreement has not misled the filter, unless something is contradicted outright.
        contradict(&mut scale);
        assert!(content(&mut scale, 720.0, 100.0));
        assert!(!scale.may_have_misled(false) && scale.may_have_misled(true));
        // Emptied buckets that weigh something show that the pressures err. While they do, equal loads prove nothing.
        contradict(&mut scale);
        scale.hold((0.0, 30.0), true);
        weigh(&mut scale, 300.0, 2 * LASTS);
        assert!(scale.is_doubted() && !scale.is_undecided());
        assert!((0..20).all(|_| content(&mut scale, 720.0, 30.0)));
    }
}
