//! What is learnt beside the state from a row in which both wheels count: fluctuation of slips, agreement of manoeuvres, curves,
//! and a locked centre drive.

use super::{Belief, CgFilter};
use crate::loader::doubts::coupling::Turning;
use crate::loader::doubts::curves::Difference;
use crate::loader::doubts::manoeuvres::Slip;
use crate::loader::layout::{CG_HEIGHT, CG_RATIO, FRONT_WHEEL, REAR_WHEEL, SLIP_STIFFNESS, SPEED};
use crate::loader::measurements::wheel_lag::Row;
use crate::loader::measurements::windup::LEAST_SHARE;
use crate::loader::physics::cg_model::CgModel;
use crate::loader::settings::Settings;

/// Values before the row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before {
    pub speed: f64,
    pub ratio_variance: f64,
}

/// A row in which both wheels count.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen<'a, const N: usize, const M: usize> {
    pub before: Before,
    /// Predicted state.
    pub state: &'a [f64; N],
    pub process_std: &'a [f64; N],
    pub measured: &'a [f64; M],
    pub innovation: &'a [f64; M],
    pub std: &'a [f64; M],
    /// Variance of each wheel in this row alone [rad^2/s^2].
    pub noise: [f64; 2],
    /// Sine of the slope.
    pub sine: f64,
}

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    pub(super) fn before(&self) -> Before {
        Before {
            speed: self.belief.state()[SPEED],
            ratio_variance: self.belief.variance(CG_RATIO),
        }
    }

    pub(super) fn learn_from_wheels(
        &mut self,
        settings: &Settings,
        seen: &Seen<N, M>,
        expected: &B::Expected,
        model: &CgModel,
    ) {
        let wheel = |i: usize| (seen.innovation[i], B::measurement_std(expected, i));
        let wheels = [wheel(FRONT_WHEEL), wheel(REAR_WHEEL)];
        self.wheel_noise.see(&settings.estimator, wheels, model.dt);
        self.see_slip_noise(seen, model.dt);
        self.see_lag(seen, model);
        let slip = self.slip(seen, model);
        let disagrees = self
            .manoeuvres
            .take(&slip, seen.before.ratio_variance, model.dt);
        if disagrees && self.relearning.settled() {
            // A leg with a large deviation opens height and ratio again.
            self.changed = 0.0;
        }
        let predicted = B::difference_variance(expected, [FRONT_WHEEL, REAR_WHEEL]);
        if !self.turning_reported {
            let variances = [predicted, seen.noise[0] + seen.noise[1]];
            self.watch_curves(settings, &slip, seen.state[SPEED], variances, model.dt);
        }
        let difference = |of: &[f64; M]| of[FRONT_WHEEL] - of[REAR_WHEEL];
        let [front, rear] = [FRONT_WHEEL, REAR_WHEEL].map(|i| seen.process_std[i]);
        self.coupling.see(&Turning {
            difference: difference(seen.measured),
            innovation: difference(seen.innovation),
            predicted,
            process: front * front + rear * rear,
            noise: seen.noise[0] + seen.noise[1],
            dt: model.dt,
        });
    }

    /// Updates the noise of the slips. Brakes and turns carry no information about it.
    fn see_slip_noise(&mut self, seen: &Seen<N, M>, dt: f64) {
        let radius = self.dynamics.wheel_radius;
        let [front, rear] = [FRONT_WHEEL, REAR_WHEEL].map(|i| radius * seen.innovation[i]);
        let common = 0.5 * (front + rear) - seen.innovation[SPEED];
        let turns = self.effect.turn * seen.state[SPEED].abs();
        for (noise, value) in self.slip_noise.iter_mut().zip([common, front - rear]) {
            if self.effect.braking || turns > noise.of_a_mean() || !value.is_finite() {
                noise.interrupt();
            } else {
                noise.see(value, dt);
            }
        }
    }

    /// Updates the lag between both wheel speeds. Braking carries no information about it, bending less.
    fn see_lag(&mut self, seen: &Seen<N, M>, model: &CgModel) {
        if self.effect.braking {
            return self.wheel_lag.interrupt();
        }
        let row = Row {
            speeds: [seen.state[SPEED], seen.before.speed],
            difference: seen.measured[FRONT_WHEEL] - seen.measured[REAR_WHEEL]
                + self.effect.closing / self.dynamics.wheel_radius,
            turn: self.effect.turn,
            torques: [model.inputs.front_torque, model.inputs.rear_torque],
            share: model.loading.share * seen.state[CG_RATIO] + model.loading.ratio,
        };
        self.wheel_lag.see(&self.dynamics, &row, model.dt);
    }

    /// Returns the difference of the rim speeds in a row, for its leg.
    fn slip(&self, seen: &Seen<N, M>, model: &CgModel) -> Slip {
        let (machine, inputs) = (&self.dynamics, &model.inputs);
        let radius = machine.wheel_radius;
        let [speed, stiffness, height, ratio] =
            [SPEED, SLIP_STIFFNESS, CG_HEIGHT, CG_RATIO].map(|i| seen.state[i]);
        let acceleration = (speed - seen.before.speed) / model.dt;
        let lift = acceleration + machine.gravity * seen.sine;
        let front = ratio - height * lift / (machine.gravity * machine.wheelbase);
        let front = front.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE);
        let per_weight = 1.0 / (radius * stiffness * machine.mass * machine.gravity);
        let slip = |torque: f64, share: f64| torque * per_weight / (share * share);
        let moved = slip(inputs.front_torque, front) + slip(inputs.rear_torque, 1.0 - front);
        let [front, rear] = [FRONT_WHEEL, REAR_WHEEL].map(|i| seen.std[i]);
        Slip {
            innovation: radius * (seen.innovation[FRONT_WHEEL] - seen.innovation[REAR_WHEEL]),
            variance: radius * radius * (front * front + rear * rear),
            by_share: -speed.abs() * moved,
            driving: (inputs.front_torque + inputs.rear_torque) * speed > 0.0,
        }
    }

    /// Updates the unreported curves. `variances`: those of prediction and row [rad^2/s^2].
    fn watch_curves(
        &mut self,
        settings: &Settings,
        slip: &Slip,
        speed: f64,
        variances: [f64; 2],
        dt: f64,
    ) {
        let per_speed = 1.0 / speed.abs().max(settings.estimator.v_freeze);
        let radius = self.dynamics.wheel_radius * per_speed;
        let [predicted, noise] = variances.map(|variance| radius * radius * variance);
        let row = Difference {
            innovation: slip.innovation * per_speed,
            predicted,
            noise,
            by_share: slip.by_share * per_speed,
        };
        self.curves.see(&row, dt);
    }
}
