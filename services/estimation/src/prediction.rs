//! Prediction from sigma points, and its update by measurements.
//!
//! The consistent square-root step triangularises one array,
//! ```text
//! [ D_Y  Q_Y  diag(R) ]        [ S_y  0  ]
//! [ D_X  Q    0       ]   =>   [ K_b  S+ ],   z = S_y^-1 (y - y^),  x = x^- + K_b z,  NIS = z'z
//! ```
//! with D_X, D_Y the images of the sigma points, Q the process noise, Q_Y its part in the measurement. The
//! factor is unique, so the order of the rotations is free. The states come first, which gives the predicted root S^-
//! and expresses each measurement as a row of it. The measurements are then absorbed one at a time. A measurement of a
//! state itself is row j of S^-, with j + 1 entries, and Givens rotations from the last entry to the first leave S
//! triangular throughout. There is no downdate and no Cholesky factorisation. A rejected measurement is simply
//! not absorbed.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | x^-, y^ | `state`, `measurement` | predicted state and measurement |
//! | S^- | `columns` | lower root of the predicted covariance, column by column |
//! | B | `coupling` | the indirect measurements in the columns of S^- |
//! | L_e | `independent` | root of the part of them that no state explains |
//! | S_y, K_b | `innovation_root`, `gain_root` | as above; the gain is K = K_b S_y^-1 |

#![allow(clippy::needless_range_loop)] // indices as in the formulas

use core::marker::PhantomData;

use crate::math::sqrt;
use crate::model::Model;
use crate::rotations::Rotations;

/// Predicted state and measurement with their joint uncertainty, measurement noise not included. Absorbing measurements turns state and
/// root into the updated ones.
pub struct Prediction<P, const N: usize, const M: usize> {
    /// State x^-.
    pub state: [f64; N],
    /// Predicted measurement y^.
    pub measurement: [f64; M],
    /// Columns of the lower root S^- of its covariance.
    pub columns: [[f64; N]; N],
    /// Indirect measurements in the columns of S^-.
    pub coupling: [[f64; N]; M],
    /// Lower root of the part of these measurements that the states do not explain.
    pub independent: [[f64; M]; M],
    pub(crate) model: PhantomData<fn(&P)>,
}

/// Result of an update.
#[derive(Clone, Copy, Debug)]
pub struct Update<const N: usize, const M: usize> {
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

impl<P: Model<N, M>, const N: usize, const M: usize> Prediction<P, N, M> {
    /// Lower root of the covariance.
    #[inline(always)]
    pub fn root(&self) -> [[f64; N]; N] {
        rows(&self.columns)
    }

    /// Standard deviation of the predicted measurement j, sensor noise not included.
    pub fn measurement_std(&self, j: usize) -> f64 {
        let norm = |row: &[f64]| row.iter().map(|x| x * x).sum::<f64>();
        if P::DIRECT.contains(&j) {
            let row = self.columns[..=j].iter().map(|column| column[j]);
            sqrt(row.map(|x| x * x).sum())
        } else {
            sqrt(norm(&self.coupling[j]) + norm(&self.independent[j]))
        }
    }

    /// Variance of the difference of two predicted direct measurements, sensor noise not included.
    pub fn difference_variance(&self, [a, b]: [usize; 2]) -> f64 {
        let entries = self.columns[..=a.max(b)].iter();
        let differences = entries.map(|column| column[a] - column[b]);
        differences.map(|x| x * x).sum()
    }

    /// Absorbs the accepted measurements into state and root.
    ///
    /// `innovation` is y - y^ and `std` the measurement noise, which must be positive where accepted.
    #[inline(always)]
    pub fn absorb(
        &mut self,
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
    ) -> Update<N, M> {
        let mut out = Update {
            innovation_root: [[0.0; M]; M],
            gain_root: [[0.0; M]; N],
            whitened: [0.0; M],
        };
        let rotations = self.direct_rotations(innovation, std, accepted, &mut out);
        self.apply_direct(&rotations, &mut out);
        if P::DIRECT.len() < M {
            self.absorb_indirect(&rotations, innovation, std, accepted, &mut out);
        }
        out
    }

    /// Rotations and whitened innovations of the direct measurements.
    ///
    /// Row j of S^- has j + 1 entries. Before its own rotations it undergoes those of the preceding measurements, as
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
        for j in P::DIRECT {
            if !accepted[j] {
                continue;
            }
            let mut row: [f64; M] =
                core::array::from_fn(|i| if i <= j { self.columns[i][j] } else { 0.0 });
            let mut left = innovation[j];
            for i in P::DIRECT.start..j {
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

    /// Rotates the rows of all states at once: lane k is row k, which vectorises.
    #[inline(always)]
    fn apply_direct(&mut self, rotations: &[Rotations<M>; M], out: &mut Update<N, M>) {
        for j in P::DIRECT {
            let mut pivots = [0.0; N];
            // Row j and the rows before it have no entries beyond column j.
            for i in (0..j + 1).rev() {
                let (cosine, sine) = (rotations[j].cosine[i], rotations[j].sine[i]);
                for k in 0..N {
                    let entry = self.columns[i][k];
                    self.columns[i][k] = cosine * entry - sine * pivots[k];
                    pivots[k] = cosine * pivots[k] + sine * entry;
                }
            }
            self.gain(j, &pivots, out);
        }
    }

    /// Corrects the state by measurement `j`, with these entries of K_b.
    #[inline(always)]
    fn gain(&mut self, j: usize, gains: &[f64; N], out: &mut Update<N, M>) {
        let z = out.whitened[j];
        for k in 0..N {
            out.gain_root[k][j] = gains[k];
            self.state[k] += gains[k] * z;
        }
    }

    /// Absorbs the indirect measurements: first their part that no state explains, then the columns of the states.
    #[inline(always)]
    fn absorb_indirect(
        &mut self,
        direct: &[Rotations<M>; M],
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
        out: &mut Update<N, M>,
    ) {
        let mut left = *innovation;
        for p in 0..M {
            if P::DIRECT.contains(&p) {
                continue;
            }
            let mut head = leading(&self.coupling[p]);
            for j in P::DIRECT {
                let gain = direct[j].apply(&mut head, 0.0);
                out.innovation_root[p][j] = gain;
                left[p] -= gain * out.whitened[j];
            }
            set_leading(&mut self.coupling[p], &head);
        }
        for j in 0..M {
            if P::DIRECT.contains(&j) {
                continue;
            }
            if !accepted[j] {
                out.innovation_root[j] = [0.0; M];
                continue;
            }
            let alone = Rotations::of(&self.independent[j], std[j]);
            let shared = Rotations::of(&self.coupling[j], alone.norm);
            out.innovation_root[j][j] = shared.norm;
            out.whitened[j] = left[j] / shared.norm;
            let gains = shared.turn(&mut self.columns);
            self.gain(j, &gains, out);
            for p in j + 1..M {
                if P::DIRECT.contains(&p) {
                    continue;
                }
                let pivot = alone.apply(&mut self.independent[p], 0.0);
                let gain = shared.apply(&mut self.coupling[p], pivot);
                out.innovation_root[p][j] = gain;
                left[p] -= gain * out.whitened[j];
            }
        }
    }
}

/// Rows of a lower-triangular matrix, from its columns.
#[inline(always)]
fn rows<const N: usize>(columns: &[[f64; N]; N]) -> [[f64; N]; N] {
    let mut rows = [[0.0; N]; N];
    for k in 0..N {
        for i in 0..=k {
            rows[k][i] = columns[i][k];
        }
    }
    rows
}

/// The first `K` entries of a row, padded with zeros.
#[inline(always)]
fn leading<const N: usize, const K: usize>(row: &[f64; N]) -> [f64; K] {
    let mut head = [0.0; K];
    for (h, x) in head.iter_mut().zip(row) {
        *h = *x;
    }
    head
}

/// Writes the first `K` entries back into a row.
#[inline(always)]
fn set_leading<const N: usize, const K: usize>(row: &mut [f64; N], head: &[f64; K]) {
    for (x, h) in row.iter_mut().zip(head) {
        *x = *h;
    }
}
