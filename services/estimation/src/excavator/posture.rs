//! Mode C: posture without torque. The torque is unknown but constant for a while.
//!
//! A grid of payloads, each with a two-state filter of velocity and total torque u = T - T_f sgn(w):
//!
//! ```text
//! w' = (u - (b + Jd) w) / J,   u a slow random walk, a fast one while a change is flagged
//! ```
//!
//! The weight of a node is the likelihood of its innovations. b is the nominal damping: a wrong one
//! shifts the payload by the covariance of the nodes with the slope of their log weights in b, which
//! widens the interval (see [`super::consider`]).

use super::consider::Doubt;
use super::delay::{DelayLine, Entry};
use super::drive::Drive;
use super::settings::Settings;
use super::standstill::Phase;
use super::state::State;
use crate::kalman::Innovation;
use crate::math::{exp, ln, sqrt};

/// Payloads of the grid: -50, -37.5, ..., 650 kg.
const NODES: usize = 57;
const FIRST: f64 = -50.0;
const SPACING: f64 = 12.5;
/// Standard deviation of the total torque at start and after rest [N m].
const TORQUE_STD: f64 = 3000.0;
/// Random walk of the total torque, flagged and not [N m/sqrt(s)].
const TORQUE_DRIFT_FLAGGED: f64 = 15_000.0;
const TORQUE_DRIFT: f64 = 10.0;
/// Torque noise that enters the velocity directly [N m].
const TORQUE_NOISE: f64 = 10.0;

/// Filter of velocity and unknown total torque for one inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UnknownTorque {
    pub(super) velocity: f64,
    pub(super) torque: f64,
    pub(super) p: [f64; 3],
    acceleration: f64,
    /// Errors of velocity and torque due to the damping.
    doubt: [f64; 2],
}

/// Inertia, its rate, damping and noises of one step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Physics {
    pub(super) inertia: f64,
    pub(super) rate: f64,
    pub(super) damping: f64,
    pub(super) damping_std: f64,
    pub(super) torque_noise: f64,
    pub(super) torque_drift: f64,
}

impl UnknownTorque {
    pub(super) const START: Self = Self {
        velocity: 0.0,
        torque: 0.0,
        p: [1e-6, 0.0, TORQUE_STD * TORQUE_STD],
        acceleration: 0.0,
        doubt: [0.0; 2],
    };

    pub(super) fn step(&mut self, physics: &Physics, drive: &Drive) -> Innovation {
        let dt = drive.period;
        let beta = dt / physics.inertia;
        let damping = physics.damping + physics.rate;
        let alpha = exp(-beta * damping);
        let [velocity, torque] = self.doubt;
        let driven = torque - physics.damping_std * self.velocity;
        self.doubt[0] = alpha * velocity + beta * driven;
        self.acceleration = (self.torque - damping * self.velocity) / physics.inertia;
        self.velocity += dt * self.acceleration;
        let [p00, p01, p11] = self.p;
        let direct = physics.torque_noise * beta;
        let p00 =
            alpha * alpha * p00 + 2.0 * alpha * beta * p01 + beta * beta * p11 + direct * direct;
        let p01 = alpha * p01 + beta * p11;
        let p11 = p11 + physics.torque_drift * physics.torque_drift * dt;
        self.p = [p00, p01, p11];
        let Some(y) = drive.velocity else {
            return Innovation::default();
        };
        let variance = p00 + drive.variance;
        let value = y - self.velocity;
        let (k0, k1) = (p00 / variance, p01 / variance);
        self.velocity += k0 * value;
        self.torque += k1 * value;
        let predicted = self.doubt[0];
        self.doubt = [(1.0 - k0) * predicted, torque - k1 * predicted];
        self.p = [p00 - k0 * p00, p01 - k0 * p01, p11 - k1 * p01];
        Innovation { value, variance }
    }

    pub(super) fn rest(&mut self, drive: &Drive, phase: Phase) {
        if let Phase::Released(velocity) = phase {
            self.velocity = velocity;
            self.p[0] = drive.variance / 4.0 + 0.02 * 0.02;
            self.p[1] = 0.0;
            self.doubt[0] = 0.0;
        } else {
            *self = Self::START;
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Node {
    mass: f64,
    log_weight: f64,
    /// Change of the log weight with the damping, per standard deviation.
    slope: f64,
    weight: f64,
    filter: UnknownTorque,
}

/// Mode C.
#[derive(Debug, Clone)]
pub(super) struct PostureMode {
    settings: Settings,
    damping_std: f64,
    nodes: [Node; NODES],
    line: DelayLine,
    late: State,
    /// Payload from the grid: mean and standard deviation.
    payload: (f64, f64),
    unflagged_for: f64,
    held: bool,
}

impl PostureMode {
    pub(super) fn new(settings: &Settings) -> Self {
        let mut mode = Self {
            settings: *settings,
            damping_std: Doubt::new(settings).damping,
            nodes: core::array::from_fn(|i| Node {
                mass: FIRST + SPACING * i as f64,
                log_weight: 0.0,
                slope: 0.0,
                weight: 0.0,
                filter: UnknownTorque::START,
            }),
            line: DelayLine::new(),
            late: State::default(),
            payload: (0.0, 0.0),
            unflagged_for: 0.0,
            held: true,
        };
        mode.restart_weights();
        mode
    }

    /// One tick; the reading is that of the tick 0.15 s ago at the posture of now.
    pub(super) fn step(&mut self, entry: Entry, event: bool) -> State {
        let now = entry.drive.now;
        if let Some(late) = self.line.push(entry, event) {
            self.advance(&late);
        }
        let (mass, std) = self.payload;
        State {
            inertia: now.with_payload(mass),
            inertia_std: std * now.per_payload,
            payload: Some(self.payload),
            ..self.late
        }
    }

    /// Whether the tick behind the reading stood still.
    pub(super) fn held(&self) -> bool {
        self.held
    }

    /// Unflagged motion since the last rest [s].
    pub(super) fn unflagged_for(&self) -> f64 {
        self.unflagged_for
    }

    fn advance(&mut self, late: &Entry) {
        self.held = late.phase == Phase::Held;
        if late.reopen {
            self.restart_weights();
        }
        let mut nis = 0.0;
        if late.phase == Phase::Moving {
            nis = self.filter(&late.drive, late.flagged);
            self.unflagged_for += if late.flagged { 0.0 } else { late.drive.period };
        } else {
            for node in &mut self.nodes {
                node.filter.rest(&late.drive, late.phase);
            }
            self.unflagged_for = 0.0;
        }
        self.normalise();
        self.read(late, nis);
    }

    /// All nodes, one step; returns the normalised innovation squared of the mixture.
    fn filter(&mut self, drive: &Drive, flagged: bool) -> f64 {
        let damping = self.settings.nominal_damping;
        let inertia_min = 0.1 * self.settings.inertia_min;
        let mut nis = 0.0;
        for node in &mut self.nodes {
            let physics = Physics {
                // Only a geometry that is none could come near zero here.
                inertia: drive.mean.with_payload(node.mass).max(inertia_min),
                rate: drive.rate.with_payload(node.mass),
                damping,
                damping_std: self.damping_std,
                torque_noise: TORQUE_NOISE,
                torque_drift: if flagged {
                    TORQUE_DRIFT_FLAGGED
                } else {
                    TORQUE_DRIFT
                },
            };
            let innovation = node.filter.step(&physics, drive);
            if drive.velocity.is_some() {
                node.log_weight -= 0.5 * (innovation.nis() + ln(innovation.variance));
                // The error before the correction over S is the one after it over R.
                node.slope += innovation.value * node.filter.doubt[0] / drive.variance;
                nis += node.weight * innovation.nis();
            }
        }
        nis
    }

    fn restart_weights(&mut self) {
        let prior = &self.settings.prior;
        for node in &mut self.nodes {
            let z = (node.mass - prior.payload) / PRIOR_STD;
            node.log_weight = -0.5 * z * z - unlikeliness(node.mass);
            node.slope = 0.0;
        }
        self.normalise();
    }

    fn normalise(&mut self) {
        let most = self
            .nodes
            .iter()
            .fold(f64::NEG_INFINITY, |most, node| most.max(node.log_weight));
        let mut sum = 0.0;
        for node in &mut self.nodes {
            node.weight = exp(node.log_weight - most);
            sum += node.weight;
        }
        let mut mean = 0.0;
        for node in &mut self.nodes {
            node.weight /= sum;
            node.log_weight = ln(node.weight + 1e-30);
            mean += node.weight * node.mass;
        }
        let variance: f64 = self
            .nodes
            .iter()
            .map(|node| node.weight * (node.mass - mean) * (node.mass - mean))
            .sum();
        let doubt = self.doubt();
        let variance = variance + SPACING * SPACING / 12.0 + doubt * doubt;
        self.payload = (mean, sqrt(variance));
    }

    /// Shift of the payload by a damping one standard deviation off: the log weight is nearly a
    /// parabola in the payload, and its slopes there move its top. Taken from the three nodes about
    /// the top, so that the ends of the grid, at which the payload cannot move, do not hide it.
    fn doubt(&self) -> f64 {
        let top = (1..NODES - 1)
            .max_by(|&i, &j| self.nodes[i].weight.total_cmp(&self.nodes[j].weight))
            .unwrap_or(1);
        let [left, middle, right] = [top - 1, top, top + 1].map(|i| &self.nodes[i]);
        let log = |node: &Node| node.log_weight + unlikeliness(node.mass);
        let curvature = 2.0 * log(middle) - log(left) - log(right);
        let tilt = 0.5 * (right.slope - left.slope);
        if curvature > 0.0 {
            SPACING * tilt / curvature
        } else {
            0.0
        }
    }

    fn read(&mut self, late: &Entry, nis: f64) {
        let mean = |of: fn(&UnknownTorque) -> f64| -> f64 {
            self.nodes.iter().map(|n| n.weight * of(&n.filter)).sum()
        };
        let torque = mean(|f| f.torque);
        let variance: f64 = self
            .nodes
            .iter()
            .map(|n| {
                let d = n.filter.torque - torque;
                n.weight * (n.filter.p[2] + d * d)
            })
            .sum();
        self.late = State {
            total_torque: Some((torque, sqrt(variance.max(0.0)))),
            velocity: mean(|f| f.velocity),
            acceleration: mean(|f| f.acceleration),
            nis,
            flagged: late.flagged,
            ..State::default()
        };
    }

    pub(super) fn is_sound(&self) -> bool {
        let (mass, std) = self.payload;
        mass.is_finite() && std.is_finite() && self.late.velocity.is_finite()
    }
}

/// What the prior takes from the log weight of a payload outside -20 to 600 kg.
fn unlikeliness(mass: f64) -> f64 {
    if (-20.0..=600.0).contains(&mass) {
        0.0
    } else {
        3.0
    }
}

/// Width of the prior over the payload; wider than that of mode D, whose filters may go on
/// beyond it [kg].
const PRIOR_STD: f64 = 200.0;
