//! Detects contradictions between the measurements and what is known.
//!
//! Sensors fail while the machine works, and the filter takes a wrong torque, velocity or angle for another payload. Evidence of a
//! failure is:
//!
//! * an emptied bucket that weighs neither nothing nor what it did before;
//! * a payload that has changed without a joint motion, or that no bucket can hold;
//! * pushes that recur, or a swing that stays unexplained;
//! * a constant far from its stated value;
//! * a parallel filter that wins ([`super::parallel`]).
//!
//! None of these identifies the sensor. A contradicted estimate is not trusted until emptied buckets weigh nothing again. They are
//! weighed by what was known before ([`super::recall`]), in swings without another contradiction. Until then the interval covers any
//! content of the bucket.

use crate::math::ln;

/// Number of emptied buckets that must weigh nothing after an outright contradiction.
const REGAINED: u8 = 2;
/// Usual disagreement of manoeuvres below which an unannounced change is a contradiction (ratio of variances).
const USUAL: f64 = 1.5;
/// Weight of one swing in the usual disagreement.
const SWING: f64 = 0.15;

/// Distance beyond its range at which a payload is impossible [standard deviations].
const IMPOSSIBLE: f64 = 3.0;
/// Log odds at which a payload weighed again is the one before; with the opposite sign, it is another one.
const SAME: f64 = 2.0;

/// Present contradictions, and the usual disagreement of manoeuvres.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Contradiction {
    /// Number of emptied buckets that must still weigh nothing.
    level: u8,
    usual: f64,
    /// Payload and its variance before the unannounced change [kg, kg^2].
    before: (f64, f64),
    /// Something has pushed the upper body, and no payload has been known since.
    pushed: bool,
    /// An emptied bucket has weighed nothing since the content changed.
    agreed: bool,
    /// Something has been contradicted since the content changed.
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

    /// Resets for another content of the bucket.
    pub(super) fn content_changes(&mut self) {
        (self.agreed, self.contradicted) = (false, false);
    }

    /// Updates the usual disagreement with that of a finished swing.
    pub(super) fn swung(&mut self, disagreement: f64) {
        self.usual += SWING * (disagreement - self.usual);
    }

    /// Returns the usual ratio of the observed variance to that of the filter, at least 1.
    pub(super) fn usual(&self) -> f64 {
        self.usual.max(1.0)
    }

    /// Stores value and variance of a payload [kg, kg^2] ahead of an apparent change without a joint motion.
    pub(super) fn changed(&mut self, before: (f64, f64)) {
        self.before = before;
    }

    /// Returns whether the payload has not changed after all: weighed again, it is far more probably the one before than any content of
    /// variance `anything`. Where it is far less probably so, that is a contradiction.
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

    /// Tests a payload and its variance [kg, kg^2]: below nothing, or above what is ever lifted, is a contradiction. Where the payload
    /// has `changed` in mid-motion, an impossible one is a push instead; returns whether it is.
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

    /// Records a push on the upper body: by the ground on which the bucket lands, or by turning tracks. A push passes, whereas a broken
    /// sensor contradicts the next motion too.
    pub(super) fn pushes(&mut self) {
        if core::mem::replace(&mut self.pushed, true) {
            self.outright();
        }
    }

    /// Records a swing without a push that does not follow the model either: the push before was a broken sensor.
    pub(super) fn is_left_unexplained(&mut self) {
        if self.pushed {
            self.outright();
        }
    }

    /// Records that a possible payload is known: the push has passed.
    pub(super) fn is_weighed(&mut self) {
        self.pushed = false;
    }

    /// Records an outright contradiction.
    pub(super) fn outright(&mut self) {
        self.level = REGAINED;
        self.contradicted = true;
    }

    /// Records that an emptied bucket weighs nothing. It counts once for each content, and not after a contradiction.
    pub(super) fn agrees(&mut self) {
        if !self.contradicted && !core::mem::replace(&mut self.agreed, true) {
            self.level = self.level.saturating_sub(1);
        }
    }

    /// Returns whether an emptied bucket has agreed in the present content.
    pub(super) fn has_agreed(&self) -> bool {
        self.agreed && !self.contradicted
    }

    /// Returns whether something is contradicted outright, and no emptied bucket has agreed since.
    pub(super) fn is_outright(&self) -> bool {
        self.level == REGAINED
    }

    /// Returns whether something is contradicted.
    pub(super) fn is_open(&self) -> bool {
        self.level > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_contradicted_outright_is_trusted_after_two_agreements() {
        let mut contradiction = Contradiction::new();
        contradiction.outright();
        // In the contradicted content nothing agrees; each later content agrees once.
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

    /// Whether an apparent change is withdrawn, by this payload and variance afterwards [kg, kg^2].
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
    fn a_change_is_withdrawn_or_contradicts_as_soon_as_the_weight_is_precise() {
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
