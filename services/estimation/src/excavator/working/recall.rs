//! What was known before a contradiction is known again.
//!
//! A filter that takes in what a broken sensor says is wrong for good: its constants are off by more than it claims, so that no emptied
//! bucket weighs nothing any more, however sound the sensor is by then. So what was known when emptied buckets weighed nothing
//! is kept, and while something is contradicted each new content is weighed by that alone. A fault that lasts contradicts it again.
//!
//! It ages meanwhile: it fades towards the description ([`super::fading`]), oil warms up, and the ground may be another one.

use super::Working;
use super::fading::CONSTANTS;
use super::filter::{BUCKET, DAMPING, FRICTION, Filter, GAIN, LINKS, M, SLOPE, UPPER, W};
use crate::excavator::geometry::Inertia;
use crate::excavator::settings::Settings;
use crate::math::exp;

/// A sensor that breaks goes unnoticed for less than this time in motion \[s\].
const UNNOTICED: f64 = 60.0;
/// The machine is another one within this time in motion \[s\]: while it is contradicted, no swing confirms what was known.
const LASTS: f64 = 3600.0;
/// Share of its variance that what turns must have lost to have been told.
const TOLD: f64 = 0.5;
/// Within so many standard deviations it is as foreseen.
const AGREES: f64 = 2.0;

/// Knowledge that an emptied bucket has confirmed.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Recall {
    confirmed: Option<Filter>,
    /// The same of an emptied bucket since: a sensor that breaks may be believed for a while.
    candidate: Option<Filter>,
    /// Time in motion; when the content was seen to be another one, when knowledge was confirmed or recalled, and the candidate was \[s\].
    time: f64,
    seen_at: f64,
    confirmed_at: f64,
    candidate_at: f64,
}

impl Recall {
    /// What was known before anything was contradicted; nothing if that was never confirmed.
    pub(super) fn confirmed(&self) -> Option<&Filter> {
        self.confirmed.as_ref()
    }

    /// Time in motion passes.
    pub(super) fn ages(&mut self, period: f64) {
        self.time += period;
    }

    /// An emptied bucket weighs nothing, and nothing is contradicted.
    fn confirm(&mut self, filter: &Filter) {
        if self.candidate.is_some() && self.time < self.candidate_at + UNNOTICED {
            return;
        }
        self.confirmed = self.candidate.replace(filter.clone());
        self.confirmed_at = core::mem::replace(&mut self.candidate_at, self.time);
    }

    /// Something else is known from now on, which motion did not tell.
    pub(super) fn forget(&mut self) {
        (self.confirmed, self.candidate) = (None, None);
    }
}

impl Filter {
    /// Whether motion has told, after this and with a content of none, what turns per measured torque, as this said beforehand: where
    /// the model holds it has moved by as much as its variance has lost. `content`: variance of the content [kg^2].
    pub(super) fn foresees(&self, after: &Self, content: f64, now: &Inertia) -> bool {
        let content_row = (M, now.per_payload);
        let [upper, bucket, links, gain] = [
            (UPPER, 1.0),
            (BUCKET, now.per_bucket),
            (LINKS, now.links),
            (GAIN, -now.empty),
        ];
        let (before, of_machine) = self.combination(&[upper, bucket, links, gain]);
        let variance = of_machine + now.per_payload * now.per_payload * content;
        let (value, left) = after.combination(&[content_row, upper, bucket, links, gain]);
        let (moved, lost) = (value - before, variance - left);
        lost > TOLD * variance && moved * moved < AGREES * AGREES * lost
    }
}

impl Working {
    /// A sensor is contradicted until emptied buckets agree with what was known before; false where that tells nothing of it.
    pub(in crate::excavator) fn puts_to_the_test(&mut self) -> bool {
        let told = self.recall.confirmed.is_some() && self.parallel.is_driven();
        if told {
            self.contradiction.outright();
        }
        told
    }

    /// The content is another one: what was told before is kept, or where it is contradicted not believed.
    pub(super) fn recall(&mut self, settings: &Settings) {
        let time = self.recall.time;
        if core::mem::replace(&mut self.recall.seen_at, time) == time {
            return;
        }
        if !self.is_contradicted() {
            if self.contradiction.has_agreed() {
                self.recall.confirm(&self.filter);
            }
            return;
        }
        self.recall.candidate = None;
        let Some(mut known) = self.recall.confirmed.take() else {
            return;
        };
        let age = time - core::mem::replace(&mut self.recall.confirmed_at, time);
        known.fade(&self.described(settings), exp(-age / LASTS), &CONSTANTS);
        for i in [FRICTION, DAMPING] {
            known.p[i][i] += self.stated[i] * self.stated[i] * age / super::WARMING;
        }
        for i in [SLOPE, SLOPE + 1] {
            known.p[i][i] = known.p[i][i].max(self.stated[i] * self.stated[i]);
        }
        let velocity = (self.filter.x[W], self.filter.p[W][W]);
        self.filter = known.clone();
        self.filter.set(W, velocity.0, velocity.1, &mut None);
        self.scale.knows(&self.filter);
        self.parallel.begins(&self.filter);
        self.recall.confirmed = Some(known);
        self.anew = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::keys::Description;

    /// A machine of which swings have told what turns, and what one with an emptied bucket tells when its torque is `wrong` by a factor.
    fn agrees(wrong: f64) -> bool {
        let settings = Settings::of(&Description::default());
        let working = Working::new(&settings, &settings.doubts.expect("doubts"));
        let now = settings.geometry.inertia([0.6, -1.8, -1.5]);
        let mut known = working.filter;
        let row = [
            (M, now.per_payload),
            (UPPER, 1.0),
            (BUCKET, now.per_bucket),
            (LINKS, now.links),
            (GAIN, -now.empty),
        ];
        let tell = |filter: &mut Filter, wrong: f64| {
            let value = (wrong - 1.0) * now.empty - filter.combination(&row).0;
            let variance = 1e-4 * now.empty * now.empty;
            filter.measure(row, value, variance, 1e9, &mut None);
        };
        let content = 17.0 * 17.0;
        known.set(M, 0.0, content, &mut None);
        (0..3).for_each(|_| tell(&mut known, 1.0));
        let mut after = known.clone();
        after.set(M, 0.0, content, &mut None);
        (0..9).for_each(|_| tell(&mut after, wrong));
        known.foresees(&after, content, &now)
    }

    #[test]
    fn a_machine_that_turns_as_it_did_agrees_and_one_with_another_torque_does_not() {
        assert!(agrees(1.0));
        assert!(!agrees(1.1));
        assert!(!agrees(0.9));
    }

    #[test]
    fn what_was_confirmed_is_known_again_while_something_is_contradicted() {
        let settings = Settings::of(&Description::default());
        let mut working = Working::new(&settings, &settings.doubts.expect("doubts"));
        let content_changes = |working: &mut Working, upper: f64| {
            working.filter.x[UPPER] = upper;
            working.filter.x[W] = 0.3;
            working.recall.ages(2.0 * UNNOTICED);
            working.recall(&settings);
            working.contradiction.content_changes();
            (working.filter.x[UPPER], working.filter.x[W])
        };
        for upper in [10.0, 20.0] {
            working.contradiction.agrees();
            assert_eq!(content_changes(&mut working, upper), (upper, 0.3));
        }
        working.contradiction.outright();
        let (upper, velocity) = content_changes(&mut working, 500.0);
        // The last one may have been told by what broke; and it has faded.
        assert!(upper > 9.0 && upper < 10.0, "{upper}");
        assert_eq!(velocity, 0.3);
    }
}
