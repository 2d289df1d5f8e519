//! Prior of the filter, by state.

use super::{Belief, CgFilter};
use crate::loader::layout::{ByState, Layout};
use crate::loader::settings::Settings;

/// Standard deviation of a state that is not estimated yet: next to 0, which a covariance root cannot represent.
const UNOPENED: f64 = 1e-9;

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    pub(super) fn prior_state(settings: &Settings) -> [f64; N] {
        let prior = &settings.prior;
        let mut state: [f64; N] = ByState {
            parameters: [prior.slip_stiffness, prior.cg_height, prior.cg_ratio],
            slope_bias: prior.slope_bias,
            speed_delay: settings.sensors.speed_delay,
            ..ByState::default()
        }
        .state();
        if let Some(radii) = const { Layout::of(N) }.radii {
            [state[radii[0]], state[radii[1]]] =
                [prior.front_radius_error, prior.rear_radius_error];
        }
        state
    }

    pub(super) fn prior_std(settings: &Settings) -> [f64; N] {
        let prior = &settings.prior;
        ByState {
            motion: [
                prior.speed_std,
                prior.wheel_speed_std,
                prior.wheel_speed_std,
            ],
            parameters: [
                prior.slip_stiffness_std,
                prior.cg_height_std,
                prior.cg_ratio_std,
            ],
            spade_force: prior.spade_force_std,
            radius: prior.radius_std,
            slope_bias: prior.slope_bias_std,
            speed_delay: settings.sensors.speed_delay_std,
            load_sensitivity: UNOPENED,
        }
        .state()
    }
}
