//! Recall of confirmed knowledge after a contradiction.
//!
//! A filter that takes in the values of a broken sensor stays wrong: its constants are off by more than their variances allow. Emptied
//! buckets then no longer weigh nothing, however sound the sensor is by then. The knowledge at which they did weigh nothing is therefore
//! stored. While something is contradicted, each new content is weighed by that alone. A fault that lasts contradicts it again.
//!
//! The stored knowledge ages: it fades towards the description ([`super::fading`]), friction and damping wander, and the ground may slope
//! in another way.

use super::Working;
use super::fading::CONSTANTS;
use super::filter::{DAMPING, FRICTION, Filter, SLOPE, W};
use super::motion::WARMING;
use super::trial::Trial;
use crate::excavator::drive::Drive;
use crate::excavator::settings::Settings;
use crate::math::exp;

/// Upper limit of the time in motion for which a broken sensor goes unnoticed \[s\].
const UNNOTICED: f64 = 60.0;
/// Time constant of the stored knowledge, in motion \[s\]: while the machine is contradicted, no swing confirms it.
pub(super) const LASTS: f64 = 3600.0;

/// Knowledge that an emptied bucket has confirmed.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Recall {
    confirmed: Option<Filter>,
    /// Knowledge of a later emptied bucket, not confirmed yet: a broken sensor may be trusted for a while.
    candidate: Option<Filter>,
    /// Time in motion \[s\].
    time: f64,
    /// When the content last changed \[s\].
    seen_at: f64,
    /// When the confirmed knowledge was stored or recalled \[s\].
    confirmed_at: f64,
    /// When the candidate was stored \[s\].
    candidate_at: f64,
    /// Test of joint angles that have jumped.
    pub(super) trial: Option<Trial>,
}

impl Recall {
    /// Advances the time in motion.
    pub(super) fn ages(&mut self, period: f64) {
        self.time += period;
    }

    /// Stores the knowledge of an emptied bucket that weighs nothing, while nothing is contradicted.
    fn confirm(&mut self, filter: &Filter) {
        if self.candidate.is_some() && self.time < self.candidate_at + UNNOTICED {
            return;
        }
        let before = core::mem::replace(&mut self.candidate_at, self.time);
        if let Some(sooner) = self.candidate.replace(filter.clone()) {
            (self.confirmed, self.confirmed_at) = (Some(sooner), before);
        }
    }

    /// Returns whether any knowledge has been confirmed.
    pub(super) fn is_there(&self) -> bool {
        self.confirmed.is_some()
    }

    /// The stored knowledge.
    pub(super) fn stored(&mut self) -> impl Iterator<Item = &mut Filter> {
        self.confirmed.iter_mut().chain(&mut self.candidate)
    }

    /// Discards the stored knowledge: the filters now hold information that is not from motion.
    pub(super) fn forget(&mut self) {
        (self.confirmed, self.candidate) = (None, None);
    }
}

impl Working {
    /// Returns whether an emptied bucket gives the same inertia as was known before a contradiction; `None` where nothing was. `content`:
    /// variance of an empty bucket's content [kg^2].
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

    /// Ends a content: its knowledge is stored, or replaced by the confirmed one where something is contradicted.
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
            // The pressures may have misled the filter.
            self.begins_with(&self.described(settings));
            self.parallel.is_as_described();
        }
    }

    /// Ages stored knowledge.
    fn ages_since(&mut self, known: &mut Filter, settings: &Settings) {
        let time = self.recall.time;
        let age = time - core::mem::replace(&mut self.recall.confirmed_at, time);
        known.fade(&self.described(settings), exp(-age / LASTS), &CONSTANTS);
        for i in [FRICTION, DAMPING] {
            known.p[i][i] += self.stated[i] * self.stated[i] * age / WARMING;
        }
        for i in [SLOPE, SLOPE + 1] {
            known.p[i][i] = known.p[i][i].max(self.stated[i] * self.stated[i]);
        }
    }

    /// Restarts all filters from this knowledge alone.
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
        // The broken sensor may have informed the last one; and the one before has faded.
        assert!(upper > 9.0 && upper < 10.0, "{upper}");
        assert_eq!(velocity, 0.3);
        // The fault is over, and another one occurs before anything has been confirmed again.
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
