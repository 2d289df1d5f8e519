//! Prior, process noise and measurement noise of a step, by state and measurement.

use super::{Belief, CgFilter};
use crate::loader::cg_model::CgModel;
use crate::loader::conditions::{Conditions, REFERENCE_STEP, WheelStep};
use crate::loader::layout::{
    CG_HEIGHT, CG_RATIO, FRONT_WHEEL, Layout, REAR_WHEEL, SLIP_STIFFNESS, SPEED,
};
use crate::loader::load::Centre;
use crate::loader::wheel_dynamics::GRAVITY;
use crate::math::sqrt;

/// Standard deviation of a state that is not estimated yet: next to nothing, and not nothing, which no covariance root has.
const UNOPENED: f64 = 1e-9;

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
        let (keys, prior) = (&self.settings.estimator, &self.settings.prior);
        let scale = sqrt(dt / REFERENCE_STEP);
        let mut std: [f64; N] = ByState {
            motion: [keys.q_speed, keys.q_wheel_speed, keys.q_wheel_speed],
            parameters: [keys.q_slip_stiffness, keys.q_cg_height, keys.q_cg_ratio],
            spade_force: keys.q_spade_force,
            radius: keys.q_radius,
            slope_bias: keys.q_slope_bias,
            speed_delay: keys.q_speed_delay,
            load_sensitivity: 0.0,
        }
        .state()
        .map(|q| q * scale);
        if conditions.frozen {
            std[SLIP_STIFFNESS..=CG_RATIO].fill(0.0);
        }
        if self.settings.protected() && !self.knows_its_load() {
            if boom_moving || self.lifts_unreported() {
                std[CG_HEIGHT] = keys.boom_gain * scale * keys.q_cg_height;
                std[CG_RATIO] = keys.boom_gain * scale * keys.q_cg_ratio;
            }
            let weighed = self.load.share() > LEAST_LOAD;
            if weighed {
                // However long the boom may have moved, it has not left the machine.
                for (i, (_, most)) in [CG_HEIGHT, CG_RATIO]
                    .into_iter()
                    .zip(self.expected_centre())
                {
                    let room = (most * most - self.belief.variance(i)).max(0.0);
                    std[i] = std[i].min(sqrt(room));
                }
            }
            // What is weighed needs no guess of what the bucket holds.
            if conditions.reopen && keys.reopen > 0.0 && !weighed {
                std[CG_HEIGHT] = keys.reopen * prior.cg_height_std;
                std[CG_RATIO] = keys.reopen * prior.cg_ratio_std;
            }
        }
        std[SPEED] = std[SPEED].max(GRAVITY * self.settings.sensors.slope_std * dt);
        if let Some(bias) = const { Layout::of(N) }.slope_bias
            && self.settings.at_work()
        {
            std[bias] = std[bias].max(self.slope_error.walk(dt));
        }
        for (std, more) in std.iter_mut().zip(self.loosened) {
            // The usual noise keeps its bits.
            if more > 0.0 {
                *std = sqrt(*std * *std + more * more);
            }
        }
        std
    }

    /// Height and ratio as they may be under the present load, where the motion has shown nothing.
    pub(super) fn expected_centre(&self) -> Centre {
        let prior = &self.settings.prior;
        let empty = [
            (prior.cg_height, prior.cg_height_std),
            (prior.cg_ratio, prior.cg_ratio_std),
        ];
        let reach = self.settings.machine.bucket_reach / self.dynamics.wheelbase;
        self.load.expected(empty, reach)
    }

    /// The machine is loaded, and nobody would say if the boom moved.
    pub(in crate::loader) fn lifts_unreported(&self) -> bool {
        self.settings.at_work() && !self.boom_reported && self.load.share() > LEAST_LOAD
    }

    /// A step of the mass moves the centre of gravity and makes it uncertain.
    pub(super) fn weigh(&mut self, dt: f64) {
        let state = *self.belief.state();
        let centre = [CG_HEIGHT, CG_RATIO].map(|i| (state[i], self.belief.std(i)));
        let Some(shift) = self.load.weigh(self.hold.mass, centre, dt) else {
            return;
        };
        if let Some(centre) = shift.restored {
            self.restore(centre);
            return;
        }
        let reach = self.settings.machine.bucket_reach / self.dynamics.wheelbase;
        let (ratio, ratio_std) = shift.ratio(state[CG_RATIO], reach);
        self.belief.state_mut()[CG_RATIO] = ratio;
        let height_std = shift.height_std(state[CG_HEIGHT]);
        for (i, std) in [(CG_HEIGHT, height_std), (CG_RATIO, ratio_std)] {
            let loosened = &mut self.loosened[i];
            *loosened = sqrt(*loosened * *loosened + std * std);
        }
        // The bucket was dug full, and what it holds is weighed: no longer anything.
        for (i, (_, most)) in [CG_HEIGHT, CG_RATIO]
            .into_iter()
            .zip(self.expected_centre())
        {
            if self.belief.std(i) > most {
                self.belief.separate(&[(i, most)], &[0.0; N]);
            }
        }
        self.clamp();
    }

    /// Height and ratio are again what they were; of their correlation with other states nothing is kept.
    pub(super) fn restore(&mut self, centre: Centre) {
        let [height, ratio] = centre;
        self.belief
            .separate(&[(CG_HEIGHT, height.1), (CG_RATIO, ratio.1)], &[0.0; N]);
        let state = self.belief.state_mut();
        (state[CG_HEIGHT], state[CG_RATIO]) = (height.0, ratio.0);
    }

    /// Process noise beyond the usual, for what must be learnt again.
    pub(super) fn loosening(&mut self) -> [f64; N] {
        let (prior, state) = (&self.settings.prior, self.belief.state());
        let (mut share, mut radius) = (0.0, 0.0);
        if self.settings.at_work() {
            let ratio_std = self.belief.std(CG_RATIO);
            share = self.relearning.loosening(
                self.settings.estimator.relearn,
                prior,
                [state[SLIP_STIFFNESS], state[CG_RATIO]],
                ratio_std,
            );
            let loading = self.loading();
            let ratio = loading.share * state[CG_RATIO] + loading.ratio;
            let sensitivity_std = self.settings.machine.radius_load_sensitivity_std;
            radius = self.relearning.radius_std(sensitivity_std, ratio);
        }
        let learnt = prior.radius_std * share;
        let parameters = [
            prior.slip_stiffness_std,
            prior.cg_height_std,
            prior.cg_ratio_std,
        ];
        ByState {
            parameters: parameters.map(|std| std * share),
            radius: sqrt(learnt * learnt + radius * radius),
            ..ByState::default()
        }
        .state()
    }

    pub(super) fn sensor_std(&self) -> [f64; M] {
        let sensors = &self.settings.sensors;
        let acceleration_std = if self.settings.at_work() {
            self.disturbance.shaking.std(sensors.acceleration_std)
        } else {
            sensors.acceleration_std
        };
        let all = [
            sensors.speed_std,
            sensors.wheel_speed_std,
            sensors.wheel_speed_std,
            acceleration_std,
        ];
        core::array::from_fn(|j| all[j])
    }

    /// Noise of the wheel speed sensors, with that of their steps [rad/s].
    pub(super) fn wheel_sensor_std(&self) -> [f64; 2] {
        let stated = self.settings.sensors.wheel_speed_std;
        if self.settings.at_work() {
            self.quantisation.widen(stated)
        } else {
            [stated; 2]
        }
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
            sensor_std: self.wheel_sensor_std(),
            weak: conditions.weak_wheels,
            learns_ripple: self.settings.at_work(),
            dt: model.dt,
        };
        [std[FRONT_WHEEL], std[REAR_WHEEL]] = self.monitor.wheel_std(
            &self.settings.estimator,
            &step,
            state[SPEED],
            state[SLIP_STIFFNESS],
        );
        std
    }

    pub(super) fn prior_state(&self) -> [f64; N] {
        let prior = &self.settings.prior;
        let mut state: [f64; N] = ByState {
            parameters: [prior.slip_stiffness, prior.cg_height, prior.cg_ratio],
            slope_bias: prior.slope_bias,
            speed_delay: self.settings.sensors.speed_delay,
            ..ByState::default()
        }
        .state();
        if let Some(radii) = const { Layout::of(N) }.radii {
            [state[radii[0]], state[radii[1]]] =
                [prior.front_radius_error, prior.rear_radius_error];
        }
        state
    }

    pub(super) fn prior_std(&self) -> [f64; N] {
        let prior = &self.settings.prior;
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
            speed_delay: self.settings.sensors.speed_delay_std,
            load_sensitivity: UNOPENED,
        }
        .state()
    }
}

/// One value for each state.
#[derive(Clone, Copy, Debug, Default)]
struct ByState {
    /// Of v, w_f, w_r.
    motion: [f64; 3],
    /// Of K, h, lam.
    parameters: [f64; 3],
    spade_force: f64,
    /// Of both radii.
    radius: f64,
    slope_bias: f64,
    speed_delay: f64,
    load_sensitivity: f64,
}

impl ByState {
    /// The values where their states stand; what the filter does not have is left out.
    #[inline(always)]
    fn state<const N: usize>(self) -> [f64; N] {
        let layout = const { Layout::of(N) };
        core::array::from_fn(|i| match i {
            SPEED..=REAR_WHEEL => self.motion[i],
            SLIP_STIFFNESS..=CG_RATIO => self.parameters[i - SLIP_STIFFNESS],
            _ if layout.spade_force == Some(i) => self.spade_force,
            _ if layout.slope_bias == Some(i) => self.slope_bias,
            _ if layout.speed_delay == Some(i) => self.speed_delay,
            _ if layout.load_sensitivity == Some(i) => self.load_sensitivity,
            _ => self.radius,
        })
    }
}
