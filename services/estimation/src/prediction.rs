//! What both filters predict, and the measurement update that both share.
//!
//! The consistent square-root step triangularises one array,
//! ```text
//! [ D_Y  Q_Y  diag(R) ]        [ S_y  0  ]
//! [ D_X  Q    0       ]   =>   [ K_b  S+ ],   z = S_y^-1 (y - y^),  x = x^- + K_b z,  NIS = z'z
//! ```
//! with D_X, D_Y the images of the sigma points (or derivatives), Q the process noise, Q_Y its part in the measurement. The
//! factor is unique, so the order of the rotations is free. We take the states first, which gives the predicted root S^-
//! and expresses each measurement as a row of it, and then absorb the measurements one at a time. A measurement of a
//! state itself is row j of S^-, with j + 1 entries, and Givens rotations from the last entry to the first keep S
//! triangular all the way. There is no downdate and no Cholesky factorisation, and a rejected measurement is simply
//! not absorbed.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | x^-, y^ | `state`, `measurement` | predicted state and measurement |
//! | S^- | `root` | lower root of the predicted covariance |
//! | B | `coupling` | the other measurements in the columns of S^- |
//! | L_e | `independent` | root of what of them no state explains |
//! | S_y, K_b | `innovation_root`, `gain_root` | as above; the gain is K = K_b S_y^-1 |

use crate::math::sqrt;
use crate::root::{Row, triangularise_rest, triangularise_with};

/// A predicted state and measurement with their joint uncertainty, measurement noise not included.
#[derive(Clone, Copy, Debug)]
pub struct Prediction<const N: usize, const M: usize> {
    /// Predicted state x^-.
    pub state: [f64; N],
    /// Predicted measurement y^.
    pub measurement: [f64; M],
    /// Lower root S^- of the predicted covariance.
    pub root: [[f64; N]; N],
    /// Rows from `direct` on: each measurement in the columns of S^-.
    pub coupling: [[f64; N]; M],
    /// Rows from `direct` on: lower root of the part of the measurements that the states do not explain.
    pub independent: [[f64; M]; M],
    /// The first `direct` measurements are the leading states.
    pub direct: usize,
}

/// What an update did.
#[derive(Clone, Copy, Debug)]
pub struct Update<const N: usize, const M: usize> {
    /// Updated state.
    pub state: [f64; N],
    /// Updated lower root.
    pub root: [[f64; N]; N],
    /// Lower root S_y of the innovation covariance; a rejected measurement has a row of zeros.
    pub innovation_root: [[f64; M]; M],
    /// K_b, the gain times S_y.
    pub gain_root: [[f64; M]; N],
    /// Whitened innovations z; 0 where rejected.
    pub whitened: [f64; M],
}

impl<const N: usize, const M: usize> Update<N, M> {
    /// Normalised innovation squared, the sum over the accepted measurements.
    pub fn nis(&self) -> f64 {
        self.whitened.iter().map(|z| z * z).sum()
    }
}

/// The Givens rotations that fold the entries of one measurement row into its noise.
struct Rotations<const K: usize> {
    cosine: [f64; K],
    sine: [f64; K],
    /// Root of the sum of squares: what remains of the row.
    norm: f64,
}

impl<const K: usize> Rotations<K> {
    /// For the first `len` entries of a row, from the last to the first. The partial sums come first, so the square roots
    /// do not wait for each other.
    #[inline(always)]
    fn of(row: &[f64; K], len: usize, pivot: f64) -> Self {
        let (mut cosine, mut sine) = ([1.0; K], [0.0; K]);
        let mut sum = pivot * pivot;
        let mut norm = pivot;
        for i in (0..len).rev() {
            sum += row[i] * row[i];
            let next = sqrt(sum);
            let reciprocal = 1.0 / next;
            cosine[i] = norm * reciprocal;
            sine[i] = row[i] * reciprocal;
            norm = next;
        }
        Self { cosine, sine, norm }
    }

    /// Rotates the first `len` entries of another row with its entry in the pivot column, and returns that entry.
    #[inline(always)]
    fn apply(&self, row: &mut [f64; K], len: usize, mut pivot: f64) -> f64 {
        for i in (0..len).rev() {
            let entry = row[i];
            row[i] = self.cosine[i] * entry - self.sine[i] * pivot;
            pivot = self.cosine[i] * pivot + self.sine[i] * entry;
        }
        pivot
    }
}

/// Means and deviations before they are triangularised.
///
/// The process noise comes in only afterwards, so it may depend on the predicted state.
#[derive(Clone, Copy, Debug)]
pub struct Images<const N: usize, const M: usize, const B: usize> {
    /// Predicted state.
    pub state: [f64; N],
    /// Predicted measurement.
    pub measurement: [f64; M],
    /// Rows of D_X, in `B` blocks: \[C D\] of sigma points, or the derivatives.
    pub rows: [Row<N, B>; N],
    /// Rows of D_Y; those before `direct` are not used.
    pub measured: [Row<N, B>; M],
    /// Derivative of the measurements by the process noise.
    pub noise_coupling: [[f64; N]; M],
    /// The first `direct` measurements are the leading states.
    pub direct: usize,
}

impl<const N: usize, const M: usize, const B: usize> Images<N, M, B> {
    /// Adds the process noise of the step and triangularises.
    #[inline(always)]
    pub fn predict(mut self, process_std: &[f64; N]) -> Prediction<N, M> {
        let mut coupling = self.noise_coupling;
        for row in &mut coupling[self.direct..] {
            for (g, q) in row.iter_mut().zip(process_std) {
                *g *= q;
            }
        }
        let root = triangularise_with(
            &mut self.rows,
            process_std,
            &mut self.measured,
            &mut coupling,
            self.direct,
        );
        let independent = triangularise_rest(&mut self.measured, self.direct);
        Prediction {
            state: self.state,
            measurement: self.measurement,
            root,
            coupling,
            independent,
            direct: self.direct,
        }
    }
}

impl<const N: usize, const M: usize> Prediction<N, M> {
    /// Standard deviation of the predicted measurement j, sensor noise not included.
    pub fn measurement_std(&self, j: usize) -> f64 {
        let norm = |row: &[f64]| row.iter().map(|x| x * x).sum::<f64>();
        if j < self.direct {
            sqrt(norm(&self.root[j]))
        } else {
            sqrt(norm(&self.coupling[j]) + norm(&self.independent[j]))
        }
    }

    /// Absorbs the accepted measurements.
    ///
    /// `innovation` is y - y^ and `std` the measurement noise, which must be positive where accepted.
    #[inline]
    pub fn update(
        &self,
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
    ) -> Update<N, M> {
        let mut work = *self;
        let mut out = Update {
            state: self.state,
            root: [[0.0; N]; N],
            innovation_root: [[0.0; M]; M],
            gain_root: [[0.0; M]; N],
            whitened: [0.0; M],
        };
        let mut left = *innovation;
        for j in 0..M {
            if accepted[j] {
                work.absorb(j, &mut left, std[j], &mut out);
            }
        }
        out.root = work.root;
        out
    }

    /// Folds measurement j into the root and moves the state by what it says.
    #[inline(always)]
    fn absorb(&mut self, j: usize, left: &mut [f64; M], std: f64, out: &mut Update<N, M>) {
        let mut pivots = [0.0; M];
        let (row, len, noise) = if j < self.direct {
            (self.root[j], j + 1, std)
        } else {
            (
                self.coupling[j],
                N,
                self.absorb_independent(j, std, &mut pivots),
            )
        };
        let rotations = Rotations::of(&row, len, noise);
        let z = left[j] / rotations.norm;
        out.whitened[j] = z;
        out.innovation_root[j][j] = rotations.norm;
        for k in 0..N {
            let gain = rotations.apply(&mut self.root[k], len.min(k + 1), 0.0);
            out.gain_root[k][j] = gain;
            out.state[k] += gain * z;
        }
        for p in j + 1..M {
            let gain = if p < self.direct {
                out.gain_root[p][j]
            } else {
                rotations.apply(&mut self.coupling[p], len, pivots[p])
            };
            out.innovation_root[p][j] = gain;
            left[p] -= gain * z;
        }
    }

    /// Folds the part of measurement j that no state explains into its noise.
    #[inline(always)]
    fn absorb_independent(&mut self, j: usize, std: f64, pivots: &mut [f64; M]) -> f64 {
        let rotations = Rotations::of(&self.independent[j], j + 1, std);
        for (row, pivot) in self.independent.iter_mut().zip(pivots).skip(j + 1) {
            *pivot = rotations.apply(row, j + 1, 0.0);
        }
        rotations.norm
    }
}
