//! Does what is measured contradict what is known?
//!
//! Sensors break while the machine works, and the filter takes a wrong torque, velocity or angle for another payload.
//! What speaks against that: an emptied bucket that weighs neither nothing nor what it did before; a payload that has changed though no
//! joint moved it, or that no bucket holds; pushes that recur; a swing that is left unexplained; a constant far from what was stated; and a
//! parallel filter that wins ([`super::parallel`]). None says which sensor it is. What is contradicted is not
//! believed until emptied buckets weigh nothing again, by what was known before ([`super::recall`]) and in swings without another
//! contradiction; until then the interval says that the bucket may hold anything.

use crate::math::ln;

/// Emptied buckets that must weigh nothing after an outright contradiction.
const REGAINED: u8 = 2;
/// A change without a word is a contradiction where manoeuvres usually disagree by less (ratio of variances).
const USUAL: f64 = 1.5;
/// Share of one swing in what is usual.
const SWING: f64 = 0.15;

/// So many standard deviations beyond its range a payload cannot be.
const IMPOSSIBLE: f64 = 3.0;
/// Logarithm of the odds at which a payload weighed anew is the one before, or is not.
const SAME: f64 = 2.0;

/// What was contradicted, and how far manoeuvres usually disagree.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Contradiction {
    /// So many emptied buckets must weigh nothing.
    level: u8,
    usual: f64,
    /// Payload and its variance before it changed without a word [kg, kg^2].
    before: (f64, f64),
    /// Something has pushed the upper body, and no payload was known since.
    pushed: bool,
    /// What was said since the bucket's content changed: it is none, and weighs nothing; something is contradicted.
    agreed: bool,
    contradicted: bool,
}

impl Contradiction {
    pub(super) fn new() -> Self {
        Self {
            level: 0,
            usual: 1.0,
            before: (0.0, 0.0),
            pushed: false,
            agreed: false,
            contradicted: false,
        }
    }

    /// The bucket holds something else.
    pub(super) fn content_changes(&mut self) {
        (self.agreed, self.contradicted) = (false, false);
    }

    /// A swing is over in which manoeuvres disagreed by this ratio.
    pub(super) fn swung(&mut self, disagreement: f64) {
        self.usual += SWING * (disagreement - self.usual);
    }

    /// Usual ratio of the variance to what the filter claims, at least 1.
    pub(super) fn usual(&self) -> f64 {
        self.usual.max(1.0)
    }

    /// The payload seems to have changed without a word; value and variance before [kg, kg^2].
    pub(super) fn changed(&mut self, before: (f64, f64)) {
        self.before = before;
    }

    /// Whether it has not changed after all: weighed anew it is far more probably what it was than `anything` of this variance. Where
    /// it is far less probably so, something is contradicted.
    pub(super) fn withdraws(&mut self, (value, variance): (f64, f64), anything: f64) -> bool {
        let spread = self.before.1 + variance * self.usual();
        let away = value - self.before.0;
        let odds = 0.5 * (ln(1.0 + anything / spread) - away * away / spread);
        if odds < -SAME && self.usual < USUAL {
            self.level = self.level.max(1);
            self.contradicted = true;
        }
        odds > SAME
    }

    /// A payload and its variance [kg, kg^2]: less than nothing, or more than is ever lifted, cannot be. Whether it is no payload that
    /// has `changed` in the middle of the motion, but a push.
    pub(super) fn weighs(
        &mut self,
        (value, variance): (f64, f64),
        [least, most]: [f64; 2],
        changed: bool,
    ) -> bool {
        let beyond = value - value.clamp(least, most);
        let cannot = beyond * beyond > IMPOSSIBLE * IMPOSSIBLE * variance * self.usual();
        if cannot && !changed {
            self.outright();
        }
        cannot && changed
    }

    /// Something pushes the upper body: the ground on which the bucket lands, tracks that turn. That passes; a sensor that breaks
    /// contradicts the next motion too.
    pub(super) fn pushes(&mut self) {
        if core::mem::replace(&mut self.pushed, true) {
            self.outright();
        }
    }

    /// A swing in which nothing pushed does not follow the model either: what seemed to push before was a sensor that broke.
    pub(super) fn is_left_unexplained(&mut self) {
        if self.pushed {
            self.outright();
        }
    }

    /// A payload is known that a bucket may hold: what pushed has passed.
    pub(super) fn is_weighed(&mut self) {
        self.pushed = false;
    }

    /// It cannot be as it is measured.
    pub(super) fn outright(&mut self) {
        self.level = REGAINED;
        self.contradicted = true;
    }

    /// An emptied bucket was weighed, and weighs nothing. One content says so once, and not after a contradiction.
    pub(super) fn agrees(&mut self) {
        if !self.contradicted && !core::mem::replace(&mut self.agreed, true) {
            self.level = self.level.saturating_sub(1);
        }
    }

    /// Whether the present content has said so.
    pub(super) fn has_agreed(&self) -> bool {
        self.agreed && !self.contradicted
    }

    /// Whether something is contradicted outright, and no emptied bucket has agreed since.
    pub(super) fn is_outright(&self) -> bool {
        self.level == REGAINED
    }

    /// Whether something is contradicted.
    pub(super) fn is_open(&self) -> bool {
        self.level > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_contradicted_outright_is_believed_after_two_agreements() {
        let mut contradiction = Contradiction::new();
        contradiction.outright();
        // In the content that was contradicted nothing agrees, and each other one does so once.
        for outright in [true, true, false] {
            assert!(contradiction.is_open());
            assert_eq!(contradiction.is_outright(), outright);
            contradiction.agrees();
            contradiction.agrees();
            contradiction.content_changes();
        }
        assert!(!contradiction.is_open());
    }

    #[test]
    fn a_bucket_that_weighs_less_than_nothing_contradicts() {
        for (payload, contradicts) in [((-50.0, 400.0), false), ((-70.0, 400.0), true)] {
            let mut contradiction = Contradiction::new();
            contradiction.weighs(payload, [0.0, 2000.0], false);
            assert_eq!(contradiction.is_open(), contradicts, "{payload:?}");
        }
    }

    #[test]
    fn a_push_is_no_sensor_that_breaks_unless_it_is_there_in_the_next_swing_too() {
        let pushes = |known_between: bool| {
            let mut contradiction = Contradiction::new();
            assert!(contradiction.weighs((-900.0, 400.0), [0.0, 2000.0], true));
            contradiction.pushes();
            assert!(!contradiction.is_open());
            if known_between {
                contradiction.is_weighed();
            }
            contradiction.pushes();
            contradiction.is_open()
        };
        assert!(!pushes(true));
        assert!(pushes(false));
    }

    #[test]
    fn a_swing_that_nothing_explains_contradicts_after_a_push_alone() {
        let mut contradiction = Contradiction::new();
        contradiction.is_left_unexplained();
        assert!(!contradiction.is_open());
        contradiction.pushes();
        contradiction.is_left_unexplained();
        assert!(contradiction.is_open());
    }

    /// A payload that seemed to change, and weighs this with this variance afterwards [kg, kg^2].
    fn weighed(contradiction: &mut Contradiction, weight: (f64, f64)) -> bool {
        contradiction.changed((300.0, 400.0));
        contradiction.withdraws(weight, 400.0 * 400.0)
    }

    #[test]
    fn another_weight_is_nothing_new_where_manoeuvres_always_disagree() {
        let mut contradiction = Contradiction::new();
        weighed(&mut contradiction, (500.0, 400.0));
        assert!(contradiction.is_open() && !contradiction.is_outright());
        contradiction.content_changes();
        contradiction.agrees();
        assert!(!contradiction.is_open());
        (0..4).for_each(|_| contradiction.swung(3.0));
        weighed(&mut contradiction, (500.0, 400.0));
        assert!(!contradiction.is_open());
    }

    #[test]
    fn a_change_is_withdrawn_or_contradicts_as_soon_as_the_weight_says_so() {
        for (weight, withdrawn, contradicts) in [
            ((310.0, 400.0), true, false),
            ((310.0, 4e4), false, false),
            ((500.0, 400.0), false, true),
        ] {
            let mut contradiction = Contradiction::new();
            assert_eq!(weighed(&mut contradiction, weight), withdrawn, "{weight:?}");
            assert_eq!(contradiction.is_open(), contradicts, "{weight:?}");
        }
    }
}
