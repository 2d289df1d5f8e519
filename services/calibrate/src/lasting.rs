//! Least squares with priors, of equations whose errors last for some seconds: what lasts says the same again and again.
//!
//! Differences of neighbouring equations would be white, but noise in the unknowns' factors weakens what differences say. So what lasts
//! counts as what it is, one measurement in twice its time.

use estimation::Quantity;
use faer::Mat;

use crate::algebra;
use crate::fit::GATE;

/// A longer time between two equations ends what belongs together \[s\].
pub const GAP: f64 = 0.3;
/// So often the fit leaves out the equations beyond its gate.
const ROUNDS: usize = 4;

/// An equation of the unknowns.
pub struct Equation {
    /// Factors of the unknowns.
    pub row: Vec<f64>,
    /// Their sum.
    pub value: f64,
    /// Variance of what lasts.
    pub rest: f64,
    /// Variance of noise.
    pub noise: f64,
    /// Time since the one before \[s\].
    pub period: f64,
}

impl Equation {
    /// What the unknowns leave of it.
    fn residual(&self, unknowns: &Mat<f64>) -> f64 {
        let numbered = self.row.iter().enumerate();
        let stated: f64 = numbered.map(|(i, a)| a * unknowns[(i, 0)]).sum();
        self.value - stated
    }
}

/// The unknowns with their covariance.
#[derive(Clone)]
pub struct Solution {
    unknowns: Mat<f64>,
    covariance: Mat<f64>,
    /// Scatter of the data over what is stated.
    widened: f64,
}

impl Solution {
    /// Unknowns of 0 with these standard deviations, and the covariances of some.
    pub fn before(stds: &[f64], together: &[(usize, usize, f64)]) -> Self {
        let n = stds.len();
        let mut covariance = Mat::from_fn(n, n, |i, j| {
            if i == j {
                stds[i].max(1e-9).powi(2)
            } else {
                0.0
            }
        });
        for &(i, j, both) in together {
            (covariance[(i, j)], covariance[(j, i)]) = (both, both);
        }
        Self {
            unknowns: Mat::zeros(n, 1),
            covariance,
            widened: 1.0,
        }
    }

    /// With equations whose errors fade within this time \[s\], but those that lie far from the rest; `None` where they determine
    /// nothing.
    pub fn after(&self, equations: &[Equation], fading: f64) -> Option<Self> {
        let mut solution = self.clone();
        for _ in 0..ROUNDS {
            solution = self.with(equations, &solution, fading)?;
        }
        Some(solution)
    }

    /// This with the equations that another solution does not contradict.
    fn with(&self, equations: &[Equation], other: &Self, fading: f64) -> Option<Self> {
        let mut information = algebra::inverse(&self.covariance)?;
        let n = information.nrows();
        let mut right = Mat::<f64>::zeros(n, 1);
        let (mut scatter, mut count) = (0.0, 0.0);
        for e in equations {
            let stated = e.rest + e.noise;
            let left = e.residual(&other.unknowns).powi(2);
            let fits = left <= GATE * GATE * (stated + other.variance(&e.row));
            if !fits {
                continue;
            }
            let variance = e.rest * (1.0 + 2.0 * fading / e.period.min(GAP)) + e.noise;
            for i in 0..n {
                right[(i, 0)] += e.row[i] * e.value / variance;
                for j in 0..n {
                    information[(i, j)] += e.row[i] * e.row[j] / variance;
                }
            }
            scatter += left / stated;
            count += 1.0;
        }
        let covariance = algebra::inverse(&information)?;
        Some(Self {
            unknowns: &covariance * &right,
            covariance,
            widened: (scatter / f64::max(count, 1.0)).max(1.0).sqrt(),
        })
    }

    /// Variance of a row of the unknowns.
    pub fn variance(&self, row: &[f64]) -> f64 {
        let n = row.len();
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        pairs
            .map(|(i, j)| row[i] * self.covariance[(i, j)] * row[j])
            .sum()
    }

    /// An unknown, at most as uncertain as `before`.
    pub fn quantity(&self, i: usize, before: &Self) -> Quantity {
        let std = |solution: &Self| solution.covariance[(i, i)].sqrt();
        Quantity {
            value: self.unknowns[(i, 0)],
            std: (self.widened * std(self)).min(std(before)),
        }
    }

    /// Correlation of the errors of two unknowns.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        let c = &self.covariance;
        c[(i, j)] / (c[(i, i)] * c[(j, j)]).sqrt()
    }
}
