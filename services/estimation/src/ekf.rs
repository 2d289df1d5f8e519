//! Extended Kalman filter on any [`Model`], on the covariance itself, with exact derivatives from dual numbers.
//!
//! ```text
//! x^- = f(x),  P^- = F P F' + Q                        the first `DYNAMIC` rows of F; the others are those of the identity
//! c_j = cov(x, y_j),  s_j = var(y_j) + r_j             measurement by measurement, each on what the ones before left
//! x = x^- + c_j (y_j - y^_j)/s_j,  P = P^- - c_j c_j'/s_j
//! ```
//! **Exact rows.** Where y_j is state j itself, row j of P is c_j r_j/s_j, and not the difference c_j - c_j (s_j - r_j)/s_j, which
//! cancels where a measurement is far better than what was known. So nothing is lost in the state that the cancellation would hit.
//!
//! **What it needs.** With process noise on the states its error equals that of a square root down to variances of R/P = 1e-9 (both
//! against double-double arithmetic). Without process noise a covariance loses its sign near R/P = 1e-8: take
//! [`crate::srukf::SquareRootUkf`] there, which cannot. P stays symmetric to the last bit.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | x, P | `state`, `covariance` | state and covariance |
//! | y^ | `measurement` | predicted measurement |
//! | c_j | `cross` | covariance of measurement j with the predicted states |
//! | s_j - r_j | `own` | covariances of the predicted measurements among themselves, without sensor noise |

#![allow(clippy::needless_range_loop)] // indices as in the formulas

use core::ops::Range;

use crate::dual::Dual;
use crate::math::sqrt;
use crate::model::Model;
use crate::root;

/// The filter: a state and its covariance.
#[derive(Clone, Copy, Debug)]
pub struct Ekf<const N: usize, const M: usize> {
    /// State x.
    pub state: [f64; N],
    /// Covariance P, symmetric.
    pub covariance: [[f64; N]; N],
}

/// Measurements predicted, measurement noise not included.
#[derive(Clone, Copy, Debug)]
pub struct Expected<const N: usize, const M: usize> {
    /// Predicted measurement y^.
    pub measurement: [f64; M],
    /// Row j: covariance of measurement j with every predicted state.
    pub cross: [[f64; N]; M],
    /// Their covariances among themselves.
    pub own: [[f64; M]; M],
}

/// sum of weights\[j\] rows\[j\].
#[inline(always)]
pub(crate) fn combine<const N: usize>(weights: &[f64; N], rows: &[[f64; N]; N]) -> [f64; N] {
    let mut sum = rows[0].map(|x| weights[0] * x);
    for j in 1..N {
        for c in 0..N {
            sum[c] += weights[j] * rows[j][c];
        }
    }
    sum
}

/// Scalar product.
#[inline(always)]
pub(crate) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    root::dot(&[*a], &[*b])
}

/// P^- but for the noise: the first states move. `by` are their rows of F and `moved` those of F P.
#[inline(always)]
pub(crate) fn carry<const N: usize>(p: &mut [[f64; N]; N], moved: &[[f64; N]], by: &[[f64; N]]) {
    let moving = moved.len();
    for k in 0..moving {
        for l in 0..=k {
            p[k][l] = dot(&moved[k], &by[l]);
            p[l][k] = p[k][l];
        }
        for c in moving..N {
            p[k][c] = moved[k][c];
            p[c][k] = moved[k][c];
        }
    }
}

impl<const N: usize, const M: usize> Expected<N, M> {
    /// Standard deviation of the predicted measurement j, sensor noise not included.
    pub fn measurement_std(&self, j: usize) -> f64 {
        sqrt(self.own[j][j].max(0.0))
    }
}

impl<const N: usize, const M: usize> Ekf<N, M> {
    /// A filter at `state` with independent standard deviations.
    pub fn new(state: [f64; N], std: &[f64; N]) -> Self {
        let mut covariance = [[0.0; N]; N];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = std[i] * std[i];
        }
        Self { state, covariance }
    }

    /// Moves on by one step; `process_std` is the additive process noise of the step.
    #[inline(always)]
    pub fn predict<P: Model<N, M>>(&mut self, model: &P, process_std: &[f64; N]) -> Expected<N, M> {
        let seeded: [Dual<N>; N] = core::array::from_fn(|k| {
            let mut direction = [0.0; N];
            direction[k] = 1.0;
            Dual::new(self.state[k], direction)
        });
        let (next, measured) = model.predict(&seeded);
        let p = &mut self.covariance;
        let mut expected = Expected {
            measurement: [0.0; M],
            cross: [[0.0; N]; M],
            own: [[0.0; M]; M],
        };
        for j in P::DIRECT..M {
            let row = combine(&measured[j].derivative, p);
            expected.measurement[j] = measured[j].value;
            expected.cross[j] = row;
            for l in P::DIRECT..=j {
                expected.own[j][l] = dot(&row, &measured[l].derivative);
                expected.own[l][j] = expected.own[j][l];
            }
            for k in 0..P::DYNAMIC {
                expected.cross[j][k] = dot(&row, &next[k].derivative);
            }
        }
        let (mut by, mut moved) = ([[0.0; N]; N], [[0.0; N]; N]);
        for k in 0..P::DYNAMIC {
            by[k] = next[k].derivative;
            moved[k] = combine(&by[k], p);
            self.state[k] = next[k].value;
        }
        carry(p, &moved[..P::DYNAMIC], &by[..P::DYNAMIC]);
        let coupling = model.noise_coupling();
        self.complete(&mut expected, &coupling, N, process_std, 0..P::DIRECT);
        expected
    }

    /// Adds the process noise, and fills in the measurements that are states.
    ///
    /// `coupling` is the model's, zero from state `seen` on.
    #[inline(always)]
    pub(crate) fn complete(
        &mut self,
        expected: &mut Expected<N, M>,
        coupling: &[[f64; N]; M],
        seen: usize,
        process_std: &[f64; N],
        direct: Range<usize>,
    ) {
        let p = &mut self.covariance;
        let noise = process_std.map(|q| q * q);
        for i in 0..N {
            p[i][i] += noise[i];
        }
        for j in 0..M {
            if direct.contains(&j) {
                expected.measurement[j] = self.state[j];
                expected.cross[j] = p[j];
                continue;
            }
            for i in 0..seen {
                let shared = coupling[j][i] * noise[i];
                expected.cross[j][i] += shared;
                for l in 0..M {
                    if !direct.contains(&l) {
                        expected.own[j][l] += shared * coupling[l][i];
                    }
                }
            }
        }
        for j in direct {
            for l in 0..M {
                expected.own[j][l] = expected.cross[l][j];
                expected.own[l][j] = expected.cross[l][j];
            }
        }
    }

    /// Absorbs the accepted measurements; returns the normalised innovation squared, the sum over them.
    ///
    /// `innovation` is y - y^ and `std` the measurement noise, which must be positive where accepted. The measurements in
    /// `direct` are the states of the same index.
    #[inline(always)]
    pub fn update(
        &mut self,
        expected: &Expected<N, M>,
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
        direct: Range<usize>,
    ) -> f64 {
        let (mut cross, mut own, mut left) = (expected.cross, expected.own, *innovation);
        let mut gains = [[0.0; N]; M];
        let mut nis = 0.0;
        for j in 0..M {
            if !accepted[j] {
                continue;
            }
            let noise = std[j] * std[j];
            let per = 1.0 / sqrt(own[j][j] + noise);
            let (gain, along) = (cross[j].map(|c| per * c), own[j].map(|c| per * c));
            let z = left[j] * per;
            nis += z * z;
            for m in 0..M {
                // What is behind counts only where its row is kept.
                if m == j || m < j && !direct.contains(&m) {
                    continue;
                }
                left[m] -= along[m] * z;
                for i in 0..N {
                    cross[m][i] -= along[m] * gain[i];
                }
                for l in 0..M {
                    own[m][l] -= along[m] * along[l];
                }
            }
            if direct.contains(&j) {
                cross[j] = gain.map(|g| g * (noise * per));
                own[j] = along.map(|a| a * (noise * per));
                for m in 0..M {
                    own[m][j] = own[j][m];
                }
            }
            for i in 0..N {
                self.state[i] += gain[i] * z;
            }
            gains[j] = gain;
        }
        let p = &mut self.covariance;
        for i in 0..N {
            if direct.contains(&i) {
                continue;
            }
            for gain in &gains {
                for c in 0..N {
                    p[i][c] -= gain[i] * gain[c];
                }
            }
        }
        for j in direct {
            for i in 0..N {
                p[j][i] = cross[j][i];
                p[i][j] = cross[j][i];
            }
        }
        nis
    }

    /// One step with every measurement present; returns the normalised innovation squared.
    #[inline(always)]
    pub fn step<P: Model<N, M>>(
        &mut self,
        model: &P,
        process_std: &[f64; N],
        measurement: &[f64; M],
        measurement_std: &[f64; M],
    ) -> f64 {
        let expected = self.predict(model, process_std);
        let innovation = core::array::from_fn(|j| measurement[j] - expected.measurement[j]);
        self.update(
            &expected,
            &innovation,
            measurement_std,
            &[true; M],
            0..P::DIRECT,
        )
    }
}
