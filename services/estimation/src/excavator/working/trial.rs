//! Joint angles that have jumped, and stay, are put to the test: they may be right again ([`super::super::jump`]).
//!
//! An emptied bucket tells what turns as it was known before ([`super::moved`]) where they are. Where they are not, it tells otherwise by d,
//! what the angles without their jumps make of it. The odds grow by the ratio of the likelihoods (Bayes):
//! ```text
//! odds <- odds N(m; 0, v)/N(m; d v/V, v)
//! ```
//! with m what it has moved by, and v what variance it has lost of V.

use super::Working;
use super::moved::Moved;
use crate::excavator::drive::Drive;
use crate::excavator::settings::Settings;

/// A jump that changes the inertia of the empty machine by less than this share, in each of some postures, is no matter.
const SLIGHT: f64 = 0.02;
/// Angles of boom, arm and bucket in those postures [rad].
const BOOM: [f64; 3] = [0.0, 0.5, 1.0];
const ARM: [f64; 3] = [-0.8, -1.6, -2.4];
const BUCKET_ANGLE: f64 = -1.0;
/// Logarithm of the odds that an angle which has jumped is right, beforehand (one such step in ten is that of a bus that was late), and
/// with which it is believed. One emptied bucket says no more than this.
const LATE: f64 = -2.3;
const RIGHT: f64 = 4.6;
const SAYS: f64 = 4.0;

/// Joint angles that have jumped are put to the test.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Trial {
    /// How far they have jumped [rad].
    jumps: [f64; 3],
    /// Logarithm of the odds that they are right all the same, and what the present content says of it.
    odds: f64,
    says: f64,
}

impl Trial {
    /// Of angles that have jumped so far [rad]; none where that matters in no posture of work.
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

    /// Whether the angles are right, by what an emptied bucket has moved.
    pub(super) fn is_passed(&mut self, moved: &Moved, settings: &Settings, drive: &Drive) -> bool {
        let before = core::array::from_fn(|i| drive.posture[i] - self.jumps[i]);
        let apart = settings.geometry.inertia(before).empty - drive.now.empty;
        // As much of it has been told as of the variance.
        let told = apart / moved.variance;
        let says = told * (0.5 * told * moved.lost - moved.by);
        self.says = says.clamp(-SAYS, SAYS);
        self.odds + self.says > RIGHT
    }

    /// The bucket holds something else.
    pub(super) fn content_is_over(&mut self) {
        self.odds += core::mem::take(&mut self.says);
    }
}

impl Working {
    /// Joint angles that have jumped by so much [rad] are contradicted until emptied buckets agree with what was known before; false
    /// where nothing was.
    pub(in crate::excavator) fn puts_to_the_test(
        &mut self,
        jumps: [f64; 3],
        settings: &Settings,
    ) -> bool {
        let told = self.recall.is_there() && self.parallel.is_driven();
        if told {
            self.recall.trial = Trial::new(jumps, settings);
            self.contradiction.outright();
        }
        told
    }

    /// Whether they still are; not where they are right, or hardly matter.
    pub(in crate::excavator) fn tests_jumps(&self) -> bool {
        self.recall.trial.is_some()
    }

    /// They have jumped back.
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
        // Emptied buckets until it is believed.
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
        // One that is hardly noticed is not told within 20, and one that no posture shows is none.
        assert_eq!(buckets(0.06, &sound), None);
        assert!(Trial::new([0.01, 0.01, 0.05], &settings).is_none());
    }
}
