//! The estimator on a fixed number of states: the processing of one row.
//!
//! | file | idea |
//! |---|---|
//! | `belief` | state and uncertainty: sigma points, or the model's tangent |
//! | `prior` | state and uncertainty before the first row |
//! | `signals` | correction of a row's signals |
//! | `spin` | wheels that spin |
//! | `load` | load of the machine |
//! | `noise` | process and measurement noise of a step |
//! | `update` | the step with all protections |
//! | `gate` | which measurements are used |
//! | `wheels` | what is learnt from wheels beside the state |
//! | `loosen` | additional process noise of the next step |
//! | `printed` | the step as the paper prints it |
//! | `recovery` | starts, gaps, restarts, bounds |
//! | `doubt` | errors beside the covariance |
//! | `report` | result of a row |

use super::Method;
use super::doubts::axles::Axles;
use super::doubts::constancy::Constancy;
use super::doubts::coupling::Coupling;
use super::doubts::curves::Curves;
use super::doubts::digging_force::Balance;
use super::doubts::directions::Directions;
use super::doubts::disturbance::{Disturbance, Effect};
use super::doubts::manoeuvres::Manoeuvres;
use super::doubts::relearning::Relearning;
use super::doubts::shared_slip::SharedSlip;
use super::estimate::Status;
use super::input::inclinometer::Inclinometer;
use super::input::inputs::{InputHold, StepInputs};
use super::input::steady::Steady;
use super::input::stuck::Stuck;
use super::layout::{CG_RATIO, Layout, SLIP_STIFFNESS, SPEED};
use super::load::known_load::KnownLoad;
use super::load::mass_step::Load;
use super::measurements::conditions::Digging;
use super::measurements::quantisation::Quantisation;
use super::measurements::slip_noise::SlipNoise;
use super::measurements::slope::SlopeError;
use super::measurements::wheel_lag::WheelLag;
use super::measurements::wheel_noise::WheelNoise;
use super::measurements::windup::Windup;
use super::physics::cg_model::CgModel;
use super::physics::wheel_dynamics::{Inputs, WheelDynamics};
use super::sample::Sample;
use super::settings::{Inputs as Driven, Settings};
use super::verdict::Evidence;
use crate::Quantity;
use crate::math::sqrt;
use crate::sigma_points::Spread;
use crate::time_base::{Tick, TimeBase};

mod belief;
mod doubt;
mod gate;
mod load;
mod loosen;
mod noise;
mod printed;
mod prior;
mod recovery;
mod report;
mod signals;
mod spin;
mod update;
mod wheels;

pub(super) use belief::Belief;
pub(super) use report::RowReport;
use spin::Spin;
pub use spin::wheel_spins;

/// Longest step between rows [s]. A longer one is a jump, whatever the stated gap.
const LONGEST_STEP: f64 = 1.0;

/// The filter with `N` states (6, 8, 9, 10 or 12, see [`super::physics::cg_model`]), `M` measurements (3, or 4 with the specific
/// force), and a belief of type `B`.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct CgFilter<const N: usize, const M: usize, B: Belief<N, M>> {
    printed: bool,
    belief: B,
    dynamics: WheelDynamics,
    hold: InputHold,
    digging: Digging,
    wheel_noise: WheelNoise,
    wheel_lag: WheelLag,
    /// Of both wheels against the speed, and of front against rear wheel.
    slip_noise: [SlipNoise; 2],
    pub(in crate::loader) evidence: Evidence,
    clock: TimeBase,
    windup: Windup,
    shared_slip: SharedSlip,
    axles: Axles,
    quantisation: Quantisation,
    steady: Steady,
    stuck: Stuck,
    disturbance: Disturbance,
    /// Effect of the disturbances on the wheels in this row.
    effect: Effect,
    inclinometer: Inclinometer,
    slope_error: SlopeError,
    manoeuvres: Manoeuvres,
    constancy: Constancy,
    coupling: Coupling,
    curves: Curves,
    /// Articulation or yaw rate is reported.
    turning_reported: bool,
    directions: Directions,
    /// The next change opens stiffness and radii as well.
    reopens: bool,
    /// Time since a change that the load may explain [s].
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
    /// Force of the torques on the road [N].
    pull: f64,
    pub(in crate::loader) known_load: KnownLoad,
    spin: Spin,
    frozen: bool,
}

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// The filter before its first row; the settings must have been checked.
    pub(in crate::loader) fn new(settings: &Settings, method: Method) -> Self {
        let keys = &settings.estimator;
        let spread = Spread {
            alpha: keys.alpha,
            beta: keys.beta,
            kappa: keys.kappa,
        };
        Self {
            printed: method == Method::IsrUkfPrinted,
            belief: B::new(
                Self::prior_state(settings),
                &Self::prior_std(settings),
                spread,
            ),
            dynamics: WheelDynamics::of(settings),
            hold: InputHold::new(settings.machine.mass),
            digging: Digging::default(),
            wheel_noise: WheelNoise::default(),
            wheel_lag: Self::wheel_lag(settings),
            slip_noise: [SlipNoise::default(); 2],
            evidence: Evidence::new(M > 3),
            clock: TimeBase::default(),
            windup: Windup::default(),
            shared_slip: SharedSlip::default(),
            axles: Axles::default(),
            quantisation: Quantisation::default(),
            steady: Steady::default(),
            stuck: Stuck::default(),
            disturbance: Disturbance::default(),
            effect: Effect::default(),
            inclinometer: Inclinometer::default(),
            slope_error: SlopeError::default(),
            manoeuvres: Manoeuvres::default(),
            constancy: Constancy::default(),
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
            pull: 0.0,
            known_load: KnownLoad::default(),
            spin: Spin::default(),
            frozen: false,
        }
    }

    /// Prior of the lag between both wheel speeds.
    fn wheel_lag(settings: &Settings) -> WheelLag {
        let prior = &settings.prior;
        let quantity = |value, std| Quantity { value, std };
        WheelLag::new(
            quantity(prior.slip_stiffness, prior.slip_stiffness_std),
            quantity(prior.cg_ratio, prior.cg_ratio_std),
            prior.radius_std,
        )
    }

    /// The state \[v, w_f, w_r, K, h, lam, ..\].
    pub fn state(&self) -> &[f64; N] {
        self.belief.state()
    }

    /// Standard deviation of a state.
    pub fn std(&self, i: usize) -> f64 {
        self.belief.std(i)
    }

    /// Slip stiffness, with errors common to all slips in its deviation.
    pub(in crate::loader) fn slip_stiffness(&self, settings: &Settings) -> Quantity {
        let quantity = |value: f64, std: f64| Quantity { value, std };
        let prior = &settings.prior;
        let own = quantity(self.state()[SLIP_STIFFNESS], self.std(SLIP_STIFFNESS));
        let expected = quantity(prior.slip_stiffness, prior.slip_stiffness_std);
        let range = settings.bounds()[0];
        let lag = self.wheel_lag.lag().value;
        let width = range.high - range.low;
        let std = self.shared_slip.std(own, expected, width, lag);
        quantity(own.value, std)
    }

    /// Force on the bucket along the road, with other causes of such a force in its deviation.
    pub(in crate::loader) fn digging_force(&self, settings: &Settings) -> Option<Quantity> {
        let i = const { Layout::of(N) }.spade_force?;
        let (unknown, own) = (self.state()[i], self.belief.variance(i));
        let balance = Balance {
            machine: &self.dynamics,
            reach: self.reach(settings),
            speed: self.state()[SPEED],
            pull: self.pull,
            turn: self.effect.turn,
            unreported: self.unreported_mass(),
            braked: self.effect.braked,
            brakes: self.effect.braking,
        };
        let std = if settings.at_work() {
            balance.std(unknown, own)
        } else {
            sqrt(own.max(0.0))
        };
        let value = self.spade_force_x + unknown;
        Some(Quantity { value, std })
    }

    /// Standard deviation of the ratio: that of the filter, or a larger one where only one axle pulls.
    fn ratio_std(&self, settings: &Settings, expected_std: f64) -> f64 {
        let prior = &settings.prior;
        let ratio = Quantity {
            value: self.state()[CG_RATIO],
            std: expected_std,
        };
        let by_slips = self
            .axles
            .ratio_std(ratio, prior.slip_stiffness_std / prior.slip_stiffness);
        self.std(CG_RATIO).max(by_slips)
    }

    pub(in crate::loader) fn last_time(&self) -> Option<f64> {
        self.clock.last()
    }

    /// Whether the clock will refuse a row of this time.
    pub(in crate::loader) fn refuses(&self, settings: &Settings, time: f64) -> bool {
        self.clock.refuses(time, settings.gap().min(LONGEST_STEP))
    }

    /// Processes one plausible row, and removes from it what is no measurement.
    pub fn step(&mut self, settings: &Settings, sample: &mut Sample) -> RowReport<M> {
        Self::correct(settings, sample);
        let gap = settings.gap();
        let dt = match self.clock.tick(sample.time, gap.min(LONGEST_STEP)) {
            Tick::First => {
                self.level(settings, sample, 0.0);
                return self.first(settings, sample);
            }
            Tick::Later(dt) => dt,
            Tick::Refused => return RowReport::without_update(Status::Refused, self.frozen),
            Tick::SetBack => return self.set_back(settings, sample),
        };
        let at_work = settings.at_work();
        if at_work {
            self.drop_leaps(&settings.machine, sample, dt);
            self.drop_stuck(settings, sample, dt);
        }
        self.level(settings, sample, dt);
        let sample = &*sample;
        let midpoint = settings.estimator.inputs != Driven::Hold;
        let step = self.hold.advance(sample, midpoint, at_work);
        self.note(settings, sample, &step, dt);
        if at_work && self.spins(sample, dt) {
            self.evidence.set_aside();
            return self.bridge_gap(settings, sample, 0.0);
        }
        self.watch_slope(sample, dt);
        self.watch_load(settings, &step, dt);
        let fresh = settings.estimator.fresh;
        if dt > gap || at_work && self.evidence.torque_lost(fresh) {
            let away = if dt > gap { dt } else { 0.0 };
            return self.bridge_gap(settings, sample, away);
        }
        let model = self.model(settings, step.inputs, dt);
        let report = if self.printed {
            self.step_printed(settings, sample, &model)
        } else {
            self.update(settings, &model, sample, &step)
        };
        self.finish(settings, report, sample, dt)
    }

    /// Advances the time, and takes the inputs of a row and the presence of its signals.
    fn note(&mut self, settings: &Settings, sample: &Sample, step: &StepInputs, dt: f64) {
        let inputs = &step.inputs;
        self.spade_force_x = inputs.spade_force_x;
        self.dynamics.mass = self.mass(settings);
        let torque = inputs.front_torque + inputs.rear_torque;
        let speed = self.belief.state()[SPEED];
        // Along the road: measured, or that of the torques without slip.
        let acceleration = if M > 3 {
            step.acceleration
                .map(|a| a - self.dynamics.gravity * step.sine)
        } else {
            Some(self.dynamics.free_acceleration(inputs, speed, step.sine))
        };
        self.evidence.advance(dt, torque, acceleration);
        self.pull = torque / self.dynamics.wheel_radius;
        self.shared_slip
            .see(speed, self.pull / self.dynamics.mass, dt);
        self.axles.see(self.pulled_slips(inputs), speed, dt);
        self.evidence.receive(sample);
        self.evidence.stuck = self.stuck.first();
        self.boom_reported |= sample.boom_moving;
        self.turning_reported |= sample.articulation.is_some() || sample.yaw_rate.is_some();
        self.changed += dt;
    }

    /// Slips of the axles by these torques, to first order.
    fn pulled_slips(&self, inputs: &Inputs) -> [f64; 2] {
        let state = self.belief.state();
        let (ratio, machine) = (state[CG_RATIO], &self.dynamics);
        let weight = machine.wheel_radius * machine.mass * machine.gravity;
        let per_torque = 1.0 / (weight * state[SLIP_STIFFNESS] * ratio * (1.0 - ratio));
        [
            inputs.front_torque * per_torque * (1.0 - ratio),
            inputs.rear_torque * per_torque * ratio,
        ]
    }

    /// Updates the load from a mass that steps, or from the motion.
    fn watch_load(&mut self, settings: &Settings, step: &StepInputs, dt: f64) {
        let at_work = settings.at_work();
        if at_work && !self.known_load.is_some() {
            self.weigh(settings, dt);
        }
        let state = self.belief.state();
        let force = const { Layout::of(N) }
            .spade_force
            .map_or(0.0, |i| state[i]);
        let at = [state[SPEED], state[SLIP_STIFFNESS], force];
        self.effect = self.disturbance.update(&self.dynamics, step, at, dt);
        let known = self.known_load.is_some() || !self.relearning.settled();
        if at_work && self.disturbance.mass.load_stepped() && !known {
            // An unreported load came or went, and was learnt as another stiffness and other radii.
            self.changed = 0.0;
            self.reopens = true;
        }
        if self.disturbance.mass.load_stepped() {
            self.constancy = Constancy::default();
        }
        let empty = step.states_mass && !self.known_load.is_some() && self.load.is_empty();
        if at_work && empty && !self.frozen && self.relearning.settled() {
            let ratio = Quantity {
                value: self.state()[CG_RATIO],
                std: self.std(CG_RATIO),
            };
            self.constancy
                .see(ratio, settings.estimator.cg_ratio_floor, dt);
        }
    }

    fn model(&self, settings: &Settings, inputs: Inputs, dt: f64) -> CgModel {
        CgModel {
            dynamics: self.dynamics,
            inputs,
            dt,
            substeps: u32::try_from(settings.estimator.substeps).unwrap_or(u32::MAX),
            loading: self.loading(settings),
        }
    }
}
