//! The consistent step with all protections: prediction, de-weighting, update.

use super::report::RowReport;
use super::wheels::{Before, Seen};
use super::{Belief, CgFilter};
use crate::loader::input::inputs::StepInputs;
use crate::loader::layout::{CG_RATIO, FRONT_WHEEL, Layout, REAR_WHEEL, SLIP_STIFFNESS, SPEED};
use crate::loader::measurements::conditions::Conditions;
use crate::loader::measurements::slip_noise::SlipNoise;
use crate::loader::physics::cg_model::CgModel;
use crate::loader::sample::Sample;
use crate::loader::settings::Settings;

/// Measurements of a row; NaN where missing.
pub(super) fn measurements<const M: usize>(sample: &Sample, acceleration: Option<f64>) -> [f64; M] {
    let all = [
        sample.speed,
        sample.front_wheel_speed,
        sample.rear_wheel_speed,
        acceleration,
    ];
    core::array::from_fn(|j| all[j].unwrap_or(f64::NAN))
}

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    pub(super) fn update(
        &mut self,
        settings: &Settings,
        model: &CgModel,
        sample: &Sample,
        step: &StepInputs,
    ) -> RowReport<M> {
        let mut ahead = self.belief.ahead(model);
        let (before, sensitivity) = (self.before(), self.sensitivity());
        let held = (settings.at_work() && self.effect.braking).then(|| self.moments());
        let state = *B::state_ahead(&ahead);
        let conditions = self.conditions(settings, &state, step, model.dt);
        let process_std = self.process_std(settings, &conditions, sample.boom_moving, model.dt);
        let measured = measurements::<M>(sample, step.acceleration);
        self.quantisation
            .see([measured[FRONT_WHEEL], measured[REAR_WHEEL]]);
        let mut std = self.measurement_std(settings, &state, &conditions, model);
        let mut expected = self.belief.predict(&mut ahead, model, &process_std);
        let innovation = self.innovation(settings, &measured, before, &state, &expected, model);
        let noise = if settings.at_work() {
            self.doubt_hops(settings, &innovation, &expected, state[SPEED], &mut std)
        } else {
            [0.0; 2]
        };
        let gated = self.gates(settings, sample, &innovation, &mut std, &expected);
        let accepted = gated.accepted;
        let both = accepted[FRONT_WHEEL] && accepted[REAR_WHEEL] && !conditions.frozen;
        if settings.at_work() && both {
            let seen = Seen {
                before,
                state: &state,
                process_std: &process_std,
                measured: &measured,
                innovation: &innovation,
                std: &std,
                noise,
                sine: step.sine,
            };
            self.learn_from_wheels(settings, &seen, &expected, model);
        } else {
            self.wheel_lag.interrupt();
            self.slip_noise.iter_mut().for_each(SlipNoise::interrupt);
        }
        let nis = self
            .belief
            .update(&mut expected, &innovation, &std, &accepted);
        let walked = process_std[CG_RATIO] * process_std[CG_RATIO];
        self.learn_under_load(before.ratio_variance + walked);
        self.clamp(settings);
        self.loosen(settings, sensitivity, &process_std, state[SPEED], model.dt);
        if let Some(held) = held {
            self.hold_parameters(&held, &process_std);
        }
        RowReport {
            nis,
            frozen: conditions.frozen,
            ..gated
        }
    }

    /// Conditions of a row.
    fn conditions(
        &mut self,
        settings: &Settings,
        state: &[f64; N],
        step: &StepInputs,
        dt: f64,
    ) -> Conditions {
        let place = const { Layout::of(N) }.spade_force;
        let unknown_force = place.map_or(0.0, |i| state[i]);
        let force = step.inputs.spade_force_x + unknown_force;
        let mut conditions = self.digging.conditions(settings, state[SPEED], force, dt);
        let other_mass = settings.at_work() && self.disturbance.mass.lighter() != 0.0;
        if self.known_load.is_open() || other_mass {
            // Neither the mass nor the position of the load is known.
            conditions.frozen = true;
        }
        conditions
    }

    /// Innovations. Those of the wheels at work exclude the wind-up of the tyres, the bending of the machine, and the lag between
    /// the axles.
    fn innovation(
        &mut self,
        settings: &Settings,
        measured: &[f64; M],
        before: Before,
        state: &[f64; N],
        expected: &B::Expected,
        model: &CgModel,
    ) -> [f64; M] {
        let predicted = B::measurement(expected);
        let mut innovation: [f64; M] = core::array::from_fn(|j| measured[j] - predicted[j]);
        if settings.at_work() {
            let windup = self.windup.wheel_speeds(
                settings.machine.relaxation_length,
                &model.dynamics,
                &model.inputs,
                model.dt,
                [state[SLIP_STIFFNESS], state[CG_RATIO]],
            );
            // It is unknown on which body the speed is measured, and which wheel speed is in time with it: half of each correction
            // for each axle.
            let gained = (state[SPEED] - before.speed) / model.dt * self.wheel_lag.lag().value;
            let apart = 0.5 * (self.effect.closing - gained) / self.dynamics.wheel_radius;
            innovation[FRONT_WHEEL] += apart - windup[0];
            innovation[REAR_WHEEL] -= apart + windup[1];
        }
        innovation
    }

    /// De-weights wheels that hop; returns the variance of each wheel in this row alone [rad^2/s^2].
    fn doubt_hops(
        &self,
        settings: &Settings,
        innovation: &[f64; M],
        expected: &B::Expected,
        speed: f64,
        std: &mut [f64; M],
    ) -> [f64; 2] {
        let keys = &settings.estimator;
        let disturbed = self.disturbed_slip(speed);
        for (wheel, j) in [FRONT_WHEEL, REAR_WHEEL].into_iter().enumerate() {
            let predicted = B::measurement_std(expected, j);
            let more = predicted * predicted + disturbed * disturbed;
            std[j] *= self.wheel_noise.far(keys, wheel, innovation[j], more);
        }
        let rows = self.wheel_noise.row_variance(keys);
        rows.map(|row| disturbed * disturbed + row)
    }
}
