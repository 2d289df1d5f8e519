//! The estimator on a fixed number of states: what happens with one row.

use crate::Quantity;
use crate::loader::Method;
use crate::loader::cg_model::{CgModel, Integration, Loading};
use crate::loader::conditions::{Conditions, Monitor};
use crate::loader::coupling::Coupling;
use crate::loader::curves::{Curves, Difference};
use crate::loader::directions::{BothDirections, Directions};
use crate::loader::disturbance::{Disturbance, Effect};
use crate::loader::estimate::Status;
use crate::loader::inclinometer::Inclinometer;
use crate::loader::inputs::{InputHold, StepInputs};
use crate::loader::layout::{
    CG_HEIGHT, CG_RATIO, Each, FRONT_WHEEL, Layout, REAR_WHEEL, SLIP_STIFFNESS, SPEED,
};
use crate::loader::lift_arm::Weighed;
use crate::loader::load::Load;
use crate::loader::manoeuvres::{Manoeuvres, Slip};
use crate::loader::payload::Payload;
use crate::loader::quantisation::Quantisation;
use crate::loader::relearning::Relearning;
use crate::loader::sample::Sample;
use crate::loader::settings::{Inputs as Driven, Settings};
use crate::loader::shared_slip::SharedSlip;
use crate::loader::slope::SlopeError;
use crate::loader::stuck::{Stuck, Witness};
use crate::loader::verdict::{Evidence, RATIO_PER_SENSITIVITY};
use crate::loader::wheel_dynamics::{GRAVITY, Inputs, Tyres, WheelDynamics};
use crate::loader::windup::Windup;
use crate::math::{sqrt, tanh};
use crate::sigma_points::Spread;
use crate::time_base::{Tick, TimeBase};

mod belief;
mod doubt;
mod gate;
mod noise;
mod recovery;

pub(super) use belief::Belief;
use gate::gate;

/// Measurement noise that stands for "not measured" in the printed form.
const NOT_MEASURED_STD: f64 = 1e6;

/// A longer step between rows is a jump, whatever the settings take for a gap [s].
const LONGEST_STEP: f64 = 1.0;

/// A load sensitivity that is learnt may differ by as much, whatever is stated: a guess costs nothing then.
const LEARNT_STD: f64 = 0.005;

/// A wheel that slips by more than this share spins: tyres on soil have passed their proportional range, and the force that they
/// transmit says nothing of slip stiffness and load (Wong, Theory of Ground Vehicles, 2.4). Slower than this it does not count [m/s].
const SPINS: (f64, f64) = (0.15, 0.3);

/// A wheel that seems to spin for longer, or for a third of its way, has another radius or unit than is described [s].
const LONGEST_SPIN: f64 = 5.0;

/// Acceleration beyond which the torques do not explain the motion [m/s^2].
const UNEXPLAINED: f64 = 0.15;

/// What held before the row.
#[derive(Clone, Copy, Debug)]
struct Before {
    speed: f64,
    /// Variance of the ratio.
    ratio_variance: f64,
    /// Error of the load sensitivity, and its variance.
    sensitivity: (f64, f64),
}

/// What a row in which both wheels count shows.
#[derive(Clone, Copy, Debug)]
struct Seen<const N: usize, const M: usize> {
    before: Before,
    /// Predicted state.
    state: [f64; N],
    innovation: [f64; M],
    std: [f64; M],
    /// Variance of each wheel that is no other row's [rad^2/s^2].
    noise: [f64; 2],
}

/// What a row did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RowReport<const M: usize> {
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
    /// The wheels came with their torques, but something else moves them: brakes.
    pub set_aside: bool,
}

impl<const M: usize> RowReport<M> {
    fn without_update(status: Status, frozen: bool) -> Self {
        Self {
            status,
            nis: 0.0,
            accepted: [false; M],
            deweighted: [false; M],
            frozen,
            set_aside: false,
        }
    }
}

/// The filter with `N` states (6, 8 to 11, see [`crate::loader::cg_model`]) and `M` measurements (3, or 4 with the specific force),
/// which keeps its state as a `B`.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct CgFilter<const N: usize, const M: usize, B: Belief<N, M>> {
    settings: Settings,
    printed: bool,
    belief: B,
    dynamics: WheelDynamics,
    hold: InputHold,
    monitor: Monitor,
    pub(in crate::loader) evidence: Evidence,
    clock: TimeBase,
    windup: Windup,
    shared_slip: SharedSlip,
    quantisation: Quantisation,
    stuck: Stuck,
    disturbance: Disturbance,
    /// What it does to the wheels in this row.
    effect: Effect,
    inclinometer: Inclinometer,
    slope_error: SlopeError,
    manoeuvres: Manoeuvres,
    coupling: Coupling,
    curves: Curves,
    /// Somebody reports how the machine turns.
    turning_reported: bool,
    directions: Directions,
    /// Stiffness and radii are opened with the next change.
    reopens: bool,
    /// How long ago something changed that the load may explain [s].
    changed: f64,
    pub(in crate::loader) load: Load,
    /// The boom's motion is reported.
    boom_reported: bool,
    relearning: Relearning,
    /// Process noise of the next step beyond the usual, by state.
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    loosened: [f64; N],
    /// Force on the bucket tip measured over the last step [N].
    pub(in crate::loader) spade_force_x: f64,
    payload: Option<Payload>,
    /// What the lift pressure says of this row.
    weighed: Option<Weighed>,
    /// What the errors of weighed loads have left in the ratio, as a standard deviation.
    left_by_loads: f64,
    /// How long a wheel has spun, less half of the time in which all rolled [s].
    spun: f64,
    frozen: bool,
}

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// The filter before its first row; the settings must have been checked.
    pub(in crate::loader) fn new(settings: &Settings, method: Method) -> Self {
        let (machine, keys) = (&settings.machine, &settings.estimator);
        let dynamics = WheelDynamics {
            mass: machine.mass,
            wheel_radius: machine.wheel_radius,
            axle_inertia: machine.axle_inertia,
            wheelbase: machine.wheelbase,
            bucket_reach: machine.bucket_reach,
            rolling_resistance: machine.rolling_resistance,
            friction: settings.friction(),
            radius_load_sensitivity: if settings.real_tyre() {
                machine.radius_load_sensitivity
            } else {
                0.0
            },
            minimum_speed: keys.v_min,
            load_transfer: keys.load_transfer,
            tyres: Tyres::new(machine.stiffness_ratio, machine.stiffness_load_exponent),
        };
        let spread = Spread {
            alpha: keys.alpha,
            beta: keys.beta,
            kappa: keys.kappa,
        };
        let mut new = Self {
            settings: *settings,
            printed: method == Method::IsrUkfPrinted,
            belief: B::new([0.0; N], &[0.0; N], spread),
            dynamics,
            hold: InputHold::new(machine.mass),
            monitor: Monitor::default(),
            evidence: Evidence::new(M > 3),
            clock: TimeBase::default(),
            windup: Windup::default(),
            shared_slip: SharedSlip::default(),
            quantisation: Quantisation::default(),
            stuck: Stuck::default(),
            disturbance: Disturbance::default(),
            effect: Effect::default(),
            inclinometer: Inclinometer::default(),
            slope_error: SlopeError::default(),
            manoeuvres: Manoeuvres::default(),
            coupling: Coupling::default(),
            curves: Curves::default(),
            turning_reported: false,
            directions: Directions::default(),
            reopens: false,
            changed: f64::INFINITY,
            load: Load::default(),
            boom_reported: false,
            relearning: Relearning::new([settings.prior.slip_stiffness, settings.prior.cg_ratio]),
            loosened: [0.0; N],
            spade_force_x: 0.0,
            payload: None,
            weighed: None,
            left_by_loads: 0.0,
            spun: 0.0,
            frozen: false,
        };
        new.belief = B::new(new.prior_state(), &new.prior_std(), spread);
        new
    }

    /// The state \[v, w_f, w_r, K, h, lam, ..\].
    pub fn state(&self) -> &[f64; N] {
        self.belief.state()
    }

    /// Standard deviation of a state.
    pub fn std(&self, i: usize) -> f64 {
        self.belief.std(i)
    }

    /// Slip stiffness with what the slips share.
    pub(in crate::loader) fn slip_stiffness(&self) -> Quantity {
        let quantity = |value: f64, std: f64| Quantity { value, std };
        let prior = &self.settings.prior;
        let own = quantity(
            self.belief.state()[SLIP_STIFFNESS],
            self.std(SLIP_STIFFNESS),
        );
        let expected = quantity(prior.slip_stiffness, prior.slip_stiffness_std);
        let range = self.settings.bounds()[0];
        let std = self.shared_slip.std(own, expected, range.high - range.low);
        quantity(own.value, std)
    }

    pub(in crate::loader) fn last_time(&self) -> Option<f64> {
        self.clock.last()
    }

    pub(in crate::loader) fn payload(&self) -> Option<Payload> {
        self.payload
    }

    /// Tells the payload for the rows to come; one that is not finite is ignored.
    pub(in crate::loader) fn set_payload(&mut self, payload: Option<Payload>) {
        if payload.is_none_or(|p| p.is_valid()) {
            self.payload = payload;
        }
    }

    pub(in crate::loader) fn weighed(&self) -> Option<&Weighed> {
        self.weighed.as_ref()
    }

    /// Tells what the lift pressure says of the next row. Where it begins to, or ceases, height and ratio mean another machine:
    /// with its load or without.
    pub(in crate::loader) fn set_weighed(
        &mut self,
        weighed: Option<Weighed>,
        empty: Each<(f64, f64)>,
    ) {
        if weighed.is_some() != self.weighed.is_some() {
            let prior = &self.settings.prior;
            let centre = if weighed.is_some() {
                let height = empty.height.0;
                let usual = prior.cg_height_std / prior.cg_height * height;
                [
                    (height, empty.height.1.max(usual)),
                    (empty.ratio.0, empty.ratio.1.max(prior.cg_ratio_std)),
                ]
            } else {
                [
                    (prior.cg_height, prior.cg_height_std),
                    (prior.cg_ratio, prior.cg_ratio_std),
                ]
            };
            self.restore(centre);
            self.left_by_loads = 0.0;
        }
        self.weighed = weighed;
    }

    /// What the error of a weighed load has left in the ratio of the empty machine, as a standard deviation: what the slips showed of
    /// that one they showed under a load. Errors of many loads may have one cause, such as a lever, so none average out.
    pub(in crate::loader) fn left_by_loads(&self) -> f64 {
        self.left_by_loads
    }

    /// The row has informed the ratio, whose variance was `predicted`, under the present load: with the gain of its error.
    fn learn_under_load(&mut self, predicted: f64) {
        if let Some(weighed) = &self.weighed {
            let gain = (1.0 - self.belief.variance(CG_RATIO) / predicted).clamp(0.0, 1.0);
            let doubt = weighed.loading_std[0] / weighed.loading.share;
            self.left_by_loads += gain * (doubt - self.left_by_loads);
        }
    }

    /// Takes one plausible row.
    pub fn step(&mut self, mut sample: Sample) -> RowReport<M> {
        self.correct(&mut sample);
        let gap = self.settings.gap();
        let dt = match self.clock.tick(sample.time, gap.min(LONGEST_STEP)) {
            Tick::First => {
                self.level(&mut sample, 0.0);
                return self.first(&sample);
            }
            Tick::Later(dt) => dt,
            Tick::Refused => return RowReport::without_update(Status::Refused, self.frozen),
            Tick::SetBack => return self.set_back(&sample),
        };
        let at_work = self.settings.at_work();
        if at_work {
            let witness = self.witness(&sample);
            self.stuck.watch(&mut sample, &witness, dt);
        }
        self.level(&mut sample, dt);
        let sample = &sample;
        let midpoint = self.settings.estimator.inputs != Driven::Hold;
        let step = self.hold.advance(sample, midpoint, at_work);
        self.spade_force_x = step.inputs.spade_force_x;
        self.dynamics.mass = self.mass();
        let torque = step.inputs.front_torque + step.inputs.rear_torque;
        self.evidence
            .advance(dt, torque, self.free_acceleration(&step));
        let speed = self.belief.state()[SPEED];
        let force = torque / (self.dynamics.wheel_radius * self.dynamics.mass);
        self.shared_slip.see(speed, force, dt);
        self.evidence.receive(sample);
        self.evidence.stuck = self.stuck.first();
        self.boom_reported |= sample.boom_moving;
        self.turning_reported |= sample.articulation.is_some() || sample.yaw_rate.is_some();
        self.changed += dt;
        let slips = at_work && self.slips_far(sample);
        let rolls = self.belief.state()[SPEED].abs() > SPINS.1;
        self.spun += match (slips, rolls) {
            (true, _) => dt,
            (false, true) => -0.5 * dt,
            (false, false) => 0.0,
        };
        self.spun = self.spun.clamp(0.0, LONGEST_SPIN);
        // Wheels that were taken from a row that spun, or from an outlier, say nothing of the tyre: the next that roll are taken anew.
        let rolls_again = at_work && !slips && self.is_spinning();
        if slips && self.spun < LONGEST_SPIN || rolls_again {
            self.evidence.set_aside();
            return self.bridge_gap(sample, 0.0);
        }
        self.watch_slope(sample, dt);
        if at_work && !self.knows_its_load() {
            self.weigh(dt);
        }
        let at = [SPEED, SLIP_STIFFNESS].map(|i| self.belief.state()[i]);
        self.effect = self.disturbance.update(&self.dynamics, &step, at, dt);
        let known = self.knows_its_load() || !self.relearning.settled();
        if at_work && self.disturbance.load_stepped() && !known {
            // A load came or went that nobody reported, and was taken for another stiffness and other radii.
            self.changed = 0.0;
            self.reopens = true;
        }
        let fresh = self.settings.estimator.fresh;
        if dt > gap || at_work && self.evidence.torque_lost(fresh) {
            let away = if dt > gap { dt } else { 0.0 };
            return self.bridge_gap(sample, away);
        }
        let model = self.model(step.inputs, dt);
        let report = if self.printed {
            self.step_printed(sample, &model)
        } else {
            self.update(&model, sample, &step)
        };
        self.finish(report, sample, dt)
    }

    /// Makes torques and specific force true, and where the filter does not learn its bias, the slope.
    fn correct(&self, sample: &mut Sample) {
        let sensors = &self.settings.sensors;
        sample.front_torque = sample.front_torque.map(|t| t / sensors.front_torque_gain);
        sample.rear_torque = sample.rear_torque.map(|t| t / sensors.rear_torque_gain);
        let offset = sensors.acceleration_offset;
        sample.acceleration = sample.acceleration.map(|a| a - offset);
        if const { Layout::of(N) }.slope_bias.is_none() {
            sample.slope = sample.slope.map(|s| s - self.settings.prior.slope_bias);
        }
    }

    /// Makes the slope that of the road, a bias that the filter learns left in it.
    fn level(&mut self, sample: &mut Sample, dt: f64) {
        let bias = const { Layout::of(N) }
            .slope_bias
            .map_or(0.0, |_| self.settings.prior.slope_bias);
        sample.slope = self
            .inclinometer
            .road(&self.settings.sensors, bias, sample, dt);
    }

    /// The first row with a time starts the filter.
    fn first(&mut self, sample: &Sample) -> RowReport<M> {
        self.hold.advance(sample, false, false);
        self.evidence.receive(sample);
        self.spade_force_x = sample.spade_force_x.unwrap_or(0.0);
        let speed = sample.speed.unwrap_or(0.0);
        let rim = speed / self.dynamics.wheel_radius;
        let state = self.belief.state_mut();
        state[SPEED] = speed;
        state[FRONT_WHEEL] = sample.front_wheel_speed.unwrap_or(rim);
        state[REAR_WHEEL] = sample.rear_wheel_speed.unwrap_or(rim);
        RowReport::without_update(Status::First, false)
    }

    fn loading(&self) -> Loading {
        let (mass, wheelbase) = (self.settings.machine.mass, self.dynamics.wheelbase);
        let stated = self.payload.map(|p| p.loading(mass, wheelbase));
        let weighed = self.weighed.map(|w| w.loading);
        stated.or(weighed).unwrap_or(Loading::NONE)
    }

    /// Mass with its load [kg].
    fn mass(&self) -> f64 {
        let stated = self.payload.map(|p| self.settings.machine.mass + p.mass);
        let weighed = self.weighed.map(|w| w.mass);
        stated.or(weighed).unwrap_or(self.hold.mass)
    }

    /// Height and ratio are those of the empty machine: what it carries is reported or weighed.
    pub(in crate::loader) fn knows_its_load(&self) -> bool {
        self.payload.is_some() || self.weighed.is_some()
    }

    fn model(&self, inputs: Inputs, dt: f64) -> CgModel {
        CgModel {
            dynamics: self.dynamics,
            inputs,
            dt,
            integration: Integration::Implicit,
            substeps: u32::try_from(self.settings.estimator.substeps).unwrap_or(u32::MAX),
            loading: self.loading(),
        }
    }

    /// A wheel slips by more than a tyre that rolls.
    fn slips_far(&self, sample: &Sample) -> bool {
        let wheels = [sample.front_wheel_speed, sample.rear_wheel_speed];
        wheels.into_iter().flatten().any(|wheel| self.is_far(wheel))
    }

    /// The same of the filter's own wheels.
    fn is_spinning(&self) -> bool {
        let state = self.belief.state();
        self.is_far(state[FRONT_WHEEL]) || self.is_far(state[REAR_WHEEL])
    }

    fn is_far(&self, wheel: f64) -> bool {
        let speed = self.belief.state()[SPEED];
        let rim = self.dynamics.wheel_radius * wheel;
        let (slip, fastest) = ((rim - speed).abs(), rim.abs().max(speed.abs()));
        slip > SPINS.1 && slip > SPINS.0 * fastest
    }

    /// What the motion says of a row beside its own signals.
    fn witness(&self, sample: &Sample) -> Witness {
        let (state, sensors) = (self.belief.state(), &self.settings.sensors);
        let radius = self.dynamics.wheel_radius;
        let speed = sample.speed.unwrap_or(state[SPEED]);
        let front = sample.front_wheel_speed.unwrap_or(speed / radius);
        let rear = sample.rear_wheel_speed.unwrap_or(speed / radius);
        let fastest = speed.abs().max(radius * front.abs().max(rear.abs()));
        Witness {
            moving: fastest > self.settings.estimator.v_freeze,
            speeds: [0.5 * radius * (front + rear), rear, front],
            unexplained: self.disturbance.unexplained.abs() > UNEXPLAINED,
            std: [
                sensors.speed_std,
                sensors.wheel_speed_std,
                sensors.wheel_speed_std,
                0.0,
                0.0,
                sensors.slope_std,
                sensors.acceleration_std,
            ],
            patience: self.settings.estimator.fresh,
        }
    }

    /// Acceleration along the road, measured, or what the torques would give without slip [m/s^2].
    fn free_acceleration(&self, step: &StepInputs) -> Option<f64> {
        let slope = step.sine;
        if M > 3 {
            return step.acceleration.map(|a| a - GRAVITY * slope);
        }
        let radius = self.dynamics.wheel_radius;
        let spin = 2.0 * self.dynamics.axle_inertia / (radius * radius);
        let pull = (step.inputs.front_torque + step.inputs.rear_torque) / radius;
        let weight = self.dynamics.mass * GRAVITY;
        let rolling =
            self.dynamics.rolling_resistance * tanh(self.belief.state()[SPEED] / 0.05) * weight;
        Some(
            (pull - rolling - weight * slope - step.inputs.spade_force_x)
                / (self.dynamics.mass + spin),
        )
    }

    /// The consistent step with every rule.
    fn update(&mut self, model: &CgModel, sample: &Sample, step: &StepInputs) -> RowReport<M> {
        let mut ahead = self.belief.ahead(model);
        let before = self.before();
        let state = *B::state_ahead(&ahead);
        let conditions = self.conditions(&state, step, model.dt);
        let process_std = self.process_std(&conditions, sample.boom_moving, model.dt);
        let measured = measurements::<M>(sample, step.acceleration);
        self.quantisation
            .see([measured[FRONT_WHEEL], measured[REAR_WHEEL]]);
        let mut std = self.measurement_std(&state, &conditions, model);
        let at_work = self.settings.at_work();
        let disturbed = self.disturbed_slip(state[SPEED]);
        if at_work {
            for i in [FRONT_WHEEL, REAR_WHEEL] {
                std[i] = sqrt(std[i] * std[i] + disturbed * disturbed);
            }
        }
        let mut expected = self.belief.predict(&mut ahead, model, &process_std);
        let predicted = B::measurement(&expected);
        let mut innovation: [f64; M] = core::array::from_fn(|j| measured[j] - predicted[j]);
        if at_work {
            let at = [state[SLIP_STIFFNESS], state[CG_RATIO]];
            let windup = self.windup.wheel_speeds(
                self.settings.machine.relaxation_length,
                &model.dynamics,
                &model.inputs,
                model.dt,
                at,
            );
            // Nobody says on which body the speed is measured: half of it each.
            let closing = 0.5 * self.effect.closing / self.dynamics.wheel_radius;
            innovation[FRONT_WHEEL] += closing - windup[0];
            innovation[REAR_WHEEL] -= closing + windup[1];
        }
        let mut noise = [0.0; 2];
        if at_work {
            let keys = &self.settings.estimator;
            noise = self
                .monitor
                .row_variance(keys)
                .map(|row| disturbed * disturbed + row);
            for (wheel, j) in [FRONT_WHEEL, REAR_WHEEL].into_iter().enumerate() {
                let predicted = B::measurement_std(&expected, j);
                let more = predicted * predicted + disturbed * disturbed;
                std[j] *= self.monitor.far(keys, wheel, innovation[j], more);
            }
        }
        let gated = self.gates(sample, &innovation, &mut std, &expected);
        let accepted = gated.accepted;
        let both = accepted[FRONT_WHEEL] && accepted[REAR_WHEEL] && !conditions.frozen;
        if at_work && both {
            let seen = Seen {
                before,
                state,
                innovation,
                std,
                noise,
            };
            self.learn_from_wheels(&seen, &measured, &expected, &process_std, model, step.sine);
        }
        let nis = self
            .belief
            .update(&mut expected, &innovation, &std, &accepted);
        self.learn_under_load(
            before.ratio_variance + process_std[CG_RATIO] * process_std[CG_RATIO],
        );
        self.clamp();
        self.loosen(&before, &process_std, state[SPEED], model.dt);
        RowReport {
            nis,
            frozen: conditions.frozen,
            ..gated
        }
    }

    /// What a row in which both wheels count shows beside the state: fluctuation of the slips, the leg, curves, the centre drive.
    fn learn_from_wheels(
        &mut self,
        seen: &Seen<N, M>,
        measured: &[f64; M],
        expected: &B::Expected,
        process_std: &[f64; N],
        model: &CgModel,
        sine: f64,
    ) {
        let Seen {
            before,
            state,
            innovation,
            std,
            noise,
        } = *seen;
        let wheel = |i: usize| (innovation[i], B::measurement_std(expected, i));
        let wheels = [wheel(FRONT_WHEEL), wheel(REAR_WHEEL)];
        self.monitor.see(&self.settings.estimator, wheels, model.dt);
        let slip = self.slip(&before, &state, &innovation, &std, model, sine);
        if self.manoeuvres.take(&slip, before.ratio_variance, model.dt) && self.relearning.settled()
        {
            // A leg that lies far off reopens height and ratio.
            self.changed = 0.0;
        }
        if !self.turning_reported {
            let predicted = B::difference_variance(expected, [FRONT_WHEEL, REAR_WHEEL]);
            self.watch_curves(
                &slip,
                state[SPEED],
                [predicted, noise[0] + noise[1]],
                model.dt,
            );
        }
        self.compare_axles(
            measured,
            &innovation,
            expected,
            process_std,
            noise,
            model.dt,
        );
    }

    fn before(&self) -> Before {
        let sensitivity = const { Layout::of(N) }.load_sensitivity;
        Before {
            speed: self.belief.state()[SPEED],
            ratio_variance: self.belief.variance(CG_RATIO),
            sensitivity: sensitivity.map_or((0.0, 0.0), |i| {
                (self.belief.state()[i], self.belief.variance(i))
            }),
        }
    }

    /// Under which a row is taken.
    fn conditions(&mut self, state: &[f64; N], step: &StepInputs, dt: f64) -> Conditions {
        let place = const { Layout::of(N) }.spade_force;
        let unknown_force = place.map_or(0.0, |i| state[i]);
        let force = step.inputs.spade_force_x + unknown_force;
        let mut conditions = self
            .monitor
            .conditions(&self.settings, state[SPEED], force, dt);
        let other_mass = self.settings.at_work() && self.disturbance.lighter() != 0.0;
        if self.weighed.is_some_and(|w| w.open) || other_mass {
            // Neither the mass nor where it sits is known.
            (conditions.frozen, conditions.weak_wheels) = (true, true);
        }
        conditions
    }

    /// What turns and forces that no model holds do to a wheel's speed [rad/s].
    fn disturbed_slip(&self, speed: f64) -> f64 {
        let effect = &self.effect;
        let slip = sqrt(effect.turn * effect.turn + effect.force * effect.force);
        slip * speed.abs() / self.dynamics.wheel_radius
    }

    /// Which measurements are used.
    fn gates(
        &self,
        sample: &Sample,
        innovation: &[f64; M],
        std: &mut [f64; M],
        expected: &B::Expected,
    ) -> RowReport<M> {
        let mut report = RowReport::without_update(Status::Updated, false);
        for j in 0..M {
            (report.accepted[j], report.deweighted[j]) =
                gate(&self.settings, innovation[j], &mut std[j], || {
                    B::measurement_std(expected, j)
                });
        }
        if self.settings.at_work() {
            // A held torque is of another time, and a wheel without its torque tells nothing.
            let torques = [sample.front_torque, sample.rear_torque];
            let driven = torques.iter().all(|torque| torque.is_some());
            let (braking, accepted) = (self.effect.braking, &mut report.accepted);
            report.set_aside = driven && braking && accepted[FRONT_WHEEL] && accepted[REAR_WHEEL];
            accepted[FRONT_WHEEL] &= driven && !braking;
            accepted[REAR_WHEEL] &= driven && !braking;
        }
        report
    }

    /// What the next step may change more than usual.
    fn loosen(&mut self, before: &Before, process_std: &[f64; N], speed: f64, dt: f64) {
        let layout = const { Layout::of(N) };
        self.loosened = self.loosening();
        let slowest = self.settings.estimator.v_freeze;
        let driven = self.directions.drive(speed, slowest, dt);
        if let Some(i) = layout.load_sensitivity {
            match driven {
                BothDirections::NotYet | BothDirections::LongAgo => {
                    self.consider(i, before.sensitivity, process_std[i])
                }
                BothDirections::JustNow => self.open_sensitivity(i),
                BothDirections::Recently => {}
            }
        }
        if self.changed == 0.0 {
            let prior = &self.settings.prior;
            self.loosened[CG_HEIGHT] = prior.cg_height_std;
            self.loosened[CG_RATIO] = prior.cg_ratio_std;
            if core::mem::take(&mut self.reopens) {
                self.loosened[SLIP_STIFFNESS] = prior.slip_stiffness_std;
                for i in layout.radii.into_iter().flatten() {
                    self.loosened[i] = prior.radius_std;
                }
            }
        }
    }

    /// State `i` keeps its value and its variance of before the row, with its process noise; what the row would have shown of it
    /// comes back with the next step's. What the row tells of the others takes its variance into account.
    fn consider(&mut self, i: usize, (value, variance): (f64, f64), process_std: f64) {
        self.belief.state_mut()[i] = value;
        let lost = variance + process_std * process_std - self.belief.variance(i);
        self.loosened[i] = sqrt(lost.max(0.0));
    }

    /// The load sensitivity can be learnt from now on: it may be what tyres are, the ratio what goes with it, and the height what
    /// leaves its product with the sensitivity, which moves the radii, as it is. One that is known exactly opens nothing.
    fn open_sensitivity(&mut self, i: usize) {
        let stated = self.settings.load_sensitivity_std();
        if stated == 0.0 {
            return;
        }
        let std = stated.max(LEARNT_STD);
        let state = self.belief.state();
        let ratio = RATIO_PER_SENSITIVITY * std * state[CG_RATIO];
        let height = (state[CG_HEIGHT] * std / state[i]).abs();
        let height = self.settings.prior.cg_height_std.min(height);
        for (i, std) in [(i, std), (CG_RATIO, ratio), (CG_HEIGHT, height)] {
            self.loosened[i] = sqrt(self.loosened[i] * self.loosened[i] + std * std);
        }
    }

    /// Standard deviation of the load sensitivity of the rolling radii that the covariance does not hold.
    pub(in crate::loader) fn sensitivity_left(&self) -> f64 {
        let before = self.settings.load_sensitivity_std();
        match const { Layout::of(N) }.load_sensitivity {
            Some(_) => self.directions.left(before, self.manoeuvres.ratio()),
            None => before,
        }
    }

    /// Wheels, specific force and slope of a row show how far the slope is to be believed.
    fn watch_slope(&mut self, sample: &Sample, dt: f64) {
        let wheels = sample.front_wheel_speed.zip(sample.rear_wheel_speed);
        let road = sample.acceleration.zip(sample.slope);
        if let (Some((front, rear)), Some((acceleration, slope))) = (wheels, road) {
            let rim_speed = 0.5 * self.dynamics.wheel_radius * (front + rear);
            self.slope_error.see(rim_speed, acceleration, slope, dt);
        }
    }

    /// What a row shows of the difference of the rim speeds.
    fn slip(
        &self,
        before: &Before,
        state: &[f64; N],
        innovation: &[f64; M],
        std: &[f64; M],
        model: &CgModel,
        sine: f64,
    ) -> Slip {
        let (machine, inputs) = (&self.dynamics, &model.inputs);
        let radius = machine.wheel_radius;
        let [speed, stiffness, height, ratio] =
            [SPEED, SLIP_STIFFNESS, CG_HEIGHT, CG_RATIO].map(|i| state[i]);
        let acceleration = (speed - before.speed) / model.dt;
        let lift = acceleration + GRAVITY * sine;
        let front = (ratio - height * lift / (GRAVITY * machine.wheelbase)).clamp(0.1, 0.9);
        let per_weight = 1.0 / (radius * stiffness * machine.mass * GRAVITY);
        let slip = |torque: f64, share: f64| torque * per_weight / (share * share);
        let moved = slip(inputs.front_torque, front) + slip(inputs.rear_torque, 1.0 - front);
        Slip {
            innovation: radius * (innovation[FRONT_WHEEL] - innovation[REAR_WHEEL]),
            variance: radius
                * radius
                * (std[FRONT_WHEEL] * std[FRONT_WHEEL] + std[REAR_WHEEL] * std[REAR_WHEEL]),
            by_share: -speed.abs() * moved,
            driving: (inputs.front_torque + inputs.rear_torque) * speed > 0.0,
        }
    }

    /// A row of a machine of which nobody says how it turns; `variances` are those of prediction and row [rad^2/s^2].
    fn watch_curves(&mut self, slip: &Slip, speed: f64, variances: [f64; 2], dt: f64) {
        let per_speed = 1.0 / speed.abs().max(self.settings.estimator.v_freeze);
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
        let Some(filter) = self.belief.sigma_points() else {
            return RowReport::without_update(Status::Diverged, false);
        };
        let printed = filter.step_printed(model, &process_std, &std, |predicted| {
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
            set_aside: false,
        }
    }
}

/// The measurements of a row; NaN where missing.
fn measurements<const M: usize>(sample: &Sample, acceleration: Option<f64>) -> [f64; M] {
    let all = [
        sample.speed,
        sample.front_wheel_speed,
        sample.rear_wheel_speed,
        acceleration,
    ];
    core::array::from_fn(|j| all[j].unwrap_or(f64::NAN))
}
