//! What was known before a contradiction is known again.
//!
//! A filter that takes in what a broken sensor says is wrong for good: its constants are off by more than it claims, so that no emptied
//! bucket weighs nothing any more, however sound the sensor is by then. So what was known when emptied buckets weighed nothing
//! is kept, and while something is contradicted each new content is weighed by that alone. A fault that lasts contradicts it again.
//!
//! It ages meanwhile: it fades towards the description ([`super::fading`]), oil warms up, and the ground may be another one.

use super::Working;
use super::fading::CONSTANTS;
use super::filter::{DAMPING, FRICTION, Filter, SLOPE, W};
use super::trial::Trial;
use crate::excavator::drive::Drive;
use crate::excavator::settings::Settings;
use crate::math::exp;

/// A sensor that breaks goes unnoticed for less than this time in motion \[s\].
const UNNOTICED: f64 = 60.0;
/// The machine is another one within this time in motion \[s\]: while it is contradicted, no swing confirms what was known.
const LASTS: f64 = 3600.0;

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
    /// Joint angles that have jumped are put to the test.
    pub(super) trial: Option<Trial>,
}

impl Recall {
    /// Time in motion passes.
    pub(super) fn ages(&mut self, period: f64) {
        self.time += period;
    }

    /// An emptied bucket weighs nothing, and nothing is contradicted.
    fn confirm(&mut self, filter: &Filter) {
        if self.candidate.is_some() && self.time < self.candidate_at + UNNOTICED {
            return;
        }
        let before = core::mem::replace(&mut self.candidate_at, self.time);
        if let Some(sooner) = self.candidate.replace(filter.clone()) {
            (self.confirmed, self.confirmed_at) = (Some(sooner), before);
        }
    }

    /// Whether anything has been confirmed.
    pub(super) fn is_there(&self) -> bool {
        self.confirmed.is_some()
    }

    /// Something else is known from now on, which motion did not tell.
    pub(super) fn forget(&mut self) {
        (self.confirmed, self.candidate) = (None, None);
    }
}

impl Working {
    /// Whether an emptied bucket tells what turns as was known before something was contradicted; none where nothing was known. Variance of
    /// an empty bucket's content [kg^2].
    #[inline(never)]
    pub(super) fn agrees_with_before(
        &mut self,
        content: f64,
        settings: &Settings,
        drive: &Drive,
    ) -> Option<bool> {
        let confirmed = self.recall.confirmed.as_ref();
        let known = confirmed.filter(|_| self.contradiction.is_open())?;
        let moved = known.moved(&self.filter, content, &drive.now);
        let passed = match &mut self.recall.trial {
            Some(trial) => trial.is_passed(&moved, settings, drive),
            None => true,
        };
        Some(passed && moved.is_foreseen())
    }

    /// The content is another one: what was told before is kept, or where it is contradicted not believed.
    pub(super) fn recall(&mut self, settings: &Settings) {
        let time = self.recall.time;
        if core::mem::replace(&mut self.recall.seen_at, time) == time {
            return;
        }
        if let Some(trial) = &mut self.recall.trial {
            trial.content_is_over();
        }
        if !self.is_contradicted() {
            self.recall.trial = None;
            if self.contradiction.has_agreed() {
                self.recall.confirm(&self.filter);
            }
            return;
        }
        self.recall.candidate = None;
        if let Some(mut known) = self.recall.confirmed.take() {
            self.ages_since(&mut known, settings);
            self.begins_with(&known);
            self.recall.confirmed = Some(known);
        } else if self.scale.may_have_misled(self.contradiction.is_outright()) {
            // The pressures have told it what may be wrong.
            self.begins_with(&self.described(settings));
            self.parallel.is_as_described();
        }
    }

    /// What was known before fades.
    fn ages_since(&mut self, known: &mut Filter, settings: &Settings) {
        let time = self.recall.time;
        let age = time - core::mem::replace(&mut self.recall.confirmed_at, time);
        known.fade(&self.described(settings), exp(-age / LASTS), &CONSTANTS);
        for i in [FRICTION, DAMPING] {
            known.p[i][i] += self.stated[i] * self.stated[i] * age / super::WARMING;
        }
        for i in [SLOPE, SLOPE + 1] {
            known.p[i][i] = known.p[i][i].max(self.stated[i] * self.stated[i]);
        }
    }

    /// This is known, and nothing else.
    fn begins_with(&mut self, known: &Filter) {
        let velocity = (self.filter.x[W], self.filter.p[W][W]);
        self.filter = known.clone();
        self.filter.set(W, velocity.0, velocity.1, &mut None);
        self.scale.knows(&self.filter);
        self.parallel.begins(&self.filter);
        self.anew = true;
    }
}

#[cfg(test)]
mod tests {
    use super::super::filter::UPPER;
    use super::*;
    use crate::excavator::keys::Description;

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
        // It is over, and something else breaks before anything has been confirmed anew.
        for _ in 0..3 {
            working.contradiction.agrees();
            content_changes(&mut working, 12.0);
        }
        assert!(!working.is_contradicted());
        working.contradiction.agrees();
        content_changes(&mut working, 12.0);
        working.contradiction.outright();
        let (upper, _) = content_changes(&mut working, 500.0);
        assert!(upper > 8.0 && upper < 12.5, "{upper}");
    }
}
