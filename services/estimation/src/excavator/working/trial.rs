//! Test of joint angles that have jumped and stay: they may be right again ([`super::super::jump`]).
//!
//! Where the angles are right, an emptied bucket gives the same inertia as before ([`super::moved`]). Where they are wrong, the inertia
//! is off by d, the effect of the jumps. The likelihood ratio of both multiplies the odds (Bayes):
//! ```text
//! odds <- odds N(m; 0, v)/N(m; d v/V, v)
//! ```
//! with m the change of the inertia, V its variance before, and v the variance lost.

use super::Working;
use super::moved::Moved;
use crate::excavator::drive::Drive;
use crate::excavator::settings::Settings;

/// Share of the empty machine's inertia: a jump that changes it by less, in each of some postures, needs no test.
const SLIGHT: f64 = 0.02;
/// Angles of boom, arm and bucket in those postures [rad].
const BOOM: [f64; 3] = [0.0, 0.5, 1.0];
const ARM: [f64; 3] = [-0.8, -1.6, -2.4];
const BUCKET_ANGLE: f64 = -1.0;
/// Prior log odds that an angle which has jumped is right: one such step in ten is that of a late bus.
const LATE: f64 = -2.3;
/// Log odds at which it is accepted.
const RIGHT: f64 = 4.6;
/// Limit of the log likelihood ratio of one emptied bucket.
const MAX_LOG_RATIO: f64 = 4.0;

/// Test of joint angles that have jumped.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Trial {
    /// Size of the jumps [rad].
    jumps: [f64; 3],
    /// Log odds that the angles are right all the same, by the contents before.
    odds: f64,
    /// Log likelihood ratio by the present content.
    says: f64,
}

impl Trial {
    /// Starts the test of these jumps [rad]; `None` where they matter in no posture of work.
    fn new(jumps: [f64; 3], settings: &Settings) -> Option<Self> {
        let mut postures = BOOM
            .iter()
            .flat_map(|boom| ARM.map(|arm| [*boom, arm, BUCKET_ANGLE]));
        let matters = postures.any(|posture| {
            let other = core::array::from_fn(|i| posture[i] + jumps[i]);
            let [here, there] = [posture, other].map(|q| settings.geometry.inertia(q).empty);
            (there - here).abs() > SLIGHT * here
        });
        matters.then_some(Self {
            jumps,
            odds: LATE,
            says: 0.0,
        })
    }

    /// Returns whether the angles are accepted, by the change of the inertia with an emptied bucket.
    pub(super) fn is_passed(&mut self, moved: &Moved, settings: &Settings, drive: &Drive) -> bool {
        let before = core::array::from_fn(|i| drive.posture[i] - self.jumps[i]);
        let apart = settings.geometry.inertia(before).empty - drive.now.empty;
        // The estimate has followed a deviation by the share of the variance lost.
        let share = apart / moved.variance;
        let ratio = share * (0.5 * share * moved.lost - moved.by);
        self.says = ratio.clamp(-MAX_LOG_RATIO, MAX_LOG_RATIO);
        self.odds + self.says > RIGHT
    }

    /// Ends a content: its evidence enters the odds.
    pub(super) fn content_is_over(&mut self) {
        self.odds += core::mem::take(&mut self.says);
    }
}

impl Working {
    /// Contradicts joint angles that have jumped by this much [rad] until emptied buckets agree with what was known before. Returns false
    /// where nothing was.
    pub(in crate::excavator) fn puts_to_the_test(
        &mut self,
        jumps: [f64; 3],
        settings: &Settings,
    ) -> bool {
        let known = self.recall.is_there() && self.parallel.is_driven();
        if known {
            self.recall.trial = Trial::new(jumps, settings);
            self.contradiction.outright();
        }
        known
    }

    /// Returns whether they are still under test, and not accepted or too slight to matter.
    pub(in crate::excavator) fn tests_jumps(&self) -> bool {
        self.recall.trial.is_some()
    }

    /// Ends the test: they have jumped back.
    pub(in crate::excavator) fn ends_the_test(&mut self) {
        self.recall.trial = None;
    }
}

#[cfg(test)]
mod tests {
    use super::super::moved::tests::moved;
    use super::*;
    use crate::excavator::keys::Description;

    #[test]
    fn an_angle_that_has_jumped_is_right_once_emptied_buckets_speak_against_its_jump() {
        let settings = Settings::of(&Description::default());
        let (sound, drive) = moved(&settings, 1.0);
        let displaced = |jump: f64| {
            let posture = [0.6, -1.8 - jump, -1.5];
            settings.geometry.inertia(posture).empty / drive.now.empty
        };
        // Number of emptied buckets until it is accepted.
        let buckets = |jump: f64, moved: &Moved| {
            let mut trial = Trial::new([0.0, jump, 0.0], &settings).expect("one that matters");
            (1..=20).find(|_| {
                let passed = trial.is_passed(moved, &settings, &drive);
                trial.content_is_over();
                passed
            })
        };
        for jump in [-0.3, 0.3] {
            assert!(buckets(jump, &sound).is_some_and(|n| n <= 6), "{jump}");
            let (other, _) = moved(&settings, displaced(jump));
            assert_eq!(buckets(jump, &other), None, "{jump}");
        }
        // A slight jump is not decided within 20 buckets, and one that matters in no posture needs no test.
        assert_eq!(buckets(0.06, &sound), None);
        assert!(Trial::new([0.01, 0.01, 0.05], &settings).is_none());
    }
}
