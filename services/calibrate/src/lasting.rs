//! Least squares with priors, for equations whose errors are correlated over some seconds.
//!
//! Differencing neighbouring equations would whiten the errors, but noise in the regressors attenuates estimates from differences.
//! A correlated error therefore counts as one measurement in twice its correlation time.

use estimation::Quantity;
use faer::Mat;

use crate::algebra;
use crate::fit::GATE;

/// Longest time between two equations that counts as their period \[s\].
pub const GAP: f64 = 0.3;
/// Number of rounds in which the fit leaves out the equations beyond its gate.
const ROUNDS: usize = 4;

/// A linear equation of the unknowns.
pub struct Equation {
    /// Regressors of the unknowns.
    pub row: Vec<f64>,
    /// Their measured sum.
    pub value: f64,
    /// Variance of the correlated error.
    pub rest: f64,
    /// Variance of white noise.
    pub noise: f64,
    /// Time since the previous equation \[s\].
    pub period: f64,
}

impl Equation {
    /// Residual of the equation at these unknowns.
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
    /// Scatter of the data relative to the stated variances, as a factor of standard deviations.
    widened: f64,
}

impl Solution {
    /// Prior: unknowns of 0 with these standard deviations, and the given covariances.
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

    /// Posterior with these equations, whose errors have the correlation time `fading` \[s\]; outliers are left out. `None` where the
    /// unknowns are not determined.
    pub fn after(&self, equations: &[Equation], fading: f64) -> Option<Self> {
        let mut solution = self.clone();
        for _ in 0..ROUNDS {
            solution = self.with(equations, &solution, fading)?;
        }
        Some(solution)
    }

    /// Posterior with the equations that are within the gate of another solution.
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

    /// Variance of a linear combination of the unknowns.
    pub fn variance(&self, row: &[f64]) -> f64 {
        let n = row.len();
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        pairs
            .map(|(i, j)| row[i] * self.covariance[(i, j)] * row[j])
            .sum()
    }

    /// An unknown, with at most the standard deviation that it has in `before`.
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
