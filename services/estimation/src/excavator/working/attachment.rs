//! Hypothesis that a coupler has changed the attachment.
//!
//! An emptied bucket that weighs something holds sticking soil, or is another bucket: its mass has changed by N(0, b²), at a known rate
//! per hour. Both act equally on the motion. As contents, the hypotheses therefore differ by one prior only:
//! N(0, a²) against N(0, a² + (c b)²). The content c weighs as much as a kilogram of bucket.
//!
//! The second hypothesis needs no filter of its own ([`super::tail`]). With z and V, the content and its variance by everything but that
//! prior, and with x and P, the content and its variance by the filter,
//!
//! ```text
//! 1/V = 1/P - 1/a²      z = V x/P      E = N(z; 0, V + a² + (c b)²) / N(z; 0, V + a²)
//! ```
//! E is the ratio of the evidences. The interval is that of the mixture ([`crate::mixture`]). Where another attachment has more than half
//! of the probability, the bucket's mass is opened by b. The bucket then takes up the excess of the content, and a gain that is off
//! becomes the rival hypothesis. Where a content ends undecided, the filter goes on with the moments of the mixture.
//!
//! A coupler needs an upper body that stands for [`EXCHANGE`]. Where [`KNOWN`] emptied buckets have been weighed since, the bucket is the
//! same.

use super::Working;
use super::filter::{BUCKET, Filter, M};
use super::trail::Trail;
use crate::excavator::geometry::Inertia;
use crate::excavator::size::Sticking;
use crate::math::{exp, ln, norm, sqrt};
use crate::mixture::{POSSIBLE, spread};

/// Standard deviation of the masses of one machine's buckets, as a share of the described one: from .5 (narrow) to 1.6 (for rock).
const OTHERS: f64 = 0.4;
/// Rate of exchanges [1/s]: one in an hour of work.
const CHANGES: f64 = 1.0 / 3600.0;
/// Longest time over which the prior odds of an exchange grow [s].
const LONGEST: f64 = 1800.0;
/// Standing time of the upper body in which a hydraulic coupler can exchange the bucket \[s\].
const EXCHANGE: f64 = 10.0;
/// Number of weighed emptied buckets after which the bucket is known.
const KNOWN: u8 = 3;
/// Upper limit of the log odds.
const MOST: f64 = 20.0;
/// Weight of an emptied bucket below which there is no test [standard deviations]: the evidence for another bucket cannot outweigh the
/// prior odds against it.
const STRANGE: f64 = 2.0;
/// Share of the prior's variance below which the content of an emptied bucket has been measured.
const MEASURED: f64 = 0.9;
/// Standard deviation of the content of a bucket that weighs less than nothing, as a share of the rated payload. Nothing showed whether
/// that bucket was emptied. Such a content makes the change larger still. b allows for about as much.
const LIGHTER: f64 = 0.08;

/// Prior of the content of an emptied bucket.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Emptied {
    /// Variance (a²) [kg^2].
    pub(super) variance: f64,
    /// The filters already include it.
    pub(super) tared: bool,
    /// The bucket was seen to open.
    pub(super) seen: bool,
}

/// Hypothesis that the attachment is another one.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Attachment {
    /// Standard deviation of the mass of another bucket (b) \[kg\].
    other: f64,
    /// Standard deviation of the mass of the present bucket, beside what sticks in it \[kg\].
    std: f64,
    /// Upper limit of the latter: that of any bucket of the machine \[kg\].
    most: f64,
    /// Soil that sticks in a bucket of known mass.
    pub(super) sticking: Sticking,
    /// Time since an emptied bucket was last weighed \[s\].
    since: f64,
    /// Number of emptied buckets weighed since a coupler could have exchanged the bucket.
    weighed: u8,
    /// Prior of the content in the last test.
    emptied: Emptied,
    /// Content that weighs as much as a kilogram of bucket (c).
    share: f64,
    /// Log odds of another attachment.
    odds: f64,
    /// The last emptied bucket has been measured, and no other attachment was found.
    same: bool,
    /// The attachment must be updated when the content is over.
    pub(super) pending: bool,
    /// Variances that the mixture adds: of payload [kg^2] and inertia [(kg m^2)^2].
    added: [f64; 2],
    /// Nothing hangs on the coupler, or an attachment that has not been weighed empty.
    pub(super) bare: bool,
}

impl Attachment {
    /// Starts with a bucket of this mass and standard deviation \[kg\].
    pub(super) fn new(mass: f64, std: f64, sticking: Sticking) -> Self {
        Self {
            other: OTHERS * mass,
            std,
            most: norm(&[std, OTHERS * mass]),
            sticking,
            since: 0.0,
            weighed: 0,
            emptied: Emptied {
                variance: 0.0,
                tared: false,
                seen: false,
            },
            share: 0.0,
            odds: f64::NEG_INFINITY,
            same: false,
            pending: false,
            added: [0.0; 2],
            bare: false,
        }
    }

    /// Advances the time.
    pub(super) fn wait(&mut self, period: f64) {
        self.since += period;
    }

    /// Records that the upper body has stood for this time \[s\].
    pub(super) fn stands(&mut self, time: f64) {
        if time > EXCHANGE {
            self.weighed = 0;
        }
    }

    /// Returns whether a coupler may have exchanged the bucket since an emptied one was weighed.
    pub(super) fn may_be_another(&self) -> bool {
        self.weighed == 0
    }

    /// Returns whether another attachment cannot be excluded.
    pub(super) fn is_possible(&self) -> bool {
        self.odds > POSSIBLE
    }

    fn is_another(&self) -> bool {
        self.odds > 0.0
    }

    fn probability(&self) -> f64 {
        let odds = exp(self.odds);
        odds / (1.0 + odds)
    }

    /// Log odds of an exchange before the test.
    fn prior(&self) -> f64 {
        ln(CHANGES * self.since.clamp(1.0, LONGEST))
    }

    /// Variances that the mixture adds: of payload [kg^2] and inertia [(kg m^2)^2].
    pub(super) fn variances(&self) -> [f64; 2] {
        self.added
    }

    /// Withdraws the hypothesis.
    pub(super) fn forget(&mut self) {
        self.odds = f64::NEG_INFINITY;
        self.added = [0.0; 2];
    }

    /// Accepts the present bucket as the known one.
    pub(super) fn is_known(&mut self) {
        self.since = 0.0;
        self.same = false;
        self.weighed = self.weighed.saturating_add(1);
        self.forget();
    }

    /// Returns whether a filter calls for the test: an emptied bucket weighs more or less than what sticks.
    #[inline(always)]
    pub(super) fn is_asked(&mut self, filter: &Filter, emptied: &Emptied) -> bool {
        let (x, p, variance) = (filter.x[M], filter.p[M][M], emptied.variance);
        // The square of z over V + a² equals that of x over this.
        let scale = if emptied.tared {
            variance - p
        } else {
            variance + p
        };
        self.pending = true;
        self.same = p < MEASURED * variance;
        x * x > STRANGE * STRANGE * scale
    }

    /// Tests an emptied bucket in a filter; `usual`: ratio of observed to predicted variance. Returns whether another attachment is
    /// possible.
    fn ask(&mut self, filter: &Filter, emptied: Emptied, usual: f64, now: &Inertia) -> bool {
        self.forget();
        let (x, p, a) = (filter.x[M], filter.p[M][M], emptied.variance);
        if emptied.tared && p > MEASURED * a || emptied.seen && self.weighed >= KNOWN {
            return false;
        }
        let factor = if emptied.tared { a / (a - p) } else { 1.0 };
        let (z, v) = (x * factor, p * factor * usual);
        self.emptied = emptied;
        self.share = now.per_bucket / now.per_payload.max(f64::MIN_POSITIVE);
        let share = self.share * self.other;
        let (same, other) = (v + a, v + a + share * share);
        let evidence = 0.5 * (ln(same / other) + z * z * (1.0 / same - 1.0 / other));
        self.odds = (self.prior() + evidence).min(MOST);
        if !self.is_possible() {
            return false;
        }
        // Mean and variance by the other hypothesis: of the content alone, and of the common excess of content and bucket.
        let content = (z * a / other, a * (other - a) / other);
        let both = (z * (other - v) / other, v * (other - v) / other);
        let row = filter.inertia_row(now);
        let of_content: f64 = row.iter().map(|(i, entry)| entry * filter.p[M][*i]).sum();
        let per = of_content / p;
        let (_, own) = filter.combination(&row);
        let moved = own + per * per * (both.1 - p);
        let probability = self.probability();
        self.added =
            [(content.0 - x, content.1), (per * (both.0 - x), moved)].map(|(away, variance)| {
                let std = spread(probability, away, sqrt(variance.max(0.0)));
                std * std
            });
        true
    }

    /// Removes the prior of an emptied bucket's content from a filter that includes it.
    fn take_back(&self, filter: &mut Filter, trail: &mut Option<Trail>) {
        let variance = self.emptied.variance;
        if self.emptied.tared && filter.p[M][M] < MEASURED * variance {
            filter.without([(M, 1.0)], (-filter.x[M], variance), trail);
        }
    }

    /// Opens the bucket's mass by b; the weight of bucket and content together stays known.
    fn open(&self, filter: &mut Filter) {
        let (share, variance) = (self.share, self.other * self.other);
        filter.p[BUCKET][BUCKET] += variance;
        filter.p[M][M] += share * share * variance;
        filter.p[M][BUCKET] -= share * variance;
        filter.p[BUCKET][M] -= share * variance;
    }

    /// Replaces a filter by the moments of the mixture of both hypotheses.
    fn mix(&self, filter: &mut Filter, gate: f64) {
        let tare = |filter: &mut Filter| {
            let value = -filter.x[M];
            filter.measure([(M, 1.0)], value, self.emptied.variance, gate, &mut None);
        };
        let mut other = filter.clone();
        self.take_back(&mut other, &mut None);
        self.open(&mut other);
        tare(&mut other);
        if !self.emptied.tared {
            tare(filter);
        }
        *filter = filter.clone().mixed(&other, self.probability());
    }
}

impl Working {
    /// Tests whether a coupler has changed the attachment, where an emptied bucket weighs something. If that is more probable than not,
    /// the attachment is another one from now on. Returns whether it is possible.
    #[inline(never)]
    pub(super) fn doubts_attachment(
        &mut self,
        emptied: Emptied,
        gate: f64,
        now: &Inertia,
        trail: &mut Option<Trail>,
    ) -> bool {
        let usual = self.contradiction.usual();
        if !self.attachment.ask(&self.filter, emptied, usual, now) {
            return false;
        }
        if emptied.seen && self.is_kept(self.filter.p[M][M]) {
            self.attachment.forget();
            return false;
        }
        if self.attachment.is_another() {
            self.is_changed(gate, trail);
        }
        true
    }

    /// The same for a bucket that weighs less than nothing and was not seen to be emptied.
    #[inline(never)]
    pub(super) fn weighs_less_than_nothing(
        &mut self,
        gate: f64,
        now: &Inertia,
        trail: &mut Option<Trail>,
    ) {
        let std = LIGHTER * self.rated;
        let emptied = Emptied {
            variance: std * std,
            tared: false,
            seen: false,
        };
        if !self.attachment.is_asked(&self.filter, &emptied) {
            return;
        }
        self.attachment.same = false;
        self.doubts_attachment(emptied, gate, now, trail);
    }

    /// Adopts another attachment: the bucket's mass takes up the excess or missing weight.
    fn is_changed(&mut self, gate: f64, trail: &mut Option<Trail>) {
        let attachment = &self.attachment;
        let Emptied { variance, seen, .. } = attachment.emptied;
        attachment.take_back(&mut self.filter, trail);
        attachment.take_back(&mut self.parallel.filter, &mut None);
        attachment.take_back(&mut self.scale.filter, &mut None);
        attachment.open(&mut self.filter);
        attachment.open(&mut self.scale.filter);
        self.parallel.is_rivalled(attachment.prior());
        self.opens_bucket(1.0);
        self.is_emptied();
        self.holds_nothing(variance, gate, trail);
        self.tared = seen;
        self.attachment.is_known();
        if !seen {
            // The next bucket is another one.
            (self.attachment.bare, self.attachment.weighed) = (true, 0);
        }
    }

    /// Widens the stated deviation of the bucket's mass, and of what sticks in it: it was another one with this probability.
    fn opens_bucket(&mut self, probability: f64) {
        self.scale.has_another_bucket();
        let attachment = &mut self.attachment;
        let other = attachment.other * attachment.other;
        let std = norm(&[attachment.std, sqrt(probability * other)]);
        attachment.std = std.min(attachment.most);
        let (std, sticking) = (attachment.std, attachment.sticking);
        self.sticks = sticking.among(std);
        self.restate(BUCKET, norm(&[std, sticking.std]));
    }

    /// Ends a content, and with it the test of the attachment.
    #[inline(never)]
    pub(super) fn settle_attachment(&mut self, gate: f64, trail: &mut Option<Trail>) {
        if self.attachment.is_possible() && self.attachment.emptied.seen {
            for filter in [&mut self.filter, &mut self.scale.filter] {
                self.attachment.mix(filter, gate);
            }
            self.opens_bucket(self.attachment.probability());
            self.anew = true;
            self.agreement.interrupt();
            self.attachment.is_known();
        }
        if self.attachment.same {
            self.attachment.is_known();
        }
        self.attachment.forget();
        self.attachment.pending = self.attachment.bare;
        if self.attachment.bare {
            self.anything_may_hang(trail);
        }
    }

    /// Mixes the present attachment with any bucket of this machine, by their moments, until one has been weighed empty.
    fn anything_may_hang(&mut self, trail: &mut Option<Trail>) {
        let any = self.stated[BUCKET] * self.stated[BUCKET];
        let (x, p) = (self.filter.x[BUCKET], self.filter.p[BUCKET][BUCKET]);
        if self.tared && p < 0.25 * any {
            self.attachment.bare = false;
            return;
        }
        if p >= any {
            return;
        }
        self.scale.has_another_bucket();
        let apart = 0.5 * (self.described[BUCKET] - x);
        let (value, variance) = (x + apart, any + apart * apart);
        self.filter.set(BUCKET, value, variance, trail);
        for filter in [&mut self.parallel.filter, &mut self.scale.filter] {
            filter.set(BUCKET, value, variance, &mut None);
        }
    }

    /// Variance of the content as motion measures it. An unknown bucket is left out: it must not hide that the bucket is empty.
    pub(super) fn content_variance(&self) -> f64 {
        let p = &self.filter.p;
        if self.attachment.bare {
            p[M][M] - p[M][BUCKET] * p[M][BUCKET] / p[BUCKET][BUCKET]
        } else {
            p[M][M]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bucket::Content;
    use super::super::filter::N;
    use super::*;
    use crate::excavator::keys::Description;
    use crate::excavator::settings::Settings;

    const BUCKET_MASS: f64 = 800.0;
    const SHARE: f64 = 0.9;
    const EMPTIED: Emptied = Emptied {
        variance: 6400.0,
        tared: true,
        seen: true,
    };

    fn posture() -> Inertia {
        Inertia {
            per_payload: 30.0,
            per_bucket: SHARE * 30.0,
            ..Inertia::default()
        }
    }

    /// Filter of an emptied bucket that weighs `beyond` more than described, with this standard deviation of the bucket's mass.
    fn filter(bucket: f64, beyond: f64) -> Filter {
        let mut std = [0.0; N];
        std[BUCKET] = bucket;
        let mut filter = Filter::new([0.0; N], &std);
        filter.set(M, 0.0, EMPTIED.variance, &mut None);
        let row = [(M, 1.0), (BUCKET, SHARE)];
        filter.measure(row, beyond, 900.0, 1e9, &mut None);
        filter
    }

    fn attachment() -> Attachment {
        let mut attachment = Attachment::new(BUCKET_MASS, 40.0, Sticking::default());
        attachment.wait(30.0);
        attachment
    }

    #[test]
    fn another_bucket_has_the_odds_of_a_content_with_its_wider_prior() {
        let (known, beyond) = (40.0, 400.0);
        let mut attachment = attachment();
        assert!(attachment.ask(&filter(known, beyond), EMPTIED, 1.0, &posture()));
        let other = SHARE * attachment.other;
        let noise = 900.0 + SHARE * SHARE * known * known;
        let variances = [
            noise + EMPTIED.variance,
            noise + EMPTIED.variance + other * other,
        ];
        let [same, another] = variances.map(|v| -0.5 * (ln(v) + beyond * beyond / v));
        let said = attachment.odds - attachment.prior();
        assert!((said - (another - same)).abs() < 1e-9, "{said}");
        // Sticking soil calls for no test, and adds nothing.
        let soil = filter(known, 150.0);
        assert!(!attachment.is_asked(&soil, &EMPTIED));
    }

    #[test]
    fn a_bucket_that_is_known_is_another_one_only_after_a_stand() {
        let mut attachment = attachment();
        for weighed in 0..=KNOWN {
            let asked = attachment.ask(&filter(40.0, 400.0), EMPTIED, 1.0, &posture());
            assert_eq!(asked, weighed < KNOWN);
            assert_eq!(attachment.may_be_another(), weighed == 0);
            attachment.is_known();
            attachment.wait(30.0);
            attachment.stands(0.5 * EXCHANGE);
        }
        attachment.stands(1.5 * EXCHANGE);
        assert!(attachment.may_be_another());
        assert!(attachment.ask(&filter(40.0, 400.0), EMPTIED, 1.0, &posture()));
    }

    #[test]
    fn a_bucket_that_is_opened_afterwards_is_one_that_was_open_before() {
        let (mut attachment, mut later) = (attachment(), filter(40.0, 400.0));
        assert!(attachment.ask(&later, EMPTIED, 1.0, &posture()));
        attachment.take_back(&mut later, &mut None);
        attachment.open(&mut later);
        let value = -later.x[M];
        later.measure([(M, 1.0)], value, EMPTIED.variance, 1e9, &mut None);
        let before = filter(norm(&[40.0, attachment.other]), 400.0);
        for i in [M, BUCKET] {
            assert!((later.x[i] - before.x[i]).abs() < 1e-6, "{i}");
            for j in [M, BUCKET] {
                assert!((later.p[i][j] / before.p[i][j] - 1.0).abs() < 1e-9);
            }
        }
    }

    fn working() -> Working {
        let settings = Settings::of(&Description::default());
        let mut working = Working::new(&settings, &settings.doubts.expect("doubts"));
        working.filter.set(BUCKET, 0.0, 100.0, &mut None);
        working.attachment.wait(30.0);
        working
    }

    /// Weighs a content, and tests the attachment.
    fn weighs(working: &mut Working, share: f64, seen: bool) -> bool {
        let content = (
            share * working.rated,
            0.0004 * working.rated * working.rated,
        );
        working.filter.set(M, content.0, content.1, &mut None);
        working
            .parallel
            .filter
            .set(M, content.0, content.1, &mut None);
        if !seen {
            working.weighs_less_than_nothing(1e9, &posture(), &mut None);
            return working.attachment.bare;
        }
        let std = working.sticking();
        let emptied = Emptied {
            variance: std * std,
            tared: false,
            seen,
        };
        let filter = &working.filter;
        working.attachment.is_asked(filter, &emptied)
            && working.doubts_attachment(emptied, 1e9, &posture(), &mut None)
    }

    #[test]
    fn what_an_emptied_bucket_weighs_by_far_is_the_buckets() {
        for share in [-0.3, 0.3] {
            let mut working = working();
            let described = working.stated[BUCKET];
            assert!(weighs(&mut working, share, true));
            let weighs = share * working.rated;
            let bucket = SHARE * working.filter.x[BUCKET];
            assert!((bucket / weighs - 1.0).abs() < 0.2, "{bucket} {weighs}");
            assert!((working.filter.x[M] / weighs).abs() < 0.2);
            assert!(!working.contradiction.is_open() && !working.attachment.bare);
            // It is another bucket, so its description is not doubted.
            let doubt = working.doubt();
            working.restate(BUCKET, described);
            assert!(working.doubt() > 1.5 * doubt, "{doubt}");
        }
        let mut working = working();
        assert!(!weighs(&mut working, 0.08, true), "soil");
        assert_eq!(working.filter.x[BUCKET], 0.0);
    }

    #[test]
    fn what_is_undecided_when_the_content_is_over_is_mixed() {
        let mut working = working();
        let undecided = (10..30)
            .map(|i| 0.01 * f64::from(i))
            .find(|share| weighs(&mut working, *share, true) && !working.attachment.is_another());
        let probability = working.attachment.probability();
        let settings = Settings::of(&Description::default());
        working.hold(&settings, Content::Unknown, &mut None);
        let weighs = undecided.expect("undecided") * working.rated;
        let bucket = SHARE * working.filter.x[BUCKET] / weighs;
        assert!(
            bucket > 0.5 * probability && bucket < probability + 0.1,
            "{bucket}"
        );
        assert!(!working.attachment.is_possible());
    }

    #[test]
    fn where_nothing_hangs_on_the_coupler_anything_may_hang_next() {
        let mut working = working();
        assert!(!weighs(&mut working, -0.05, false), "noise");
        assert!(weighs(&mut working, -0.4, false));
        let none = working.filter.x[BUCKET];
        let settings = Settings::of(&Description::default());
        working.hold(&settings, Content::Unknown, &mut None);
        let (x, std) = (
            working.filter.x[BUCKET],
            sqrt(working.filter.p[BUCKET][BUCKET]),
        );
        let heavy = 0.6 * working.described_bucket;
        assert!(none > x - 1.96 * std && heavy < x + 1.96 * std, "{x} {std}");
        // It is known again after one was emptied and weighed.
        working.tared = true;
        working.filter.set(BUCKET, heavy, 100.0, &mut None);
        working.hold(&settings, Content::Unknown, &mut None);
        assert!(!working.attachment.bare);
        assert_eq!(working.filter.x[BUCKET], heavy);
    }

    #[test]
    fn one_that_weighs_what_it_did_was_not_changed_before() {
        let mut working = working();
        working.attachment.wait(600.0);
        let before = working.attachment.prior();
        assert!(!weighs(&mut working, 0.01, true));
        let settings = Settings::of(&Description::default());
        working.hold(&settings, Content::Unknown, &mut None);
        assert!(working.attachment.prior() < before - 2.0);
    }
}
