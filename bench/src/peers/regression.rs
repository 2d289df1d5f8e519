//! Recursive least squares with three parameters. No crate has a factor for each parameter, so the peers are textbooks in nalgebra.

use crate::problem::{Filter, REGRESSION};
use nalgebra::{Matrix3, Vector3};

/// Ordinary RLS with one forgetting factor and a full covariance: the fastest alternative. It is another estimator, so its
/// numbers differ.
pub struct SingleFactor {
    theta: Vector3<f64>,
    p: Matrix3<f64>,
    forgetting: f64,
}

impl Default for SingleFactor {
    fn default() -> Self {
        Self {
            theta: REGRESSION.parameters.into(),
            p: Matrix3::from_diagonal(&REGRESSION.covariance.into()),
            forgetting: REGRESSION.forgetting[0],
        }
    }
}

impl Filter<[f64; 3], 3> for SingleFactor {
    fn step(&mut self, regressor: &[f64; 3]) {
        let phi = Vector3::from(*regressor);
        let spread = self.p * phi;
        let gain = spread / (self.forgetting + phi.dot(&spread));
        self.theta -= gain * phi.dot(&self.theta);
        self.p = (self.p - gain * spread.transpose()) / self.forgetting;
    }

    fn state(&self) -> [f64; 3] {
        self.theta.into()
    }
}

/// RLS with a factor for each parameter in the paper's form: scalar gains, then the 3x3 system solved by nalgebra's LU.
pub struct TextbookSolve {
    theta: Vector3<f64>,
    p: Vector3<f64>,
    forgetting: Vector3<f64>,
}

impl Default for TextbookSolve {
    fn default() -> Self {
        Self {
            theta: REGRESSION.parameters.into(),
            p: REGRESSION.covariance.into(),
            forgetting: REGRESSION.forgetting.into(),
        }
    }
}

impl Filter<[f64; 3], 3> for TextbookSolve {
    fn step(&mut self, regressor: &[f64; 3]) {
        let phi = Vector3::from(*regressor);
        let mut gain = Vector3::zeros();
        for i in 0..3 {
            gain[i] = self.p[i] * phi[i] / (self.forgetting[i] + phi[i] * phi[i] * self.p[i]);
            self.p[i] = (self.p[i] * (1.0 - gain[i] * phi[i]) / self.forgetting[i]).min(1e14);
        }
        let mut system = gain * phi.transpose();
        system.fill_diagonal(1.0);
        let right = Vector3::from_fn(|i, _| self.theta[i] - gain[i] * phi[i] * self.theta[i]);
        if let Some(theta) = system.lu().solve(&right) {
            self.theta = theta;
        }
    }

    fn state(&self) -> [f64; 3] {
        self.theta.into()
    }
}
