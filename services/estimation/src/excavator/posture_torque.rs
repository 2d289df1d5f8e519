//! Mode D: torque and posture. One filter, a mixture with a drop model, or the default: two filters
//! side by side.
//!
//! # The default (`auto`)
//!
//! Filter 1 believes in a constant payload until the bucket opens or an alarm is raised; filter 2
//! always lets it move. The payload enters the motion only through d(g w)/dt, which nearly
//! vanishes in a dump while braking: prior knowledge must carry the estimate there, so while the
//! bucket opens by rho [rad/s] the payload leaves as `m' = rho (u - 1.4 m)` with a free u. The
//! interval widens with the opening, before the material moves. What no bucket angle announces,
//! the comparison of the two filters and the sums of filter 1's innovations find.

use super::consider::Consider;
use super::drive::Drive;
use super::payload::{Change, Model, Outcome, PayloadFilter};
use super::settings::{Settings, Variant};
use super::standstill::Phase;
use super::state::State;
use crate::math::{exp, ln, sqrt};

/// Ticks over which the bucket's rate is taken, and for which an opening lasts (0.10 s).
const OPENING: usize = 10;
/// Ticks of change mode after an alarm (0.30 s).
const CHANGE: u32 = 30;
/// Free change of payload during an opening of an empty or unknown bucket [kg/rad] decays in [s].
const OPENING_TIME: f64 = 0.5;
const CHANGE_TIME: f64 = 0.3;

/// Mode D in any variant.
#[derive(Debug, Clone)]
pub(super) enum PostureTorque {
    /// One filter.
    Plain(Model, PayloadFilter),
    /// Mixture with a drop model.
    Drop(DropMixture),
    /// Two filters side by side.
    Auto(ChangingPayload),
}

impl PostureTorque {
    pub(super) fn new(settings: &Settings) -> Self {
        match settings.estimator.variant {
            Variant::Auto => Self::Auto(ChangingPayload::new(settings)),
            Variant::Drop => Self::Drop(DropMixture::new(settings)),
            variant => {
                let model = Model::new(settings, variant == Variant::Known);
                Self::Plain(model, PayloadFilter::new(&model))
            }
        }
    }

    /// One tick; `reopen` after a long stand.
    pub(super) fn step(&mut self, drive: &Drive, phase: Phase, reopen: bool) -> State {
        match self {
            Self::Plain(model, filter) => {
                if reopen {
                    filter.reopen(model);
                }
                let outcome = if phase == Phase::Moving {
                    filter.step(model, drive, Change::default())
                } else {
                    filter.rest(model, drive, phase);
                    Outcome::default()
                };
                state(filter, drive, &outcome, filter.payload().1, false)
            }
            Self::Drop(mixture) => mixture.step(drive, phase, reopen),
            Self::Auto(auto) => auto.step(drive, phase, reopen),
        }
    }

    /// Whether the filters are still sound.
    pub(super) fn is_sound(&self) -> bool {
        match self {
            Self::Plain(_, filter) => filter.is_sound(),
            Self::Drop(mixture) => mixture.filters.iter().all(PayloadFilter::is_sound),
            Self::Auto(auto) => auto.constant.is_sound() && auto.moving.is_sound(),
        }
    }
}

/// Common reading of a filter.
fn state(
    filter: &PayloadFilter,
    drive: &Drive,
    outcome: &Outcome,
    payload_variance: f64,
    changing: bool,
) -> State {
    let g = drive.now.per_payload;
    let doubt = filter.doubt.of(1);
    let payload_std = sqrt(payload_variance.max(0.0) + doubt * doubt);
    State {
        inertia: drive.now.with_payload(filter.x[1]),
        inertia_std: g * payload_std,
        payload: Some((filter.x[1], payload_std)),
        damping: Some((filter.x[3], sqrt(filter.p[(3, 3)].max(0.0)))),
        offset: Some((filter.x[2], sqrt(filter.p[(2, 2)].max(0.0)))),
        velocity: filter.x[0],
        acceleration: outcome.acceleration,
        nis: outcome.innovation.nis(),
        changing,
        ..State::default()
    }
}

/// Two copies of the filter, the second with a payload that may drop; standard mixing.
#[derive(Debug, Clone)]
pub(super) struct DropMixture {
    models: [Model; 2],
    filters: [PayloadFilter; 2],
    probability: [f64; 2],
    started: bool,
}

/// Probability per tick of going from model i to model j.
const TRANSITION: [[f64; 2]; 2] = [[0.998, 0.002], [0.03, 0.97]];

impl DropMixture {
    fn new(settings: &Settings) -> Self {
        let model = Model::new(settings, false);
        let filter = PayloadFilter::new(&model);
        let kilogram = settings.geometry.payload_scale();
        let drop = settings.estimator.drop_q_m * kilogram * kilogram;
        let drop = model.with_payload_variance_rate(drop);
        Self {
            models: [model, drop],
            filters: [filter.clone(), filter],
            probability: [0.5; 2],
            started: false,
        }
    }

    fn step(&mut self, drive: &Drive, phase: Phase, reopen: bool) -> State {
        if reopen {
            for (filter, model) in self.filters.iter_mut().zip(&self.models) {
                filter.reopen(model);
            }
        }
        let mut outcome = Outcome::default();
        if phase == Phase::Moving {
            if self.started {
                self.mix();
            }
            outcome = self.advance(drive);
        } else {
            for filter in &mut self.filters {
                filter.rest(&self.models[0], drive, phase);
            }
        }
        self.started = true;
        let mut mean = merge(&self.filters, self.probability);
        mean.limit(&self.models[0]);
        let mut state = state(&mean, drive, &outcome, mean.payload().1, false);
        state.drop_probability = self.probability[1];
        state
    }

    fn mix(&mut self) {
        let mu = self.probability;
        let c: [f64; 2] =
            core::array::from_fn(|j| TRANSITION[0][j] * mu[0] + TRANSITION[1][j] * mu[1]);
        self.filters = core::array::from_fn(|j| {
            merge(
                &self.filters,
                core::array::from_fn(|i| TRANSITION[i][j] * mu[i] / c[j]),
            )
        });
        self.probability = c;
    }

    fn advance(&mut self, drive: &Drive) -> Outcome {
        let mut outcomes = [Outcome::default(); 2];
        for (j, slot) in outcomes.iter_mut().enumerate() {
            let outcome = self.filters[j].step(&self.models[j], drive, Change::default());
            let likelihood = if drive.velocity.is_some() {
                let nis = outcome.innovation.value * outcome.innovation.value / outcome.gated;
                exp(-0.5 * nis.min(100.0)) / sqrt(outcome.gated)
            } else {
                1.0
            };
            self.probability[j] = self.probability[j] * likelihood + 1e-12;
            *slot = outcome;
        }
        let sum = self.probability[0] + self.probability[1];
        self.probability = self.probability.map(|mu| mu / sum);
        outcomes[usize::from(self.probability[1] > 0.5)]
    }
}

/// Mean and covariance of a mixture, with the spread of the means.
fn merge(filters: &[PayloadFilter; 2], weights: [f64; 2]) -> PayloadFilter {
    let x = filters[0].x * weights[0] + filters[1].x * weights[1];
    let spread = |i: usize| {
        let d = filters[i].x - x;
        (filters[i].p + d * d.transpose()) * weights[i]
    };
    PayloadFilter {
        x,
        p: spread(0) + spread(1),
        doubt: Consider::mix(&filters[0].doubt, &filters[1].doubt, weights),
    }
}

/// The two filters side by side, the bucket's opening and the alarm.
#[derive(Debug, Clone)]
pub(super) struct ChangingPayload {
    /// Largest free change during an opening, free change after an alarm [kg/rad, kg/s].
    opening_change_max: f64,
    change_rate_std: f64,
    opening_decay: f64,
    change_threshold: f64,
    /// A kilogram of the reference machine, on this one.
    kilogram: f64,
    model: Model,
    /// Filter 1: constant payload unless something says otherwise.
    constant: PayloadFilter,
    /// Filter 2: the payload always moves.
    moving: PayloadFilter,
    opening: Opening,
    /// Ticks of change mode left (hc).
    change: u32,
    /// Filter 1 was allowed to move at the tick before (actp).
    active: bool,
    /// Ticks in a row at which the filters disagree (cz).
    disagree: u32,
    up: f64,
    down: f64,
    /// Mean normalised innovation squared of filter 1 (n2).
    noise: f64,
    /// Variance of the payload as last reported [kg^2].
    variance: f64,
}

/// Bucket opening: its rate, and for how long it still counts.
#[derive(Debug, Clone)]
struct Opening {
    ring: [(f64, f64); OPENING],
    count: usize,
    threshold: f64,
    left: u32,
}

impl Opening {
    /// Rate of opening, 0 while the bucket does not open (rho) [rad/s].
    fn step(&mut self, drive: &Drive) -> f64 {
        let slot = self.count % OPENING;
        let (then, angle) = self.ring[slot];
        let rate = if self.count >= OPENING {
            (drive.bucket - angle) / (drive.time - then)
        } else {
            0.0
        };
        self.ring[slot] = (drive.time, drive.bucket);
        self.count += 1;
        self.left = if rate > self.threshold {
            OPENING as u32
        } else {
            self.left.saturating_sub(1)
        };
        if self.left > 0 { rate.max(0.0) } else { 0.0 }
    }
}

impl ChangingPayload {
    fn new(settings: &Settings) -> Self {
        let model = Model::new(settings, false);
        let constant = PayloadFilter::new(&model);
        let mut moving = constant.clone();
        let e = &settings.estimator;
        let kilogram = settings.geometry.payload_scale();
        let change_rate_std = e.change_rate_std * kilogram;
        moving.restart_drive(change_rate_std * change_rate_std);
        Self {
            opening_change_max: e.opening_change_max * kilogram,
            change_rate_std,
            opening_decay: e.opening_decay,
            change_threshold: e.change_threshold,
            kilogram,
            model,
            constant,
            moving,
            opening: Opening {
                ring: [(0.0, 0.0); OPENING],
                count: 0,
                threshold: e.opening_rate,
                left: 0,
            },
            change: 0,
            active: false,
            disagree: 0,
            up: 0.0,
            down: 0.0,
            noise: 1.0,
            variance: 0.0,
        }
    }

    fn step(&mut self, drive: &Drive, phase: Phase, reopen: bool) -> State {
        let rho = self.opening.step(drive);
        if reopen {
            self.constant.reopen(&self.model);
            self.moving.reopen(&self.model);
        }
        if phase != Phase::Moving {
            return self.rest(drive, phase);
        }
        let change_mode = self.change > 0;
        self.change = self.change.saturating_sub(1);
        let active = self.opening.left > 0 || change_mode;
        let outcome = self.advance(drive, rho, change_mode, active);
        let (scale, inflation) = self.compare(drive, &outcome, active);
        let mut variance =
            self.constant.payload().1.max(0.0) * scale * scale + inflation * inflation;
        if drive.velocity.is_none() {
            // What no measurement has shown is not known better, however the filters come together.
            variance = variance.max(self.variance);
        }
        self.variance = variance;
        let changing = self.change > 0 || self.opening.left > 0;
        let mut state = state(&self.constant, drive, &outcome, variance, changing);
        state.change_mode = self.change > 0;
        state.opening = self.opening.left > 0;
        state
    }

    fn rest(&mut self, drive: &Drive, phase: Phase) -> State {
        let std = self.change_rate_std;
        self.constant.rest(&self.model, drive, phase);
        self.moving.rest(&self.model, drive, phase);
        self.constant.restart_drive(0.0);
        self.moving.restart_drive(std * std);
        self.change = 0;
        self.active = false;
        self.hold_off();
        let variance = self.constant.payload().1;
        self.variance = variance;
        let opening = self.opening.left > 0;
        let mut state = state(
            &self.constant,
            drive,
            &Outcome::default(),
            variance,
            opening,
        );
        state.opening = opening;
        state
    }

    fn hold_off(&mut self) {
        self.disagree = 0;
        self.up = 0.0;
        self.down = 0.0;
    }

    /// Both filters, one step.
    fn advance(&mut self, drive: &Drive, rho: f64, change_mode: bool, active: bool) -> Outcome {
        let (m, variance) = self.constant.payload();
        let own = (m.max(0.0) + 2.0 * sqrt(variance.max(0.0))).min(self.opening_change_max);
        let alarm_std = self.change_rate_std;
        if active && !self.active {
            let std = if change_mode { alarm_std } else { own };
            self.constant.restart_drive(std * std);
        }
        if self.active && !active {
            self.constant.restart_drive(0.0);
        }
        self.active = active;
        let decay = self.opening_decay * rho;
        let (weight, std, time) = if change_mode {
            (rho + 1.0, alarm_std, CHANGE_TIME)
        } else {
            (rho, own, OPENING_TIME)
        };
        let one = Change {
            weight,
            decay,
            std,
            time,
        };
        let two = Change {
            weight: rho + 1.0,
            decay,
            std: alarm_std,
            time: CHANGE_TIME,
        };
        let outcome = self.constant.step(&self.model, drive, one);
        self.moving.step(&self.model, drive, two);
        outcome
    }

    /// Compares the two filters; returns the factor of the standard deviation and what is added.
    fn compare(&mut self, drive: &Drive, outcome: &Outcome, active: bool) -> (f64, f64) {
        let zz = outcome.innovation.normalised();
        if drive.velocity.is_some() {
            let share = 1.0 - exp(ln(0.98) * drive.period / 0.01);
            self.noise += share * ((zz * zz).min(9.0) - self.noise);
        }
        let scale = sqrt((self.noise - 0.15).max(1.0));
        let (m1, v1) = self.constant.payload();
        let (m2, v2) = self.moving.payload();
        let extra = v2 - v1;
        let least = 20.0 * self.kilogram;
        let std = sqrt(extra.max(least * least));
        let mut difference = m2 - m1;
        let z = difference / (std * scale);
        self.disagree = if z.abs() > 2.5 && !active {
            self.disagree + 1
        } else {
            0
        };
        let zc = (zz / scale).clamp(-3.0, 3.0);
        self.up = (self.up + zc - 0.5).max(0.0);
        self.down = (self.down - zc - 0.5).max(0.0);
        let unsure = 40.0 * self.kilogram;
        if active || v1 > unsure * unsure {
            self.hold_off();
        }
        let level = self.up.max(self.down);
        let alarm = self.disagree >= 5 || level > self.change_threshold;
        if alarm {
            self.constant = self.moving.clone();
            self.hold_off();
            self.change = CHANGE;
            self.active = true;
            difference = 0.0;
        }
        let mut inflation = (difference.abs() - std * scale).max(0.0);
        if !active && !alarm && (self.up.max(self.down) > 4.0 || z.abs() > 1.8) {
            inflation = sqrt(extra.max(0.0) + 4.0 * difference * difference);
        }
        (scale, inflation)
    }
}
