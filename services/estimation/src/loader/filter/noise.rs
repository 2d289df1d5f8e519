//! Process noise and measurement noise of a step, by state and by measurement.

use core::f64::consts::FRAC_1_SQRT_2;

use super::{Belief, CgFilter};
use crate::loader::layout::{
    ByState, CENTRE, CG_HEIGHT, CG_RATIO, FRONT_WHEEL, Layout, REAR_WHEEL, SLIP_STIFFNESS, SPEED,
};
use crate::loader::measurements::conditions::Conditions;
use crate::loader::measurements::wheel_noise::{REFERENCE_STEP, WheelStep};
use crate::loader::physics::cg_model::CgModel;
use crate::loader::physics::wheel_dynamics::WheelDynamics;
use crate::loader::settings::Settings;
use crate::math::sqrt;

/// Correlation time of a force that the torques do not explain [s]: a bucket enters a pile.
const FORCE_TIME: f64 = 0.25;
/// Horizontal distance by which a lift moves the load [wheelbases].
const LIFT_REACH: f64 = 0.1;
/// Time from lift to lift of a loader at work [s].
const LIFT_INTERVAL: f64 = 30.0;
/// Relative standard deviation of the friction limit of the ground: .9 on dry concrete, .55 on firm earth (Wong, Theory of Ground
/// Vehicles, 1.4).
const GROUND: f64 = 0.2;
/// Time on one kind of ground [s].
const GROUND_TIME: f64 = 0.4;

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Process noise of a step, by state: random walks, and what was loosened.
    pub(super) fn process_std(
        &self,
        settings: &Settings,
        conditions: &Conditions,
        boom_moving: bool,
        dt: f64,
    ) -> [f64; N] {
        let mut std = self.walk_std(settings, conditions, boom_moving, dt);
        for (std, more) in std.iter_mut().zip(self.loosened) {
            // Without loosening the noise is unchanged to the bit.
            if more > 0.0 {
                *std = sqrt(*std * *std + more * more);
            }
        }
        std
    }

    /// Random walk of the states over `dt`.
    pub(super) fn walk_std(
        &self,
        settings: &Settings,
        conditions: &Conditions,
        boom_moving: bool,
        dt: f64,
    ) -> [f64; N] {
        let keys = &settings.estimator;
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
        if settings.protected() && !self.known_load.is_some() {
            self.free_centre(settings, &mut std, conditions, boom_moving, scale);
        }
        if settings.at_work() {
            self.follow_force(&mut std, dt);
        }
        std[SPEED] = std[SPEED].max(self.dynamics.gravity * settings.sensors.slope_std * dt);
        if let Some(bias) = const { Layout::of(N) }.slope_bias
            && settings.at_work()
        {
            std[bias] = std[bias].max(self.slope_error.walk(dt));
        }
        std
    }

    /// Lets the force on the bucket, or the speed where it is no state, follow a force that the torques do not explain.
    fn follow_force(&self, std: &mut [f64; N], dt: f64) {
        let walk = self.effect.changes * sqrt(2.0 * dt / FORCE_TIME);
        let (state, walk) = match const { Layout::of(N) }.spade_force {
            Some(force) => (force, self.dynamics.mass * walk),
            None => (SPEED, FORCE_TIME * walk),
        };
        std[state] = std[state].max(walk);
    }

    /// Opens height and ratio of a machine with an unknown load: the boom moves, or the bucket was dug full.
    fn free_centre(
        &self,
        settings: &Settings,
        std: &mut [f64; N],
        conditions: &Conditions,
        boom_moving: bool,
        scale: f64,
    ) {
        let (keys, prior) = (&settings.estimator, &settings.prior);
        if boom_moving || self.lifts_unreported(settings) {
            std[CG_HEIGHT] = keys.boom_gain * scale * keys.q_cg_height;
            std[CG_RATIO] = if boom_moving {
                keys.boom_gain * scale * keys.q_cg_ratio
            } else {
                // A wider walk makes the valley of ratio, radii and their sensitivity look like information.
                let lift = self.load.share() * LIFT_REACH;
                std[CG_RATIO].max(lift * scale * sqrt(REFERENCE_STEP / LIFT_INTERVAL))
            };
        }
        let weighed = self.is_loaded();
        if weighed {
            // However long the boom moves, the variance stays within that expected of a loaded machine.
            for (i, (_, most)) in CENTRE.into_iter().zip(self.expected_centre(settings)) {
                let room = (most * most - self.belief.variance(i)).max(0.0);
                std[i] = std[i].min(sqrt(room));
            }
        }
        // A weighed load needs no guess of the bucket's content.
        if conditions.reopen && keys.reopen > 0.0 && !weighed {
            std[CG_HEIGHT] = keys.reopen * prior.cg_height_std;
            std[CG_RATIO] = keys.reopen * prior.cg_ratio_std;
        }
    }

    /// Noise of the sensors alone.
    pub(super) fn sensor_std(&self, settings: &Settings) -> [f64; M] {
        let sensors = &settings.sensors;
        let acceleration_std = if settings.at_work() {
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

    /// Noise of the wheel speed sensors, quantisation included [rad/s].
    fn wheel_sensor_std(&self, settings: &Settings) -> [f64; 2] {
        let stated = settings.sensors.wheel_speed_std;
        if settings.at_work() {
            self.quantisation.widen(stated)
        } else {
            [stated; 2]
        }
    }

    /// Noise of a row's measurements; that of the wheels includes slips, tyres and disturbances.
    pub(super) fn measurement_std(
        &mut self,
        settings: &Settings,
        state: &[f64; N],
        conditions: &Conditions,
        model: &CgModel,
    ) -> [f64; M] {
        let mut std = self.sensor_std(settings);
        let step = WheelStep {
            machine: &model.dynamics,
            inputs: &model.inputs,
            sensor_std: self.wheel_sensor_std(settings),
            weak: conditions.frozen,
            learns_ripple: settings.at_work(),
            dt: model.dt,
        };
        [std[FRONT_WHEEL], std[REAR_WHEEL]] = self.wheel_noise.std(
            &settings.estimator,
            &step,
            state[SPEED],
            state[SLIP_STIFFNESS],
        );
        if settings.at_work() {
            let [common, apart] = &self.slip_noise;
            std[SPEED] = common.or(std[SPEED], 1.0, model.dt);
            // Either wheel has half of the variance of their difference.
            let per_difference = FRAC_1_SQRT_2 / self.dynamics.wheel_radius;
            let disturbed = self.disturbed_slip(state[SPEED]);
            let ground = ground_std(&model.dynamics, state, model.dt);
            for (i, ground) in [FRONT_WHEEL, REAR_WHEEL].into_iter().zip(ground) {
                let own = apart.or(std[i], per_difference, model.dt);
                std[i] = sqrt(own * own + disturbed * disturbed + ground * ground);
            }
        }
        std
    }

    /// Standard deviation of a wheel speed from turns and forces that the model does not contain [rad/s].
    pub(super) fn disturbed_slip(&self, speed: f64) -> f64 {
        let effect = &self.effect;
        let slip = sqrt(effect.turn * effect.turn + effect.force * effect.force);
        slip * speed.abs() / self.dynamics.wheel_radius
    }
}

/// Standard deviations of the wheel speeds from the friction limit of the ground [rad/s], as white noise.
///
/// A tyre that saturates as s = mu/K artanh u, u = F/(mu F_z), slips by (sinh 2x/2x - 1) s dmu/mu more on ground with another mu,
/// x = K s/mu: by 6 % of dmu/mu at a slip of 1 %, by twice dmu/mu at 6 %. Near its limit a tyre measures the ground.
fn ground_std<const N: usize>(machine: &WheelDynamics, state: &[f64; N], dt: f64) -> [f64; 2] {
    let (speed, radius) = (state[SPEED], machine.wheel_radius);
    let fastest = speed.abs().max(machine.minimum_speed);
    let used_per_slip = state[SLIP_STIFFNESS] * radius / (fastest * machine.friction);
    let white = GROUND * sqrt((GROUND_TIME / dt).max(1.0));
    let rolling = speed / radius;
    [FRONT_WHEEL, REAR_WHEEL].map(|wheel| {
        let slip = state[wheel] - rolling;
        let used = used_per_slip * slip;
        let square = used * used;
        white * slip * square * (2.0 / 3.0 + 2.0 / 15.0 * square)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise of a wheel with this slip at 2 m/s, over its slip.
    fn ground(slip: f64) -> f64 {
        let machine = WheelDynamics::of(&Settings::DEFAULT);
        let mut state = [0.0; 8];
        (state[SPEED], state[SLIP_STIFFNESS]) = (2.0, 19.0);
        state[FRONT_WHEEL] = 2.0 * (1.0 + slip) / machine.wheel_radius;
        ground_std(&machine, &state, 1.0)[0] / (2.0 * slip / machine.wheel_radius)
    }

    #[test]
    fn near_its_limit_a_tyre_measures_the_ground() {
        // (sinh 2x/2x - 1) dmu/mu with x = K s/mu.
        let exact = |slip: f64| {
            let x = 2.0 * 19.0 * slip / Settings::DEFAULT.machine.friction;
            GROUND * (x.sinh() / x - 1.0)
        };
        for (slip, within) in [(0.005, 0.01), (0.02, 0.01), (0.04, 0.08)] {
            let (found, exact) = (ground(slip), exact(slip));
            assert!(
                (found / exact - 1.0).abs() < within,
                "{slip}: {found} {exact}"
            );
        }
        assert!(ground(0.06) > 1.7 * GROUND && ground(-0.06) > 1.7 * GROUND);
        let machine = WheelDynamics {
            friction: f64::INFINITY,
            ..WheelDynamics::of(&Settings::DEFAULT)
        };
        assert_eq!(ground_std(&machine, &[1.0; 8], 0.01), [0.0; 2]);
    }
}
