//! Images of the sigma points, and their triangularisation to a predicted root.
//!
//! ```text
//! [ C  D  Q ]        [ L ]        rows of the states that move
//! [ S  0  Q ]   =>   [   ]        rows of those that stand still: S is the root before the step, triangular
//! ```
//! C and D are the odd and even parts of the images ([`crate::sigma_points`]), Q the process noise. A state that stands still has no
//! even part and retains its row of the root. Moving rows therefore come first. A reflection folds D and Q of a row into one number; it
//! affects the moving rows and the measurements only. Rotations then fold C in, and leave S triangular. Afterwards row i of a state
//! that stands still has i + 1 entries and its noise, which one reflection folds into one number. A textbook QR of the whole array
//! takes more than twice as many operations.
//!
//! The rows that stand still are stored side by side, column by column, see `rotations`.

#![allow(clippy::needless_range_loop)] // indices as in the formulas

use core::array::from_mut;
use core::marker::PhantomData;

use crate::model::{Model, indirect};
use crate::prediction::Prediction;
use crate::root::{BLOCK, Reflection, Row, triangularise_rest};
use crate::rotations::Rotations;

/// Means and deviations before they are triangularised.
///
/// The process noise is added only afterwards, so it may depend on the predicted state.
pub struct Images<P, const N: usize, const M: usize> {
    /// Predicted state.
    pub state: [f64; N],
    /// Predicted measurement.
    pub measurement: [f64; M],
    /// Rows \[C D\] of the states that move.
    pub(crate) moving: [Row<N, 2>; N],
    /// Rows of the states that stand still, column by column.
    pub(crate) still: [[f64; N]; N],
    /// Rows \[C D\] of the indirect measurements.
    pub(crate) measured: [Row<N, 2>; M],
    /// Derivative of the measurements with respect to the process noise.
    pub(crate) noise_coupling: [[f64; N]; M],
    /// Distance of the states' means from the image of the centre.
    pub(crate) shift: [f64; N],
    pub(crate) model: PhantomData<fn(&P)>,
}

impl<P: Model<N, M>, const N: usize, const M: usize> Images<P, N, M> {
    /// Adds the process noise of the step and triangularises.
    #[inline(always)]
    pub fn predict(&mut self, process_std: &[f64; N]) -> Prediction<P, N, M> {
        let mut prediction = Prediction {
            state: self.state,
            measurement: self.measurement,
            columns: [[0.0; N]; N],
            coupling: [[0.0; N]; M],
            independent: [[0.0; M]; M],
            model: PhantomData,
        };
        for p in indirect::<P, N, M>() {
            for i in 0..N {
                prediction.coupling[p][i] = self.noise_coupling[p][i] * process_std[i];
            }
        }
        for i in 0..P::DYNAMIC {
            self.fold_moving(i, process_std[i], &mut prediction);
        }
        for i in P::DYNAMIC..N {
            self.reflect_still(i, process_std[i], &mut prediction);
        }
        triangularise_rest(&mut self.measured, &mut prediction.independent, P::DIRECT);
        prediction
    }

    /// Column `i` of the predicted root, of a state that moves.
    #[inline(always)]
    fn fold_moving(&mut self, i: usize, std: f64, into: &mut Prediction<P, N, M>) {
        let [odd, even] = self.moving[i];
        let (reflection, noise) = Reflection::of(&[even], std);
        let rotations = Rotations::of(&odd, noise);
        let pivots = rotations.turn(&mut self.still);
        into.columns[i] = pivots;
        into.columns[i][..P::DYNAMIC].fill(0.0);
        into.columns[i][i] = rotations.norm;
        for k in i + 1..P::DYNAMIC {
            let [odd, even] = &mut self.moving[k];
            let entry = reflection.apply(from_mut(even), 0.0);
            into.columns[i][k] = rotations.apply(odd, entry);
        }
        for p in indirect::<P, N, M>() {
            let [odd, even] = &mut self.measured[p];
            let entry = reflection.apply(from_mut(even), into.coupling[p][i]);
            into.coupling[p][i] = rotations.apply(odd, entry);
        }
    }

    /// Column `i` of the predicted root, of a state that stands still.
    #[inline(always)]
    fn reflect_still(&mut self, i: usize, std: f64, into: &mut Prediction<P, N, M>) {
        // Row i ends at column i.
        const { assert!(N <= 4 * BLOCK) }
        match i / BLOCK {
            // A small root is reflected whole: choosing costs more.
            _ if N <= 2 * BLOCK => self.reflect_leading(N, i, std, into),
            0 => self.reflect_leading(N.min(BLOCK), i, std, into),
            1 => self.reflect_leading(N.min(2 * BLOCK), i, std, into),
            2 => self.reflect_leading(N.min(3 * BLOCK), i, std, into),
            _ => self.reflect_leading(N, i, std, into),
        }
    }

    /// The same; row `i` ends before column `to`.
    #[inline(always)]
    fn reflect_leading(&mut self, to: usize, i: usize, std: f64, into: &mut Prediction<P, N, M>) {
        let row: [f64; N] = core::array::from_fn(|c| if c < to { self.still[c][i] } else { 0.0 });
        let (reflection, norm) = Reflection::of_leading(to, &[row], std);
        let column = reflection.apply_lanes(&mut self.still, i);
        into.columns[i][i] = norm;
        into.columns[i][i + 1..].copy_from_slice(&column[i + 1..]);
        for p in indirect::<P, N, M>() {
            let odd = from_mut(&mut self.measured[p][0]);
            into.coupling[p][i] = reflection.apply_leading(to, odd, into.coupling[p][i]);
        }
    }
}
