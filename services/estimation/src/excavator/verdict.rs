//! Verdict on a state-space estimate: the five conditions on which it is trusted.

use super::grid::Tick;
use super::settings::Settings;
use super::state::State;
use crate::consistency::{MOST_NIS, NisWindow};

/// Excited motion after which the inertia of modes D and BM is identifiable [s].
const EXCITED_FOR: f64 = 0.2;
/// Unflagged motion after which the inertia of modes C and A is identifiable [s].
const STEADY_FOR: f64 = 1.5;

/// Half width, in standard deviations, of the interval of modes C and A that must lie within the limit of convergence: 99 %, since an
/// estimate that just converges at 95 % is wrong by the limit once in twenty.
const STEADY_SURE: f64 = 2.58;

/// What the identifiability of the inertia is based on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Basis {
    /// Torque and posture are measured.
    PostureTorque,
    /// Torque is measured; a standstill must have been seen.
    Torque {
        /// A standstill was seen.
        stood: bool,
    },
    /// The torque is unknown, and was steady for this time [s].
    Steady(f64),
    /// Nothing: the inertia changes and only the velocity is known.
    Nothing,
}

/// Accumulates the conditions over ticks.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Verdict {
    nis: NisWindow<50>,
    velocity_age: f64,
    excited_for: f64,
}

/// The five conditions of a trusted estimate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Reasons {
    pub(super) excited: bool,
    pub(super) consistent: bool,
    pub(super) fresh: bool,
    pub(super) converged: bool,
    pub(super) identifiable: bool,
}

impl Verdict {
    pub(super) fn new() -> Self {
        Self {
            nis: NisWindow::new(MOST_NIS),
            velocity_age: f64::INFINITY,
            excited_for: 0.0,
        }
    }

    /// Counts one tick; `accepted`: its velocity passed the gate.
    pub(super) fn step(
        &mut self,
        settings: &Settings,
        tick: &Tick,
        accepted: bool,
        state: &State,
        basis: Basis,
    ) {
        self.velocity_age = if accepted {
            0.0
        } else {
            self.velocity_age + tick.period
        };
        if state.nis > 0.0 {
            self.nis.push(state.nis);
        }
        let counts = basis != Basis::Torque { stood: false };
        let excited = state.weighed || state.velocity.abs() >= settings.estimator.excited_velocity;
        if counts && excited {
            self.excited_for += tick.period;
        }
    }

    /// The conditions after this tick.
    pub(super) fn reasons(
        &self,
        settings: &Settings,
        tick: &Tick,
        state: &State,
        basis: Basis,
        needs: (bool, bool),
    ) -> Reasons {
        let e = &settings.estimator;
        let (torque, posture) = needs;
        let converged =
            crate::HALF_WIDTH_95 * state.inertia_std < e.converged_share * state.inertia;
        Reasons {
            excited: state.weighed || state.velocity.abs() >= e.excited_velocity,
            consistent: self.nis.mean() <= e.consistent_nis,
            fresh: self.velocity_age <= e.fresh_velocity
                && (!torque || tick.torque_age <= e.fresh_others)
                && (!posture || tick.posture_age <= e.fresh_others),
            converged: converged && !state.changing && !state.unsettled,
            identifiable: match basis {
                Basis::PostureTorque => self.excited_for >= EXCITED_FOR,
                Basis::Torque { stood } => stood && self.excited_for >= EXCITED_FOR,
                Basis::Steady(time) => {
                    let sure = STEADY_SURE * state.inertia_std < e.converged_share * state.inertia;
                    sure && time >= STEADY_FOR
                }
                Basis::Nothing => false,
            },
        }
    }
}
