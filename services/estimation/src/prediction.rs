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

#![allow(clippy::needless_range_loop)] // indices as in the formulas

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

/// The Givens rotations that fold the leading entries of one measurement row into its noise.
#[derive(Clone, Copy)]
struct Rotations<const K: usize> {
    cosine: [f64; K],
    sine: [f64; K],
    /// Root of the sum of squares: what remains of the row.
    norm: f64,
}

impl<const K: usize> Rotations<K> {
    /// Rotations that change nothing: a measurement that is not used.
    const NONE: Self = Self {
        cosine: [1.0; K],
        sine: [0.0; K],
        norm: 0.0,
    };

    /// Folds the row from its last entry to the first, so that rotated rows stay triangular. The partial sums come first:
    /// the square roots do not wait for each other.
    #[inline(always)]
    fn of(row: &[f64; K], std: f64) -> Self {
        let mut rotations = Self::NONE;
        let mut sum = std * std;
        let mut norm = std;
        for i in (0..K).rev() {
            sum += row[i] * row[i];
            let next = sqrt(sum);
            let reciprocal = 1.0 / next;
            rotations.cosine[i] = norm * reciprocal;
            rotations.sine[i] = row[i] * reciprocal;
            norm = next;
        }
        rotations.norm = norm;
        rotations
    }

    /// Rotates another row with its entry in the pivot column, and returns that entry.
    #[inline(always)]
    fn apply(&self, row: &mut [f64; K], mut pivot: f64) -> f64 {
        for i in (0..K).rev() {
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
    pub fn predict(&mut self, process_std: &[f64; N]) -> Prediction<N, M> {
        let mut prediction = Prediction {
            state: self.state,
            measurement: self.measurement,
            root: [[0.0; N]; N],
            coupling: [[0.0; N]; M],
            independent: [[0.0; M]; M],
            direct: self.direct,
        };
        let (root, coupling) = (&mut prediction.root, &mut prediction.coupling);
        for p in self.direct..M {
            for i in 0..N {
                coupling[p][i] = self.noise_coupling[p][i] * process_std[i];
            }
        }
        triangularise_with(
            &mut self.rows,
            process_std,
            &mut self.measured,
            root,
            coupling,
            self.direct,
        );
        triangularise_rest(&mut self.measured, &mut prediction.independent, self.direct);
        prediction
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
    #[inline(always)]
    pub fn update(
        &self,
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
    ) -> Update<N, M> {
        let mut out = Update {
            state: self.state,
            root: self.root,
            innovation_root: [[0.0; M]; M],
            gain_root: [[0.0; M]; N],
            whitened: [0.0; M],
        };
        let rotations = self.direct_rotations(innovation, std, accepted, &mut out);
        self.apply_direct(&rotations, &mut out);
        if self.direct < M {
            self.update_indirect(&rotations, innovation, std, accepted, &mut out);
        }
        out
    }

    /// The measurements of states themselves: their rotations and whitened innovations.
    ///
    /// Row j of S^- has j + 1 entries. Before its own rotations it undergoes those of the measurements before it, just as
    /// the row of the state does.
    #[inline(always)]
    fn direct_rotations(
        &self,
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
        out: &mut Update<N, M>,
    ) -> [Rotations<M>; M] {
        let mut rotations = [Rotations::NONE; M];
        for j in 0..self.direct {
            if !accepted[j] {
                continue;
            }
            let mut row: [f64; M] =
                core::array::from_fn(|i| if i <= j { self.root[j][i] } else { 0.0 });
            let mut left = innovation[j];
            for i in 0..j {
                let gain = rotations[i].apply(&mut row, 0.0);
                out.innovation_root[j][i] = gain;
                left -= gain * out.whitened[i];
            }
            rotations[j] = Rotations::of(&row, std[j]);
            out.innovation_root[j][j] = rotations[j].norm;
            out.whitened[j] = left / rotations[j].norm;
        }
        rotations
    }

    /// Rotates the rows of all states at once: lane k is row k, so the work runs side by side.
    #[inline(always)]
    fn apply_direct(&self, rotations: &[Rotations<M>; M], out: &mut Update<N, M>) {
        let mut columns = [[0.0; N]; M];
        for k in 0..N {
            for (i, column) in columns.iter_mut().enumerate().take(N) {
                column[k] = self.root[k][i];
            }
        }
        for j in 0..self.direct {
            let mut pivots = [0.0; N];
            // Row j and the rows before it have no entries beyond column j.
            for i in (0..=j).rev() {
                let (cosine, sine) = (rotations[j].cosine[i], rotations[j].sine[i]);
                for k in 0..N {
                    let entry = columns[i][k];
                    columns[i][k] = cosine * entry - sine * pivots[k];
                    pivots[k] = cosine * pivots[k] + sine * entry;
                }
            }
            for k in 0..N {
                out.gain_root[k][j] = pivots[k];
                out.state[k] += pivots[k] * out.whitened[j];
            }
        }
        for k in 0..N {
            for (i, column) in columns.iter().enumerate().take(N) {
                out.root[k][i] = column[k];
            }
        }
    }

    /// The other measurements: first their part that no state explains, then the columns of the states.
    fn update_indirect(
        &self,
        direct: &[Rotations<M>; M],
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
        out: &mut Update<N, M>,
    ) {
        let (mut coupling, mut independent) = (self.coupling, self.independent);
        let mut left = *innovation;
        for p in self.direct..M {
            let mut head = leading(&coupling[p]);
            for j in 0..self.direct {
                let gain = direct[j].apply(&mut head, 0.0);
                out.innovation_root[p][j] = gain;
                left[p] -= gain * out.whitened[j];
            }
            set_leading(&mut coupling[p], &head);
        }
        for j in self.direct..M {
            if !accepted[j] {
                out.innovation_root[j] = [0.0; M];
                continue;
            }
            let alone = Rotations::of(&independent[j], std[j]);
            let shared = Rotations::of(&coupling[j], alone.norm);
            out.innovation_root[j][j] = shared.norm;
            let z = left[j] / shared.norm;
            out.whitened[j] = z;
            for k in 0..N {
                let gain = shared.apply(&mut out.root[k], 0.0);
                out.gain_root[k][j] = gain;
                out.state[k] += gain * z;
            }
            for p in j + 1..M {
                let pivot = alone.apply(&mut independent[p], 0.0);
                let gain = shared.apply(&mut coupling[p], pivot);
                out.innovation_root[p][j] = gain;
                left[p] -= gain * z;
            }
        }
    }
}

/// The first `K` entries of a row, or all and zeros.
#[inline(always)]
fn leading<const N: usize, const K: usize>(row: &[f64; N]) -> [f64; K] {
    let mut head = [0.0; K];
    for (h, x) in head.iter_mut().zip(row) {
        *h = *x;
    }
    head
}

/// Writes the first `K` entries of a row back.
#[inline(always)]
fn set_leading<const N: usize, const K: usize>(row: &mut [f64; N], head: &[f64; K]) {
    for (x, h) in row.iter_mut().zip(head) {
        *x = *h;
    }
}
