//! Mode C: posture without torque. The torque is unknown, and constant between detected changes.
//!
//! A grid of payloads, each with a two-state filter of velocity and total torque u = T - T_f sgn(w):
//!
//! ```text
//! w' = (u - (b + Jd) w) / J,   u a slow random walk, a fast one while a change is flagged
//! ```
//!
//! A bucket that opens during a swing may lose the payload. Without torque that is not observable: the estimate is
//! not trusted until the machine has stood and the grid has restarted.
//!
//! The weight of a node is the likelihood of its innovations. b is the nominal damping. An error of b shifts the
//! payload by the covariance of the nodes with the slope of their log weights in b. This widens the interval (see
//! [`crate::excavator::consider`]).

use crate::excavator::consider::Doubt;
use crate::excavator::delay::{DelayLine, Entry};
use crate::excavator::drive::Drive;
use crate::excavator::opening::Opening;
use crate::excavator::settings::Settings;
use crate::excavator::standstill::Phase;
use crate::excavator::state::State;
use crate::excavator::unknown_torque::{Physics, UnknownTorque};
use crate::math::{exp, ln, sqrt};

/// Number of payloads in the grid.
const NODES: usize = 57;
/// Random walk of the total torque on the reference machine, while a change is flagged and otherwise [N m/sqrt(s)].
const TORQUE_DRIFT_FLAGGED: f64 = 15_000.0;
const TORQUE_DRIFT: f64 = 10.0;
/// Torque noise that enters the velocity directly, on the reference machine [N m].
const TORQUE_NOISE: f64 = 10.0;

/// Upper end of the grid above the middle of the payload's prior, in its standard deviations: 650 kg by the default 200 +- 160 kg.
const GRID_STDS: f64 = 2.8125;
/// Standard deviation of the grid's Gaussian prior over that of the payload's.
const WIDER: f64 = 1.25;
/// Payloads beyond these numbers of spacings, below 0 and from the upper end, have a log weight reduced by `UNLIKELY`.
const LIKELY_BELOW: f64 = 1.6;
const UNLIKELY_END: f64 = 4.0;
const UNLIKELY: f64 = 3.0;

/// Payloads of the grid and their prior: by the default prior of 200 +- 160 kg they are -50, -37.5, ..., 650 kg. The
/// prior is Gaussian about 200 kg, and wider than in mode D, whose filters may leave it.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Payloads {
    first: f64,
    spacing: f64,
    mean: f64,
    std: f64,
}

impl Payloads {
    fn new(settings: &Settings) -> Self {
        let prior = &settings.prior;
        let [first, most] = settings.payload_range();
        let last = (prior.payload + GRID_STDS * prior.payload_std)
            .min(most)
            .max(first + prior.payload_std);
        Self {
            first,
            spacing: (last - first) / (NODES - 1) as f64,
            mean: prior.payload,
            std: WIDER * prior.payload_std,
        }
    }

    fn mass(&self, i: usize) -> f64 {
        self.first + self.spacing * i as f64
    }

    fn likely_until(&self) -> f64 {
        self.mass(NODES - 1) - UNLIKELY_END * self.spacing
    }

    /// Reduction of the log weight near both ends: well below 0, and above 600 kg.
    fn unlikeliness(&self, mass: f64) -> f64 {
        if (-LIKELY_BELOW * self.spacing..=self.likely_until()).contains(&mass) {
            0.0
        } else {
            UNLIKELY
        }
    }

    fn log_prior(&self, mass: f64) -> f64 {
        let z = (mass - self.mean) / self.std;
        -0.5 * z * z - self.unlikeliness(mass)
    }
}

#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Node {
    /// Derivative of the log weight with respect to the damping, per standard deviation.
    slope: f64,
    weight: f64,
    filter: UnknownTorque,
}

impl Node {
    /// Logarithm of the weight; finite also for a weight of 0.
    fn log_weight(&self) -> f64 {
        ln(self.weight + 1e-30)
    }
}

/// Mode C.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct PostureMode {
    damping_std: f64,
    /// Torques of the machine over those of the reference machine.
    scale: f64,
    payloads: Payloads,
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    nodes: [Node; NODES],
    line: DelayLine,
    late: State,
    /// Payload from the grid: mean and standard deviation.
    payload: (f64, f64),
    opening: Opening,
    /// The bucket has opened in this swing.
    opened: bool,
    unflagged_for: f64,
    held: bool,
}

impl PostureMode {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        let payloads = Payloads::new(settings);
        let scale = settings.geometry.scale();
        let mut mode = Self {
            scale,
            payloads,
            damping_std: Doubt::new(settings).damping,
            nodes: [Node {
                slope: 0.0,
                weight: 0.0,
                filter: UnknownTorque::start(scale),
            }; NODES],
            line: DelayLine::new(),
            late: State::default(),
            payload: (0.0, 0.0),
            opening: Opening::new(settings.estimator.opening_rate),
            opened: false,
            unflagged_for: 0.0,
            held: true,
        };
        mode.restart_weights();
        mode
    }

    /// Takes one tick. The reading is that of the tick 0.15 s ago, at the present posture.
    pub(in crate::excavator) fn step(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        (phase, reopen): (Phase, bool),
        event: bool,
    ) -> State {
        let now = drive.now;
        self.opening.step(drive);
        self.opened |= self.opening.is_open() && phase == Phase::Moving;
        let entry = Entry::new(drive, phase, reopen);
        if let Some(late) = self.line.push(entry, event) {
            self.advance(settings, &late);
        }
        let (mass, std) = self.payload;
        State {
            inertia: now.with_payload(mass),
            inertia_std: std * now.per_payload,
            payload: Some(self.payload),
            opening: self.opening.is_open(),
            changing: self.opened,
            unsettled: mass > self.payloads.likely_until(),
            ..self.late
        }
    }

    /// Whether the machine stood at the tick of the reading.
    pub(in crate::excavator) fn held(&self) -> bool {
        self.held
    }

    /// Unflagged motion since the last rest [s].
    pub(in crate::excavator) fn unflagged_for(&self) -> f64 {
        self.unflagged_for
    }

    fn advance(&mut self, settings: &Settings, late: &Entry) {
        self.held = late.phase == Phase::Held;
        if late.reopen {
            self.opened = false;
            self.restart_weights();
        }
        let mut logarithms = self.nodes.map(|node| node.log_weight());
        let mut accelerations = [0.0; NODES];
        let mut nis = 0.0;
        if late.phase == Phase::Moving {
            nis = self.filter(settings, late, &mut logarithms, &mut accelerations);
            self.unflagged_for += if late.flagged { 0.0 } else { late.period };
        } else {
            for node in &mut self.nodes {
                node.filter.rest(late.variance, late.phase, self.scale);
            }
            self.unflagged_for = 0.0;
        }
        self.normalise(&logarithms);
        self.read(late, nis, &accelerations);
    }

    /// Advances all nodes by one step. Returns the normalised innovation squared of the mixture.
    fn filter(
        &mut self,
        settings: &Settings,
        late: &Entry,
        logarithms: &mut [f64; NODES],
        accelerations: &mut [f64; NODES],
    ) -> f64 {
        let damping = settings.nominal_damping;
        let inertia_min = 0.1 * settings.inertia_min;
        let drift = if late.flagged {
            TORQUE_DRIFT_FLAGGED
        } else {
            TORQUE_DRIFT
        };
        let mut nis = 0.0;
        for (i, node) in self.nodes.iter_mut().enumerate() {
            let mass = self.payloads.mass(i);
            let physics = Physics {
                // Only an invalid geometry has an inertia near 0.
                inertia: (late.mean[0] + mass * late.mean[1]).max(inertia_min),
                rate: late.rate[0] + mass * late.rate[1],
                damping,
                damping_std: self.damping_std,
                torque_noise: self.scale * TORQUE_NOISE,
                torque_drift: self.scale * drift,
            };
            accelerations[i] = node.filter.acceleration(&physics);
            let filter = &mut node.filter;
            let innovation = filter.step(&physics, late.period, late.velocity, late.variance);
            if late.velocity.is_some() {
                logarithms[i] -= 0.5 * (innovation.nis() + ln(innovation.variance));
                // The error before the correction over S equals the error after it over R.
                node.slope += innovation.value * node.filter.doubt[0] / late.variance;
                nis += node.weight * innovation.nis();
            }
        }
        nis
    }

    fn restart_weights(&mut self) {
        for node in &mut self.nodes {
            node.slope = 0.0;
        }
        let payloads = self.payloads;
        self.normalise(&core::array::from_fn(|i| {
            payloads.log_prior(payloads.mass(i))
        }));
    }

    /// Computes the weights from their logarithms, and the payload from the weights.
    fn normalise(&mut self, logarithms: &[f64; NODES]) {
        let payloads = self.payloads;
        let most = logarithms
            .iter()
            .fold(f64::NEG_INFINITY, |most, &log| most.max(log));
        let mut sum = 0.0;
        for (node, log) in self.nodes.iter_mut().zip(logarithms) {
            node.weight = exp(log - most);
            sum += node.weight;
        }
        let mut mean = 0.0;
        for (i, node) in self.nodes.iter_mut().enumerate() {
            node.weight /= sum;
            mean += node.weight * payloads.mass(i);
        }
        let distance = |i: usize| payloads.mass(i) - mean;
        let variance: f64 = (self.nodes.iter().enumerate())
            .map(|(i, node)| node.weight * distance(i) * distance(i))
            .sum();
        let doubt = self.doubt();
        let spacing = self.payloads.spacing;
        let variance = variance + spacing * spacing / 12.0 + doubt * doubt;
        self.payload = (mean, sqrt(variance));
    }

    /// Shift of the payload by a damping error of one standard deviation. The log weight is nearly a parabola in the payload,
    /// and its slopes in the damping move its maximum. Only the three nodes about the maximum count: at the ends of the grid the
    /// payload cannot move, which would hide the shift.
    fn doubt(&self) -> f64 {
        let top = (1..NODES - 1)
            .max_by(|&i, &j| self.nodes[i].weight.total_cmp(&self.nodes[j].weight))
            .unwrap_or(1);
        let log = |i: usize| {
            self.nodes[i].log_weight() + self.payloads.unlikeliness(self.payloads.mass(i))
        };
        let curvature = 2.0 * log(top) - log(top - 1) - log(top + 1);
        let tilt = 0.5 * (self.nodes[top + 1].slope - self.nodes[top - 1].slope);
        if curvature > 0.0 {
            self.payloads.spacing * tilt / curvature
        } else {
            0.0
        }
    }

    fn read(&mut self, late: &Entry, nis: f64, accelerations: &[f64; NODES]) {
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
            acceleration: (self.nodes.iter().zip(accelerations))
                .map(|(n, acceleration)| n.weight * acceleration)
                .sum(),
            nis,
            flagged: late.flagged,
            ..State::default()
        };
    }

    pub(in crate::excavator) fn is_sound(&self) -> bool {
        let (mass, std) = self.payload;
        mass.is_finite() && std.is_finite() && self.late.velocity.is_finite()
    }
}
