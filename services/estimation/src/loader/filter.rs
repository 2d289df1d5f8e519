//! The estimator on a fixed number of states: what happens with one row.

use super::Method;
use super::cg_model::{CgModel, Loading};
use super::conditions::{Conditions, Monitor, REFERENCE_STEP, WheelStep};
use super::estimate::Status;
use super::inputs::{InputHold, StepInputs};
use super::payload::Payload;
use super::sample::{Sample, finite};
use super::settings::{Gates, Settings, Tuning};
use super::verdict::Evidence;
use super::wheel_dynamics::{GRAVITY, Inputs, WheelDynamics};
use crate::ekf::Ekf;
use crate::math::{sin_cos, sqrt, tanh};
use crate::prediction::Images;
use crate::root::triangularise;
use crate::sigma_points::Spread;
use crate::srukf::SquareRootUkf;

/// Measurement noise that stands for "not measured" in the printed form.
const NOT_MEASURED_STD: f64 = 1e6;

/// When every speed that comes has been rejected for this long, the filter is wrong and not the sensors [s].
///
/// Rejected rows have no normalised innovation, so the reset rule alone would never see this.
const LOCKED_OUT: f64 = 1.0;

/// What a row did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowReport<const M: usize> {
    /// How the row was taken.
    pub status: Status,
    /// Normalised innovation squared, the sum over the accepted measurements.
    pub nis: f64,
    /// Which measurements were used.
    pub accepted: [bool; M],
    /// Which of them were de-weighted.
    pub deweighted: [bool; M],
    /// Slow or digging.
    pub frozen: bool,
}

impl<const M: usize> RowReport<M> {
    fn without_update(status: Status, frozen: bool) -> Self {
        Self {
            status,
            nis: 0.0,
            accepted: [false; M],
            deweighted: [false; M],
            frozen,
        }
    }
}

/// The filter with `N` states (6, 8 or 10, see [`super::cg_model`]) and `M` measurements (3, or 4 with the specific force).
#[derive(Clone, Copy, Debug)]
pub struct CgFilter<const N: usize, const M: usize> {
    settings: Settings,
    tuning: Tuning,
    printed: bool,
    filter: SquareRootUkf<N, M>,
    dynamics: WheelDynamics,
    hold: InputHold,
    monitor: Monitor,
    pub(super) evidence: Evidence,
    last_time: Option<f64>,
    /// Force on the bucket tip measured over the last step [N].
    pub(super) spade_force_x: f64,
    payload: Option<Payload>,
    frozen: bool,
}

impl<const N: usize, const M: usize> CgFilter<N, M> {
    /// The filter before its first row; the settings must have been checked.
    pub(super) fn new(settings: &Settings, method: Method) -> Self {
        let tuning = settings.tuning(method);
        let machine = &settings.machine;
        let dynamics = WheelDynamics {
            mass: machine.mass,
            wheel_radius: machine.wheel_radius,
            axle_inertia: machine.axle_inertia,
            wheelbase: machine.wheelbase,
            bucket_reach: machine.bucket_reach,
            rolling_resistance: machine.rolling_resistance,
            friction: if tuning.real_tyre {
                machine.friction
            } else {
                f64::INFINITY
            },
            radius_load_sensitivity: if tuning.real_tyre {
                machine.radius_load_sensitivity
            } else {
                0.0
            },
            minimum_speed: tuning.minimum_speed,
            load_transfer: tuning.load_transfer,
        };
        let spread = Spread {
            alpha: tuning.spread,
            beta: tuning.beta,
            kappa: tuning.kappa,
        };
        let mut new = Self {
            settings: *settings,
            tuning,
            printed: method == Method::IsrUkfPrinted,
            filter: SquareRootUkf::new([0.0; N], &[0.0; N], spread),
            dynamics,
            hold: InputHold::new(machine.mass),
            monitor: Monitor::default(),
            evidence: Evidence::new(),
            last_time: None,
            spade_force_x: 0.0,
            payload: None,
            frozen: false,
        };
        new.filter.state = new.prior_state();
        new.filter.root = new.prior_root();
        new
    }

    /// The state \[v, w_f, w_r, K, h, lam, ..\].
    pub fn state(&self) -> &[f64; N] {
        &self.filter.state
    }

    /// The lower root of its covariance.
    pub fn covariance_root(&self) -> &[[f64; N]; N] {
        &self.filter.root
    }

    pub(super) fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    pub(super) fn last_time(&self) -> Option<f64> {
        self.last_time
    }

    pub(super) fn payload(&self) -> Option<Payload> {
        self.payload
    }

    /// Tells the payload for the rows to come; one that is not finite is ignored.
    pub(super) fn set_payload(&mut self, payload: Option<Payload>) {
        if payload.is_none_or(|p| p.is_valid()) {
            self.payload = payload;
        }
    }

    /// Takes one row.
    pub fn step(&mut self, sample: &Sample) -> RowReport<M> {
        let machine = &self.settings.machine;
        let sample = &sample.plausible(machine.mass, machine.wheel_radius);
        let Some(last) = self.last_time else {
            return self.first(sample);
        };
        let dt = sample.time - last;
        if !(dt > 0.0 && dt.is_finite()) {
            return RowReport::without_update(Status::Refused, self.frozen);
        }
        self.last_time = Some(sample.time);
        let step = self.hold.advance(sample, self.tuning.midpoint_inputs);
        self.spade_force_x = step.inputs.spade_force_x;
        self.dynamics.mass = self
            .payload
            .map_or(self.hold.mass, |p| self.settings.machine.mass + p.mass);
        self.evidence.advance(
            dt,
            step.inputs.front_torque + step.inputs.rear_torque,
            self.free_acceleration(&step),
        );
        if dt > self.tuning.gap {
            return self.bridge_gap(sample);
        }
        let model = self.model(step.inputs, dt);
        let report = if self.printed {
            self.step_printed(sample, &model)
        } else if self.tuning.linearised {
            let images = Ekf {
                state: self.filter.state,
                root: self.filter.root,
            }
            .images(&model);
            self.update(images, &model, sample, &step)
        } else {
            self.update(self.filter.images(&model), &model, sample, &step)
        };
        self.finish(report, sample, dt)
    }

    /// Starts the clock on the first row with a finite time.
    fn first(&mut self, sample: &Sample) -> RowReport<M> {
        if !sample.time.is_finite() {
            return RowReport::without_update(Status::Refused, false);
        }
        self.last_time = Some(sample.time);
        self.hold.advance(sample, false);
        self.spade_force_x = finite(sample.spade_force_x).unwrap_or(0.0);
        let speed = finite(sample.speed).unwrap_or(0.0);
        let rim = speed / self.dynamics.wheel_radius;
        let state = &mut self.filter.state;
        state[0] = speed;
        state[1] = finite(sample.front_wheel_speed).unwrap_or(rim);
        state[2] = finite(sample.rear_wheel_speed).unwrap_or(rim);
        RowReport::without_update(Status::First, false)
    }

    fn model(&self, inputs: Inputs, dt: f64) -> CgModel {
        let (mass, wheelbase) = (self.settings.machine.mass, self.dynamics.wheelbase);
        CgModel {
            dynamics: self.dynamics,
            inputs,
            dt,
            integration: self.tuning.integration,
            substeps: self.tuning.substeps,
            loading: self
                .payload
                .map_or(Loading::NONE, |p| p.loading(mass, wheelbase)),
        }
    }

    /// Acceleration along the road, measured, or what the torques would give without slip [m/s^2].
    fn free_acceleration(&self, step: &StepInputs) -> Option<f64> {
        let slope = sin_cos(step.inputs.slope).0;
        if M > 3 {
            return step.acceleration.map(|a| a - GRAVITY * slope);
        }
        let radius = self.dynamics.wheel_radius;
        let spin = 2.0 * self.dynamics.axle_inertia / (radius * radius);
        let pull = (step.inputs.front_torque + step.inputs.rear_torque) / radius;
        let weight = self.dynamics.mass * GRAVITY;
        let rolling = self.dynamics.rolling_resistance * tanh(self.filter.state[0] / 0.05) * weight;
        Some(
            (pull - rolling - weight * slope - step.inputs.spade_force_x)
                / (self.dynamics.mass + spin),
        )
    }

    /// The consistent step with every rule of the tuning.
    fn update<const B: usize>(
        &mut self,
        mut images: Images<N, M, B>,
        model: &CgModel,
        sample: &Sample,
        step: &StepInputs,
    ) -> RowReport<M> {
        let unknown_force = if N == 10 { images.state[6] } else { 0.0 };
        let force = step.inputs.spade_force_x + unknown_force;
        let conditions = self
            .monitor
            .conditions(&self.tuning, images.state[0], force, model.dt);
        let process_std = self.process_std(&conditions, sample.boom_moving, model.dt);
        let mut std = self.measurement_std(&images.state, &conditions, model);
        let prediction = images.predict(&process_std);
        let measured = measurements::<M>(sample, step.acceleration);
        let innovation = core::array::from_fn(|j| measured[j] - prediction.measurement[j]);
        let (mut accepted, mut deweighted) = ([false; M], [false; M]);
        for j in 0..M {
            let (kept, soft) = gate(self.tuning.gates, innovation[j], &mut std[j], || {
                prediction.measurement_std(j)
            });
            (accepted[j], deweighted[j]) = (kept, soft);
        }
        let update = prediction.update(&innovation, &std, &accepted);
        self.filter.accept(&update);
        self.clamp();
        let status = Status::Updated;
        RowReport {
            status,
            nis: update.nis(),
            accepted,
            deweighted,
            frozen: conditions.frozen,
        }
    }

    /// The step as printed; only held inputs and missing measurements are treated beyond the paper.
    fn step_printed(&mut self, sample: &Sample, model: &CgModel) -> RowReport<M> {
        let process_std = self.process_std(&Conditions::default(), false, model.dt);
        let measured = measurements::<M>(sample, None);
        let accepted = measured.map(f64::is_finite);
        let mut std = self.sensor_std();
        for (std, accepted) in std.iter_mut().zip(accepted) {
            if !accepted {
                *std = NOT_MEASURED_STD;
            }
        }
        let printed = self
            .filter
            .step_printed(model, &process_std, &std, |predicted| {
                core::array::from_fn(|j| {
                    if accepted[j] {
                        measured[j] - predicted[j]
                    } else {
                        0.0
                    }
                })
            });
        self.clamp();
        let status = Status::Updated;
        RowReport {
            status,
            nis: printed.nis,
            accepted,
            deweighted: [false; M],
            frozen: false,
        }
    }

    /// Counts the row, and restarts a filter that lost its way.
    fn finish(&mut self, mut report: RowReport<M>, sample: &Sample, dt: f64) -> RowReport<M> {
        self.frozen = report.frozen;
        if !self.is_finite() || !report.nis.is_finite() {
            self.filter.state = self.prior_state();
            self.restart(sample);
            return RowReport::without_update(Status::Diverged, report.frozen);
        }
        let came = [
            sample.speed,
            sample.front_wheel_speed,
            sample.rear_wheel_speed,
        ];
        self.evidence
            .admit(came.iter().any(Option::is_some), &report.accepted, dt);
        if self.evidence.locked_out > LOCKED_OUT {
            self.evidence.locked_out = 0.0;
            return self.bridge_gap(sample);
        }
        let used = report.accepted.iter().filter(|a| **a).count();
        let time_constant = self.tuning.reset.map_or(2.0, |rule| rule.time_constant);
        let weight = (dt / time_constant).min(1.0);
        self.evidence.judge(report.nis / used.max(1) as f64, weight);
        if let Some(rule) = self.tuning.reset
            && self.evidence.consistency > rule.level
            && self.evidence.since_reset > rule.hold_off
        {
            self.restart(sample);
            report.status = Status::Reset;
        }
        report
    }

    fn is_finite(&self) -> bool {
        let finite = |row: &[f64; N]| row.iter().all(|x| x.is_finite());
        finite(&self.filter.state) && self.filter.root.iter().all(finite)
    }

    /// Covariance back to the prior, speeds to their measurements; the parameters keep their values.
    fn restart(&mut self, sample: &Sample) {
        self.anchor(sample);
        self.filter.root = self.prior_root();
        self.evidence.restart();
    }

    /// After a gap the speeds are new and independent; the parameters and their joint covariance stay.
    fn bridge_gap(&mut self, sample: &Sample) -> RowReport<M> {
        self.anchor(sample);
        let mut rows = self.filter.root.map(|row| [row]);
        for row in &mut rows[..3] {
            *row = [[0.0; N]];
        }
        self.filter.root = triangularise(&mut rows, &[0.0; N]);
        let prior = &self.settings.prior;
        let least = [
            prior.speed_std,
            prior.wheel_speed_std,
            prior.wheel_speed_std,
        ];
        for (i, (sensor, least)) in self.sensor_std().into_iter().zip(least).enumerate() {
            self.filter.root[i][i] = least.max(3.0 * sensor);
        }
        RowReport::without_update(Status::Gap, self.frozen)
    }

    fn anchor(&mut self, sample: &Sample) {
        let measured = [
            sample.speed,
            sample.front_wheel_speed,
            sample.rear_wheel_speed,
        ];
        for (state, measured) in self.filter.state.iter_mut().zip(measured) {
            *state = finite(measured).unwrap_or(*state);
        }
    }

    /// Keeps the means of K, h, lam within their bounds.
    fn clamp(&mut self) {
        if let Some(bounds) = self.tuning.clamps {
            let state = &mut self.filter.state;
            for (i, (low, high)) in [
                (3, bounds.slip_stiffness),
                (4, bounds.cg_height),
                (5, bounds.cg_ratio),
            ] {
                // Not f64::clamp: NaN must pass on to the check for it.
                state[i] = if state[i] < low {
                    low
                } else if state[i] > high {
                    high
                } else {
                    state[i]
                };
            }
        }
    }

    /// Process noise of a step, by state.
    fn process_std(&self, conditions: &Conditions, boom_moving: bool, dt: f64) -> [f64; N] {
        let (noise, prior) = (&self.tuning.noise, &self.settings.prior);
        let scale = sqrt(dt / REFERENCE_STEP);
        let mut parameters =
            [noise.slip_stiffness, noise.cg_height, noise.cg_ratio].map(|q| q * scale);
        if conditions.frozen {
            parameters = [0.0; 3];
        }
        if let (Some(rule), None) = (self.tuning.digging, self.payload) {
            if boom_moving {
                parameters[1] = rule.boom_gain * scale * noise.cg_height;
                parameters[2] = rule.boom_gain * scale * noise.cg_ratio;
            }
            if conditions.reopen && rule.reopen > 0.0 {
                parameters[1] = rule.reopen * prior.cg_height_std;
                parameters[2] = rule.reopen * prior.cg_ratio_std;
            }
        }
        let motion = [noise.speed, noise.wheel_speed, noise.wheel_speed].map(|q| q * scale);
        let rest = [noise.spade_force_x, noise.radius, noise.slope_bias].map(|q| q * scale);
        by_state(motion, parameters, rest)
    }

    fn sensor_std(&self) -> [f64; M] {
        let sensors = &self.settings.sensors;
        let all = [
            sensors.speed_std,
            sensors.wheel_speed_std,
            sensors.wheel_speed_std,
            sensors.acceleration_std,
        ];
        core::array::from_fn(|j| all[j])
    }

    fn measurement_std(
        &mut self,
        state: &[f64; N],
        conditions: &Conditions,
        model: &CgModel,
    ) -> [f64; M] {
        let mut std = self.sensor_std();
        let step = WheelStep {
            machine: &model.dynamics,
            inputs: &model.inputs,
            sensor_std: self.settings.sensors.wheel_speed_std,
            weak: conditions.weak_wheels,
            dt: model.dt,
        };
        [std[1], std[2]] =
            self.monitor
                .wheel_std(&self.tuning.inflation, &step, state[0], state[3]);
        std
    }

    fn prior_state(&self) -> [f64; N] {
        let prior = &self.settings.prior;
        by_state(
            [0.0; 3],
            [prior.slip_stiffness, prior.cg_height, prior.cg_ratio],
            [0.0; 3],
        )
    }

    fn prior_root(&self) -> [[f64; N]; N] {
        let prior = &self.settings.prior;
        let std: [f64; N] = by_state(
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
            ],
        );
        core::array::from_fn(|i| core::array::from_fn(|j| if i == j { std[i] } else { 0.0 }))
    }
}

/// One value per state from those of motion, parameters, and \[F_x, d, b\].
fn by_state<const N: usize>(
    motion: [f64; 3],
    parameters: [f64; 3],
    [force, radius, bias]: [f64; 3],
) -> [f64; N] {
    let extra = if N == 8 {
        [radius, radius, 0.0, 0.0]
    } else {
        [force, radius, radius, bias]
    };
    core::array::from_fn(|i| match i {
        0..3 => motion[i],
        3..6 => parameters[i - 3],
        _ => extra[i - 6],
    })
}

/// The measurements of a row; NaN where missing.
fn measurements<const M: usize>(sample: &Sample, acceleration: Option<f64>) -> [f64; M] {
    let all = [
        sample.speed,
        sample.front_wheel_speed,
        sample.rear_wheel_speed,
        acceleration,
    ];
    core::array::from_fn(|j| finite(all[j]).unwrap_or(f64::NAN))
}

/// Whether a measurement is used, and whether it was de-weighted; `std` grows in that case.
fn gate(
    gates: Option<Gates>,
    innovation: f64,
    std: &mut f64,
    predicted_std: impl Fn() -> f64,
) -> (bool, bool) {
    if !innovation.is_finite() {
        return (false, false);
    }
    let Some(gates) = gates else {
        return (true, false);
    };
    let predicted = predicted_std();
    let normalised = innovation.abs() / sqrt(*std * *std + predicted * predicted);
    if normalised >= gates.hard || normalised.is_nan() {
        return (false, false);
    }
    let soft = normalised > gates.soft;
    if soft {
        *std += innovation.abs() / gates.soft;
    }
    (true, soft)
}
