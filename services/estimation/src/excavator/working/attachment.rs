//! Has a coupler changed the attachment?
//!
//! An emptied bucket that weighs something holds what sticks, or is another one: its mass has changed by N(0, b²), so often an hour. Both
//! act alike, so as a content the hypotheses differ by one prior, N(0, a²) against N(0, a² + (c b)²); c is what a kilogram of bucket weighs
//! as content. The second one needs no filter of its own ([`super::tail`]): with z and V, what everything but that prior says of the content,
//!
//! ```text
//! 1/V = 1/P - 1/a²      z = V x/P      E = N(z; 0, V + a² + (c b)²) / N(z; 0, V + a²)
//! ```
//! E is the ratio of the evidences. The interval is that of the mixture ([`crate::mixture`]). Where another attachment has more than half,
//! the bucket's mass is open by b from then on, so that it takes what the content was too much; a gain that is off is then the rival.
//! What is undecided when the content is over is mixed by its moments.
//!
//! A coupler needs an upper body that stands for [`EXCHANGE`]. Where [`KNOWN`] emptied buckets were weighed since, it is the same bucket.

use super::Working;
use super::filter::{BUCKET, Filter, M};
use super::trail::Trail;
use crate::excavator::geometry::Inertia;
use crate::excavator::size::Sticking;
use crate::math::{exp, ln, norm, sqrt};
use crate::mixture::{POSSIBLE, spread};

/// Standard deviation of the masses of the buckets of one machine, as a share of the described one: from .5 (narrow) to 1.6 (for rock).
const OTHERS: f64 = 0.4;
/// So often is it changed [1/s], once in an hour of work, and the time within which the last exchange may be overlooked [s].
const CHANGES: f64 = 1.0 / 3600.0;
const LONGEST: f64 = 1800.0;
/// A hydraulic coupler changes the bucket while the upper body stands for this time \[s\].
const EXCHANGE: f64 = 10.0;
/// So many emptied buckets tell whether it has.
const KNOWN: u8 = 3;
/// Logarithm of the odds beyond which it is all the same.
const MOST: f64 = 20.0;
/// An emptied bucket that weighs less than so many standard deviations is no question: what speaks for another one is then less than
/// what speaks against it beforehand.
const STRANGE: f64 = 2.0;
/// Share of the prior's variance below which anything else tells the content of an emptied bucket.
const TOLD: f64 = 0.9;
/// A bucket of which nobody saw whether it was emptied, and that weighs less than nothing, holds so little: a standard deviation as a share
/// of the rated payload. What it holds makes the change larger still, which b allows for about that far.
const LIGHTER: f64 = 0.08;

/// The prior of the content of an emptied bucket.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Emptied {
    /// Its variance (a²) [kg^2].
    pub(super) variance: f64,
    /// The filters have taken it in.
    pub(super) tared: bool,
    /// The bucket was seen to open.
    pub(super) seen: bool,
}

/// The hypothesis that the attachment is another one.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Attachment {
    /// Standard deviation of the mass of another bucket (b), and of the one that hangs there, beside what sticks \[kg\].
    other: f64,
    std: f64,
    /// The latter is that of any bucket of the machine at most.
    most: f64,
    /// What sticks in a bucket of known mass.
    sticking: Sticking,
    /// Time since an emptied bucket was weighed last \[s\]; so many were since a coupler could have changed it.
    since: f64,
    weighed: u8,
    /// The last question: the content's prior, content that weighs as much as a kilogram of bucket (c), logarithm of the odds.
    emptied: Emptied,
    share: f64,
    odds: f64,
    /// The last emptied bucket weighs what it did; there is something to be said when its content is over.
    same: bool,
    pub(super) pending: bool,
    /// What the mixture adds to the variances of payload [kg^2] and inertia [(kg m^2)^2].
    added: [f64; 2],
    /// Nothing hangs on the coupler, or something that nobody has weighed empty.
    pub(super) bare: bool,
}

impl Attachment {
    /// Of a bucket with this mass and standard deviation \[kg\].
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

    /// Time passes.
    pub(super) fn wait(&mut self, period: f64) {
        self.since += period;
    }

    /// The upper body stands for so long \[s\].
    pub(super) fn stands(&mut self, time: f64) {
        if time > EXCHANGE {
            self.weighed = 0;
        }
    }

    /// Whether a coupler may have changed the bucket since an emptied one was weighed.
    pub(super) fn may_be_another(&self) -> bool {
        self.weighed == 0
    }

    /// Another attachment cannot be excluded.
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

    /// Logarithm of the odds beforehand.
    fn prior(&self) -> f64 {
        ln(CHANGES * self.since.clamp(1.0, LONGEST))
    }

    /// What the mixture adds to the variances of payload [kg^2] and inertia [(kg m^2)^2].
    pub(super) fn variances(&self) -> [f64; 2] {
        self.added
    }

    /// There is no question any more.
    pub(super) fn forget(&mut self) {
        self.odds = f64::NEG_INFINITY;
        self.added = [0.0; 2];
    }

    /// An emptied bucket is taken for what it is now.
    pub(super) fn is_known(&mut self) {
        self.since = 0.0;
        self.same = false;
        self.weighed = self.weighed.saturating_add(1);
        self.forget();
    }

    /// Whether it is a question for a filter: an emptied bucket weighs more or less than what sticks.
    #[inline(always)]
    pub(super) fn is_asked(&mut self, filter: &Filter, emptied: &Emptied) -> bool {
        let (x, p, variance) = (filter.x[M], filter.p[M][M], emptied.variance);
        // The square of z over V + a² is that of x over this.
        let scale = if emptied.tared {
            variance - p
        } else {
            variance + p
        };
        self.pending = true;
        self.same = p < TOLD * variance;
        x * x > STRANGE * STRANGE * scale
    }

    /// Asks a filter of an emptied bucket; `usual`: ratio by which variances disagree. Whether another attachment is possible.
    fn ask(&mut self, filter: &Filter, emptied: Emptied, usual: f64, now: &Inertia) -> bool {
        self.forget();
        let (x, p, a) = (filter.x[M], filter.p[M][M], emptied.variance);
        if emptied.tared && p > TOLD * a || emptied.seen && self.weighed >= KNOWN {
            return false;
        }
        let told = if emptied.tared { a / (a - p) } else { 1.0 };
        let (z, v) = (x * told, p * told * usual);
        self.emptied = emptied;
        self.share = now.per_bucket / now.per_payload.max(f64::MIN_POSITIVE);
        let share = self.share * self.other;
        let (same, other) = (v + a, v + a + share * share);
        let said = 0.5 * (ln(same / other) + z * z * (1.0 / same - 1.0 / other));
        self.odds = (self.prior() + said).min(MOST);
        if !self.is_possible() {
            return false;
        }
        // Of the content proper, and of what content and bucket weigh more than thought.
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

    /// What a filter has taken in of an emptied bucket's content is taken back.
    fn take_back(&self, filter: &mut Filter, trail: &mut Option<Trail>) {
        let variance = self.emptied.variance;
        if self.emptied.tared && filter.p[M][M] < TOLD * variance {
            filter.without([(M, 1.0)], (-filter.x[M], variance), trail);
        }
    }

    /// The bucket's mass is open, and what bucket and content weigh together is not.
    fn open(&self, filter: &mut Filter) {
        let (share, variance) = (self.share, self.other * self.other);
        filter.p[BUCKET][BUCKET] += variance;
        filter.p[M][M] += share * share * variance;
        filter.p[M][BUCKET] -= share * variance;
        filter.p[BUCKET][M] -= share * variance;
    }

    /// The mixture of both hypotheses by its moments.
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
    /// Whether a coupler may have changed the attachment: an emptied bucket weighs something. Then it is another one from now on.
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

    /// The same of a bucket of which nobody knows whether it is empty: it weighs less than nothing.
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

    /// The attachment is another one: what it weighs more or less is the bucket's.
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

    /// The bucket has been another one with this probability: its description says less of it, and of what sticks in it.
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

    /// A content is over.
    #[inline(never)]
    pub(super) fn content_tells_attachment(&mut self, gate: f64, trail: &mut Option<Trail>) {
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

    /// What hangs on the coupler is as before, or any bucket of this machine: by the moments of both. Until one has been weighed empty.
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

    /// Variance of the content where the motion tells it: a bucket of which nothing is known does not hide that it is empty.
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

    /// A filter of an emptied bucket that weighs this beyond what is known of it to a standard deviation.
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
        // What sticks is no question, and adds nothing.
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

    /// Weighs a content, and asks.
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
            // It is not the described one, so the description is not doubted for it.
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
        // Known again where one was emptied and weighed.
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
