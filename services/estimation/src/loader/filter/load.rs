//! Load of the machine: a known payload, or a mass that steps and moves the centre of gravity.

use super::{Belief, CgFilter};
use crate::loader::keys::Machine;
use crate::loader::layout::{CENTRE, CG_HEIGHT, CG_RATIO, Each};
use crate::loader::lift_arm::Carried;
use crate::loader::load::mass_step::Centre;
use crate::loader::physics::cg_model::Loading;
use crate::loader::settings::Settings;

/// Share of the mass from which on the machine counts as loaded.
const LEAST_LOAD: f64 = 0.04;
/// Standard deviation of a load while it is filled in or emptied, over the machine's mass: anything up to a third of it.
const FILLED: f64 = 0.2;

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Sets the load that the lift pressure shows for the next row; `empty` is its estimate of the empty machine.
    pub(in crate::loader) fn set_weighed(
        &mut self,
        settings: &Settings,
        weighed: Option<Carried>,
        empty: Each<(f64, f64)>,
    ) {
        let prior = &settings.prior;
        if let Some(centre) = self.known_load.weigh(weighed, prior, empty) {
            self.restore(centre);
        }
    }

    /// Updates the error of a weighed load in the ratio of the empty machine; `predicted`: variance of the ratio before the row.
    pub(super) fn learn_under_load(&mut self, predicted: f64) {
        let variance = || self.belief.variance(CG_RATIO);
        self.known_load
            .learn(|| (1.0 - variance() / predicted).clamp(0.0, 1.0));
    }

    pub(super) fn loading(&self, settings: &Settings) -> Loading {
        self.known_load.loading(&settings.machine)
    }

    /// Mass with its load [kg].
    pub(super) fn mass(&self, settings: &Settings) -> f64 {
        let known = self.known_load.mass(&settings.machine);
        known.unwrap_or(self.hold.mass)
    }

    /// Whether the machine carries a load, by its mass.
    pub(super) fn is_loaded(&self) -> bool {
        self.load.share() > LEAST_LOAD
    }

    /// Whether a mass is stated, and is that of the empty machine.
    pub(in crate::loader) fn is_told_empty(&self, machine: &Machine) -> bool {
        let described = self.hold.mass <= (1.0 + LEAST_LOAD) * machine.mass;
        self.disturbance.states_mass && described && self.load.is_empty()
    }

    /// Standard deviation of the mass by a load that nothing states, as a share: one that is filled in, one by the motion, or another
    /// one since. A wrong stated mass counts too, where the motion shows it.
    pub(super) fn unreported_mass(&self) -> f64 {
        if self.known_load.is_open() {
            return FILLED;
        }
        let mass = &self.disturbance.mass;
        let off = if mass.lighter() == 0.0 {
            0.0
        } else {
            mass.off()
        };
        if self.known_load.is_some() || self.disturbance.states_mass {
            off
        } else {
            off.max(mass.carried()).max(mass.other_load())
        }
    }

    /// Whether the machine is loaded, and no boom motion would be reported.
    pub(in crate::loader) fn lifts_unreported(&self, settings: &Settings) -> bool {
        settings.at_work() && !self.boom_reported && self.is_loaded()
    }

    /// Reach of the bucket in wheelbases.
    pub(super) fn reach(&self, settings: &Settings) -> f64 {
        settings.machine.bucket_reach / self.dynamics.wheelbase
    }

    /// Height and ratio expected under the present load, without information from the motion.
    pub(super) fn expected_centre(&self, settings: &Settings) -> Centre {
        self.load
            .expected(settings.prior.centre(), self.reach(settings))
    }

    /// Moves the centre of gravity with a step of the mass, and widens its covariance.
    pub(super) fn weigh(&mut self, settings: &Settings, dt: f64) {
        let state = *self.belief.state();
        let centre = CENTRE.map(|i| (state[i], self.belief.std(i)));
        let Some(shift) = self.load.weigh(self.hold.mass, centre, dt) else {
            return;
        };
        if let Some(centre) = shift.restored {
            self.restore(centre);
            return;
        }
        let (ratio, ratio_std) = shift.ratio(state[CG_RATIO], self.reach(settings));
        self.belief.state_mut()[CG_RATIO] = ratio;
        self.loosen_by(CG_HEIGHT, shift.height_std(state[CG_HEIGHT]));
        self.loosen_by(CG_RATIO, ratio_std);
        // After digging the covariance was opened for an unknown content, which now is weighed.
        for (i, (_, most)) in CENTRE.into_iter().zip(self.expected_centre(settings)) {
            if self.belief.std(i) > most {
                self.belief.separate(&[(i, most)], &[0.0; N]);
            }
        }
        self.clamp(settings);
    }

    /// Restores height and ratio, without correlation with the other states.
    fn restore(&mut self, [height, ratio]: Centre) {
        self.belief
            .separate(&[(CG_HEIGHT, height.1), (CG_RATIO, ratio.1)], &[0.0; N]);
        let state = self.belief.state_mut();
        (state[CG_HEIGHT], state[CG_RATIO]) = (height.0, ratio.0);
    }
}
