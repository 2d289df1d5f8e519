//! Extended Kalman filter in square-root form on any [`Model`], with exact derivatives from dual numbers.
//!
//! The derivative directions are the columns of the root, so the derivatives of the model's outputs are F S and H S
//! themselves and no Jacobian is formed. From there on it is the step of [`crate::prediction`].

#![allow(clippy::needless_range_loop)] // indices as in the formulas

use crate::dual::Dual;
use crate::math::sqrt;
use crate::model::Model;
use crate::prediction::{Images, Prediction, Update};
use crate::root::dot;

/// The filter: a state and the lower root of its covariance.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ekf<const N: usize, const M: usize> {
    /// State x.
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    pub state: [f64; N],
    /// Lower root S of the covariance, P = S S'.
    #[cfg_attr(feature = "serde", serde(with = "crate::written::rows"))]
    pub root: [[f64; N]; N],
}

impl<const N: usize, const M: usize> Ekf<N, M> {
    /// A filter at `state` with independent standard deviations.
    pub fn new(state: [f64; N], std: &[f64; N]) -> Self {
        let mut root = [[0.0; N]; N];
        for (i, row) in root.iter_mut().enumerate() {
            row[i] = std[i];
        }
        Self { state, root }
    }

    /// Predicts one step; `process_std` is the additive process noise of the step.
    #[inline]
    pub fn predict<P: Model<N, M>>(&self, model: &P, process_std: &[f64; N]) -> Prediction<N, M> {
        self.images(model).predict(process_std)
    }

    /// The prediction before the process noise is added.
    #[inline(always)]
    pub fn images<P: Model<N, M>>(&self, model: &P) -> Images<N, M, 1> {
        let mut seeded = [Dual::new(0.0, [0.0; N]); N];
        for k in 0..N {
            seeded[k] = Dual::new(self.state[k], self.root[k]);
        }
        let (next, measured) = model.predict(&seeded);
        let mut images = Images {
            state: self.state,
            measurement: [0.0; M],
            rows: [[[0.0; N]; 1]; N],
            measured: [[[0.0; N]; 1]; M],
            noise_coupling: model.noise_coupling(),
            direct: P::DIRECT,
        };
        for k in 0..P::DYNAMIC {
            images.state[k] = next[k].value;
            images.rows[k] = [next[k].derivative];
        }
        for k in P::DYNAMIC..N {
            images.rows[k] = [self.root[k]];
        }
        for p in 0..P::DIRECT {
            images.measurement[p] = images.state[p];
        }
        for p in P::DIRECT..M {
            images.measurement[p] = measured[p].value;
            images.measured[p] = [measured[p].derivative];
        }
        images
    }

    /// Takes over the result of an update.
    pub fn accept(&mut self, update: &Update<N, M>) {
        self.state = update.state;
        self.root = update.root;
    }

    /// One step with every measurement present; returns the normalised innovation squared.
    #[inline]
    pub fn step<P: Model<N, M>>(
        &mut self,
        model: &P,
        process_std: &[f64; N],
        measurement: &[f64; M],
        measurement_std: &[f64; M],
    ) -> f64 {
        if P::DIRECT == M {
            return self.step_direct(model, process_std, measurement, measurement_std);
        }
        let prediction = self.predict(model, process_std);
        let innovation = core::array::from_fn(|j| measurement[j] - prediction.measurement[j]);
        let update = prediction.update(&innovation, measurement_std, &[true; M]);
        self.accept(&update);
        update.nis()
    }

    /// The step for models whose measurements are all leading states: in place, and column by column, so that a rotation acts
    /// on neighbouring numbers.
    #[inline(always)]
    fn step_direct<P: Model<N, M>>(
        &mut self,
        model: &P,
        process_std: &[f64; N],
        measurement: &[f64; M],
        measurement_std: &[f64; M],
    ) -> f64 {
        let mut seeded = [Dual::new(0.0, [0.0; N]); N];
        for k in 0..N {
            seeded[k] = Dual::new(self.state[k], self.root[k]);
        }
        let (image, _) = model.predict(&seeded);
        for k in 0..P::DYNAMIC {
            self.state[k] = image[k].value;
            self.root[k] = image[k].derivative;
        }
        let mut columns = triangular_columns(&mut self.root, process_std);
        let mut nis = 0.0;
        for j in 0..M {
            let (cosine, sine, mut norm) = rotation(measurement_std[j], columns[j][j]);
            let mut pivots = columns[j].map(|entry| sine * entry);
            columns[j] = columns[j].map(|entry| cosine * entry);
            for i in (0..j).rev() {
                let (cosine, sine, next) = rotation(norm, columns[i][j]);
                for k in 0..N {
                    let old = columns[i][k];
                    columns[i][k] = cosine * old - sine * pivots[k];
                    pivots[k] = cosine * pivots[k] + sine * old;
                }
                norm = next;
            }
            let z = (measurement[j] - self.state[j]) / norm;
            for k in 0..N {
                self.state[k] += pivots[k] * z;
            }
            nis += z * z;
        }
        for k in 0..N {
            for i in 0..N {
                self.root[k][i] = if i <= k { columns[i][k] } else { 0.0 };
            }
        }
        nis
    }
}

/// Cosine and sine of the rotation that folds `entry` into `norm`, and the norm it leaves.
#[inline(always)]
fn rotation(norm: f64, entry: f64) -> (f64, f64, f64) {
    let next = sqrt(norm * norm + entry * entry);
    (norm / next, entry / next, next)
}

/// Columns of the lower root of `rows rows' + diag(q)^2`, by the reflections of [`crate::root`]; `rows` is used up.
#[inline(always)]
fn triangular_columns<const N: usize>(rows: &mut [[f64; N]; N], q: &[f64; N]) -> [[f64; N]; N] {
    let mut columns = [[0.0; N]; N];
    for i in 0..N {
        let row = rows[i];
        let norm = sqrt(q[i] * q[i] + dot(&[row], &[row]));
        let pivot = q[i] + norm;
        let scale = 1.0 / (norm * pivot).max(f64::MIN_POSITIVE);
        columns[i][i] = norm;
        for k in i + 1..N {
            let along = scale * dot(&[row], &[rows[k]]);
            for c in 0..N {
                rows[k][c] -= along * row[c];
            }
            columns[i][k] = along * pivot;
        }
    }
    columns
}
