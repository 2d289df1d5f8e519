//! Prior, process noise and measurement noise of a step, by state and measurement.

use super::{Belief, CgFilter};
use crate::loader::cg_model::{CgModel, radius_states};
use crate::loader::conditions::{Conditions, REFERENCE_STEP, WheelStep};
use crate::loader::load::Centre;
use crate::loader::wheel_dynamics::GRAVITY;
use crate::math::sqrt;

/// Share of the mass from which on the machine is loaded.
const LEAST_LOAD: f64 = 0.04;

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Process noise of a step, by state.
    pub(super) fn process_std(
        &self,
        conditions: &Conditions,
        boom_moving: bool,
        dt: f64,
    ) -> [f64; N] {
        let (noise, prior) = (&self.tuning.noise, &self.settings.prior);
        let scale = sqrt(dt / REFERENCE_STEP);
        let mut parameters =
            [noise.slip_stiffness, noise.cg_height, noise.cg_ratio].map(|q| q * scale);
        if conditions.frozen {
            parameters = [0.0; 3];
        }
        if let (Some(rule), None) = (self.tuning.digging, self.payload) {
            if boom_moving || self.lifts_untold() {
                parameters[1] = rule.boom_gain * scale * noise.cg_height;
                parameters[2] = rule.boom_gain * scale * noise.cg_ratio;
            }
            if conditions.reopen && rule.reopen > 0.0 {
                parameters[1] = rule.reopen * prior.cg_height_std;
                parameters[2] = rule.reopen * prior.cg_ratio_std;
            }
        }
        let mut motion = [noise.speed, noise.wheel_speed, noise.wheel_speed].map(|q| q * scale);
        motion[0] = motion[0].max(GRAVITY * self.settings.sensors.slope_std * dt);
        let rest = [
            noise.spade_force_x,
            noise.radius,
            noise.slope_bias,
            noise.speed_delay,
        ]
        .map(|q| q * scale);
        let mut rest = rest;
        if self.tuning.screened {
            rest[2] = rest[2].max(self.slope_error.walk(dt));
        }
        let mut std: [f64; N] = by_state(motion, parameters, rest);
        for (std, more) in std.iter_mut().zip(self.loosened) {
            // The usual noise keeps its bits.
            if more > 0.0 {
                *std = sqrt(*std * *std + more * more);
            }
        }
        std
    }

    /// The machine is loaded, and nobody would say if the boom moved.
    pub(in crate::loader) fn lifts_untold(&self) -> bool {
        self.tuning.load_shift && !self.boom_told && self.load.share() > LEAST_LOAD
    }

    /// A step of the mass moves the centre of gravity and makes it uncertain.
    pub(super) fn weigh(&mut self, dt: f64) {
        let state = *self.belief.state();
        let centre = [4, 5].map(|i| (state[i], self.belief.std(i)));
        let Some(shift) = self.load.weigh(self.hold.mass, centre, dt) else {
            return;
        };
        if let Some(centre) = shift.restored {
            self.restore(centre);
            return;
        }
        let reach = self.settings.machine.bucket_reach / self.dynamics.wheelbase;
        let (ratio, ratio_std) = shift.ratio(state[5], reach);
        self.belief.state_mut()[5] = ratio;
        for (i, std) in [(4, shift.height_std(state[4])), (5, ratio_std)] {
            let loosened = &mut self.loosened[i];
            *loosened = sqrt(*loosened * *loosened + std * std);
        }
        self.clamp();
    }

    /// Height and ratio are again what they were; of their correlation with other states nothing is kept.
    fn restore(&mut self, centre: Centre) {
        let [height, ratio] = centre;
        self.belief
            .separate(&[(4, height.1), (5, ratio.1)], &[0.0; N]);
        let state = self.belief.state_mut();
        (state[4], state[5]) = (height.0, ratio.0);
    }

    /// Process noise beyond the usual, for what must be learnt again.
    pub(super) fn loosening(&mut self) -> [f64; N] {
        let (prior, state) = (&self.settings.prior, self.belief.state());
        let (mut share, mut radius) = (0.0, 0.0);
        if let Some(rule) = &self.tuning.relearning {
            let ratio_std = self.belief.std(5);
            share = self
                .relearning
                .loosening(rule, prior, [state[3], state[5]], ratio_std);
        }
        if self.tuning.load_shift {
            let loading = self.loading();
            let ratio = loading.share * state[5] + loading.ratio;
            let sensitivity_std = self.settings.machine.radius_load_sensitivity_std;
            radius = self.relearning.radius_std(sensitivity_std, ratio);
        }
        let learnt = prior.radius_std * share;
        by_state(
            [0.0; 3],
            [
                prior.slip_stiffness_std,
                prior.cg_height_std,
                prior.cg_ratio_std,
            ]
            .map(|std| std * share),
            [0.0, sqrt(learnt * learnt + radius * radius), 0.0, 0.0],
        )
    }

    pub(super) fn sensor_std(&self) -> [f64; M] {
        let sensors = &self.settings.sensors;
        let all = [
            sensors.speed_std,
            sensors.wheel_speed_std,
            sensors.wheel_speed_std,
            sensors.acceleration_std,
        ];
        core::array::from_fn(|j| all[j])
    }

    pub(super) fn measurement_std(
        &mut self,
        state: &[f64; N],
        conditions: &Conditions,
        model: &CgModel,
    ) -> [f64; M] {
        let mut std = self.sensor_std();
        let step = WheelStep {
            machine: &model.dynamics,
            inputs: &model.inputs,
            sensor_std: if self.tuning.quantum {
                self.quantum.widen(self.settings.sensors.wheel_speed_std)
            } else {
                [self.settings.sensors.wheel_speed_std; 2]
            },
            weak: conditions.weak_wheels,
            dt: model.dt,
        };
        [std[1], std[2]] =
            self.monitor
                .wheel_std(&self.tuning.inflation, &step, state[0], state[3]);
        std
    }

    pub(super) fn prior_state(&self) -> [f64; N] {
        let prior = &self.settings.prior;
        let mut state: [f64; N] = by_state(
            [0.0; 3],
            [prior.slip_stiffness, prior.cg_height, prior.cg_ratio],
            [
                0.0,
                0.0,
                prior.slope_bias,
                self.settings.sensors.speed_delay,
            ],
        );
        if let Some(radii) = radius_states(N) {
            state[radii].copy_from_slice(&prior.radius_errors);
        }
        state
    }

    pub(super) fn prior_std(&self) -> [f64; N] {
        let prior = &self.settings.prior;
        by_state(
            [
                prior.speed_std,
                prior.wheel_speed_std,
                prior.wheel_speed_std,
            ],
            [
                prior.slip_stiffness_std,
                prior.cg_height_std,
                prior.cg_ratio_std,
            ],
            [
                prior.spade_force_x_std,
                prior.radius_std,
                prior.slope_bias_std,
                self.settings.sensors.speed_delay_std,
            ],
        )
    }
}

/// One value per state from those of motion, parameters, and \[F_x, d, b, tau\].
fn by_state<const N: usize>(
    motion: [f64; 3],
    parameters: [f64; 3],
    [force, radius, bias, delay]: [f64; 4],
) -> [f64; N] {
    let extra = if N < 10 {
        [radius, radius, delay, 0.0, 0.0]
    } else {
        [force, radius, radius, bias, delay]
    };
    core::array::from_fn(|i| match i {
        0..3 => motion[i],
        3..6 => parameters[i - 3],
        _ => extra[i - 6],
    })
}
