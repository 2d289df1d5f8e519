//! Information of the measured velocity about inertia, torque and damping.
//!
//! Along the true swing the velocity samples y = w + v depend on the unknown constants theta (each in units of its
//! prior standard deviation) and on unknown disturbances e of unit variance: the noise of the torque samples, or the
//! random walk of an unknown torque or of an inertia of unknown posture. To first order
//! ```text
//! y = w + S theta + G e + v,   cov y = C = G G' + sigma_w^2 I,   information = S' C^-1 S
//! ```
//! The columns of S and G are responses of the momentum p = J w, linearised about the truth:
//! ```text
//! d(dp)/dt = dT - w db - (b + T_f') dw,   dw = (dp - w dJ)/J
//! ```
//! The Cramer-Rao bound is the inverse of the information; with the prior, of the information plus identity. The
//! last inertia is the parameter, its earlier values follow by the walk taken backward.

use crate::Error;
use calibrate::algebra;
use faer::Mat;
use sim::excavator::Exact;

/// Velocity noise [rad/s], torque noise [N m], friction width of the plant [rad/s].
const VELOCITY_STD: f64 = 0.005;
const TORQUE_STD: f64 = 100.0;
const FRICTION_WIDTH: f64 = 0.005;
/// Prior of the payload [kg], of ln J without posture, of an unknown torque [N m].
const PAYLOAD_STD: f64 = 160.0;
const LOG_INERTIA_STD: f64 = 0.3;
const UNKNOWN_TORQUE_STD: f64 = 3000.0;
/// Walk of an unknown torque while it changes [N m/sqrt(s)].
const CHANGING: f64 = 15_000.0;
/// Times in which it changes [s].
const CHANGES: [(f64, f64); 2] = [(5.5, 5.75), (7.5, 7.75)];

/// Inputs and assumptions of an estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knowledge {
    /// The inertia up to the payload is known; otherwise the rate of the walk of ln J [1/sqrt(s)].
    pub posture: Result<(), f64>,
    /// Prior standard deviation of the offset of a torque with known noise [N m]. Otherwise the rate of the random walk of the torque on
    /// its plateaus [N m/sqrt(s)].
    pub torque: Result<f64, f64>,
    /// Prior deviation of the damping; 0 if it is known [N m s/rad].
    pub damping_std: f64,
}

/// The bound at the end of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Square roots of the eigenvalues of the information, largest first. Below 1 the data carry less information about a
    /// direction than the prior does.
    pub singular_values: Vec<f64>,
    /// Lower bound of the standard deviation of the inertia, prior included [% of the inertia].
    pub with_prior: f64,
    /// The same from the data alone; `None` if they do not determine it.
    pub data_alone: Option<f64>,
}

/// An unknown, as a disturbance of the truth per step.
#[derive(Clone, Copy)]
enum Unknown {
    Payload,
    LogInertia,
    Torque(f64),
    Damping(f64),
    /// The noise of torque sample j, which enters two steps by half.
    TorqueNoise(usize),
    /// A step of the unknown torque before sample j, of this size.
    TorqueStep(usize, f64),
    /// ln J was lower by this amount up to sample j.
    Earlier(usize, f64),
}

impl Knowledge {
    /// The bound at the end of `exact`, which begins at rest, with the payload factor g of every sample [m^2].
    pub fn bound(&self, exact: &[Exact], factor: &[f64]) -> Result<Bound, Error> {
        let (Some(last), Some(last_factor)) = (exact.last(), factor.last()) else {
            return Err(Error::NoSeeds);
        };
        let whitened = whitened(exact, factor, &self.parameters(), &self.disturbances(exact))?;
        let unit = match self.posture {
            Ok(()) => last_factor * PAYLOAD_STD / last.truth.inertia,
            Err(_) => LOG_INERTIA_STD,
        };
        let directions = algebra::directions(&whitened);
        let Some(&(largest, _)) = directions.first() else {
            return Err(Error::refused("the information has no singular values"));
        };
        // Variance of the first parameter: its part of each direction over the squared singular value.
        let variance = |prior: f64| -> f64 {
            let terms = directions.iter();
            terms.map(|(s, v)| v[0].powi(2) / (s * s + prior)).sum()
        };
        let determined = directions.iter().all(|(s, _)| *s > 1e-9 * largest);
        let percent = |variance: f64| 100.0 * unit * variance.sqrt();
        Ok(Bound {
            with_prior: percent(variance(1.0)),
            data_alone: determined.then(|| percent(variance(0.0))),
            singular_values: directions.iter().map(|(s, _)| *s).collect(),
        })
    }

    fn parameters(&self) -> Vec<Unknown> {
        let inertia = if self.posture.is_ok() {
            Unknown::Payload
        } else {
            Unknown::LogInertia
        };
        let torque = Unknown::Torque(self.torque.unwrap_or(UNKNOWN_TORQUE_STD));
        let damping = (self.damping_std > 0.0).then_some(Unknown::Damping(self.damping_std));
        [inertia, torque].into_iter().chain(damping).collect()
    }

    fn disturbances(&self, exact: &[Exact]) -> Vec<Unknown> {
        let steps = 1..exact.len();
        let mut all = Vec::new();
        match self.torque {
            Ok(_) => all.extend((0..exact.len()).map(Unknown::TorqueNoise)),
            Err(walk) => all.extend(steps.clone().map(|j| {
                let changing = CHANGES
                    .iter()
                    .any(|(from, to)| (*from..*to).contains(&exact[j].time));
                let walk = if changing { CHANGING } else { walk };
                Unknown::TorqueStep(j, walk * period(exact, j).sqrt())
            })),
        }
        if let Err(walk) = self.posture {
            all.extend(steps.map(|j| Unknown::Earlier(j - 1, walk * period(exact, j).sqrt())));
        }
        all
    }
}

fn period(exact: &[Exact], sample: usize) -> f64 {
    exact[sample].time - exact[sample - 1].time
}

/// L^-1 S with C = L L'.
fn whitened(
    exact: &[Exact],
    factor: &[f64],
    parameters: &[Unknown],
    disturbances: &[Unknown],
) -> Result<Mat<f64>, Error> {
    let size = exact.len();
    let columns = |unknowns: &[Unknown]| {
        let responses: Vec<Vec<f64>> = unknowns
            .iter()
            .map(|u| response(exact, factor, *u))
            .collect();
        Mat::from_fn(size, unknowns.len(), |row, column| responses[column][row])
    };
    let disturbed = columns(disturbances);
    let mut covariance = &disturbed * disturbed.transpose();
    for i in 0..size {
        covariance[(i, i)] += VELOCITY_STD * VELOCITY_STD;
    }
    algebra::whitened(&covariance, &columns(parameters))
        .ok_or_else(|| Error::refused("the covariance of the velocities has no root"))
}

/// The change of the velocity at every sample due to an unknown.
fn response(exact: &[Exact], factor: &[f64], unknown: Unknown) -> Vec<f64> {
    let mut momentum = 0.0;
    let mut velocities = Vec::with_capacity(exact.len());
    for (k, sample) in exact.iter().enumerate() {
        let truth = &sample.truth;
        let inertia = unknown.inertia(k, truth.inertia, factor[k]);
        let velocity = (momentum - truth.velocity * inertia) / truth.inertia;
        velocities.push(velocity);
        if k + 1 < exact.len() {
            let slope = 1.0 - (truth.velocity / FRICTION_WIDTH).tanh().powi(2);
            let drag = truth.damping + truth.friction * slope / FRICTION_WIDTH;
            let torque = unknown.torque(k) - truth.velocity * unknown.damping() - drag * velocity;
            momentum += period(exact, k + 1) * torque;
        }
    }
    velocities
}

impl Unknown {
    /// Change of the inertia at sample k.
    fn inertia(self, k: usize, inertia: f64, factor: f64) -> f64 {
        match self {
            Self::Payload => PAYLOAD_STD * factor,
            Self::LogInertia => LOG_INERTIA_STD * inertia,
            Self::Earlier(j, size) if k <= j => -size * inertia,
            _ => 0.0,
        }
    }

    /// Change of the torque from sample k to k + 1.
    fn torque(self, k: usize) -> f64 {
        match self {
            Self::Torque(size) => size,
            Self::TorqueNoise(j) if k == j || k + 1 == j => 0.5 * TORQUE_STD,
            Self::TorqueStep(j, size) if k >= j => size,
            _ => 0.0,
        }
    }

    fn damping(self) -> f64 {
        match self {
            Self::Damping(size) => size,
            _ => 0.0,
        }
    }
}
