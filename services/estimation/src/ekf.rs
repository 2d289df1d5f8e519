//! Extended Kalman filter on any [`Model`], on the covariance itself, with exact derivatives from dual numbers.
//!
//! ```text
//! x^- = f(x),  P^- = F P F' + Q                        the first `DYNAMIC` rows of F; the others are those of the identity
//! S = cov(y) + R = L L',  G = L^-1 cov(y, x),  z = L^-1 (y - y^)
//! x = x^- + G' z,  P = P^- - G' G,  NIS = z'z
//! ```
//! **Exact rows.** Where y_j is state j itself, row j of P is r_j times that of K' = L'^-1 G. It is not formed as a difference, which
//! cancels where the measurement is far more accurate than the prior.
//!
//! **Precision.** With process noise on the states its error equals that of a square-root filter down to variances of R/P = 1e-9 (both
//! against double-double arithmetic). Without process noise a covariance loses its sign near R/P = 1e-8; use
//! [`crate::srukf::SquareRootUkf`] there, which cannot. P stays symmetric to the last bit.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | x, P | `state`, `covariance` | state and covariance |
//! | y^ | `measurement` | predicted measurement |
//! | cov(y, x) | `cross` | covariance of the predicted measurements with the predicted states |
//! | cov(y) | `own` | covariance of the predicted measurements |

#![allow(clippy::needless_range_loop)] // indices as in the formulas

use core::ops::Range;

use crate::dual::Dual;
use crate::math::sqrt;
use crate::model::Model;
use crate::root::{self, BLOCK};

/// The filter: a state and its covariance.
///
/// ```
/// use estimation::ekf::Ekf;
/// use estimation::model::Model;
/// use estimation::scalar::Scalar;
///
/// /// A cart at a steady speed whose place is measured each second.
/// struct Cart;
/// impl Model<2, 1> for Cart {
///     fn predict<T: Scalar>(&self, [place, speed]: &[T; 2]) -> ([T; 2], [T; 1]) {
///         ([*place + *speed, *speed], [*place + *speed])
///     }
/// }
///
/// let mut filter = Ekf::<2, 1>::new([0.0, 0.0], &[10.0, 10.0]);
/// for row in 1..=50 {
///     filter.step(&Cart, &[1e-3, 1e-3], &[2.0 * f64::from(row)], &[0.1]);
/// }
/// assert!((filter.state[1] - 2.0).abs() < 1e-3);
/// ```
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ekf<const N: usize, const M: usize> {
    /// State x.
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    pub state: [f64; N],
    /// Covariance P, symmetric.
    #[cfg_attr(feature = "serde", serde(with = "crate::written::rows"))]
    pub covariance: [[f64; N]; N],
}

/// Predicted measurements with their covariances, measurement noise not included.
#[derive(Clone, Copy, Debug)]
pub struct Expected<const N: usize, const M: usize> {
    /// Predicted measurement y^.
    pub measurement: [f64; M],
    /// Row j: covariance of measurement j with every predicted state.
    pub cross: [[f64; N]; M],
    /// Covariance of the predicted measurements.
    pub own: [[f64; M]; M],
}

/// sum of weights\[j\] rows\[j\].
///
/// Not inlined: the compiler vectorises only sums that are stored side by side.
#[inline(never)]
pub(crate) fn combine<const N: usize>(weights: &[f64; N], rows: &[[f64; N]; N]) -> [f64; N] {
    let mut sum = rows[0].map(|x| weights[0] * x);
    for j in 1..N {
        for c in 0..N {
            sum[c] += weights[j] * rows[j][c];
        }
    }
    sum
}

/// Adds a multiple of a row.
#[inline(always)]
pub(crate) fn add<const N: usize>(sum: &mut [f64; N], factor: f64, row: &[f64; N]) {
    for i in 0..N {
        sum[i] += factor * row[i];
    }
}

/// Scalar product.
#[inline(always)]
pub(crate) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    root::dot(&[*a], &[*b])
}

/// P^- without process noise. Only the first states move: `by` are their rows of F, and `moved` those of F P.
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

    /// Predicts one step; `process_std` is the additive process noise of the step.
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
        for j in (0..M).filter(|j| !P::DIRECT.contains(j)) {
            let row = combine(&measured[j].derivative, p);
            expected.measurement[j] = measured[j].value;
            expected.cross[j] = row;
            for l in (0..=j).filter(|l| !P::DIRECT.contains(l)) {
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
        // Process noise of this step that also acts on the measurement.
        let coupling = model.noise_coupling();
        for j in (0..M).filter(|j| !P::DIRECT.contains(j)) {
            for i in 0..N {
                let shared = coupling[j][i] * process_std[i] * process_std[i];
                expected.cross[j][i] += shared;
                for l in (0..M).filter(|l| !P::DIRECT.contains(l)) {
                    expected.own[j][l] += shared * coupling[l][i];
                }
            }
        }
        self.complete(&mut expected, process_std, P::DIRECT);
        expected
    }

    /// Adds the process noise to the states, and completes the measurements that are states.
    #[inline(always)]
    pub(crate) fn complete(
        &mut self,
        expected: &mut Expected<N, M>,
        process_std: &[f64; N],
        direct: Range<usize>,
    ) {
        let p = &mut self.covariance;
        for i in 0..N {
            p[i][i] += process_std[i] * process_std[i];
        }
        for j in direct.clone() {
            expected.measurement[j] = self.state[j];
            expected.cross[j] = p[j];
        }
        for j in direct {
            for l in 0..M {
                expected.own[j][l] = expected.cross[l][j];
                expected.own[l][j] = expected.cross[l][j];
            }
        }
    }

    /// Absorbs the accepted measurements; returns the normalised innovation squared, summed over them.
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
        let Expected { cross, own, .. } = expected;
        // L L' = S of the accepted measurements, G = L^-1 C, z = L^-1 e.
        let (mut root, mut gain) = ([[0.0; M]; M], [[0.0; N]; M]);
        let (mut per, mut whitened, mut nis) = ([0.0; M], [0.0; M], 0.0);
        for j in 0..M {
            if !accepted[j] {
                continue;
            }
            let (mut row, mut left) = (cross[j], innovation[j]);
            let mut variance = own[j][j] + std[j] * std[j];
            for l in 0..j {
                let along = (0..l).fold(own[j][l], |sum, k| sum - root[j][k] * root[l][k]);
                let factor = along * per[l];
                root[j][l] = factor;
                variance -= factor * factor;
                left -= factor * whitened[l];
                add(&mut row, -factor, &gain[l]);
            }
            per[j] = 1.0 / sqrt(variance);
            gain[j] = row.map(|c| c * per[j]);
            whitened[j] = left * per[j];
            nis += whitened[j] * whitened[j];
        }
        for j in 0..M {
            add(&mut self.state, whitened[j], &gain[j]);
        }
        let exact = |j: usize| accepted[j] && direct.contains(&j);
        const { assert!(N <= 4 * BLOCK) }
        self.reduce::<0>(&gain, exact);
        self.reduce::<BLOCK>(&gain, exact);
        self.reduce::<{ 2 * BLOCK }>(&gain, exact);
        self.reduce::<{ 3 * BLOCK }>(&gain, exact);
        // K' = L'^-1 G; the exact rows are R K'.
        let p = &mut self.covariance;
        for j in (direct.start..M).rev() {
            let mut row = gain[j];
            for l in j + 1..M {
                add(&mut row, -root[l][j], &gain[l]);
            }
            gain[j] = row.map(|c| c * per[j]);
            if exact(j) {
                let noise = std[j] * std[j];
                for i in 0..N {
                    p[j][i] = noise * gain[j][i];
                    p[i][j] = noise * gain[j][i];
                }
            }
        }
        nis
    }

    /// P - G' G: rows `FROM` to `FROM + BLOCK` from the diagonal's block on, and their mirror images. Exact rows are left out.
    #[inline(always)]
    fn reduce<const FROM: usize>(&mut self, gain: &[[f64; N]; M], exact: impl Fn(usize) -> bool) {
        let p = &mut self.covariance;
        for i in FROM..N.min(FROM + BLOCK) {
            if i < M && exact(i) {
                continue;
            }
            for j in 0..M {
                let factor = -gain[j][i];
                for c in FROM..N {
                    p[i][c] += factor * gain[j][c];
                }
            }
            for c in FROM + BLOCK..N {
                p[c][i] = p[i][c];
            }
        }
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
            P::DIRECT,
        )
    }
}
