//! Givens rotations that fold one row into its noise, applied to all other rows.
//!
//! A row (e_0 .. e_K) with independent noise s becomes one number, by rotations from its last entry to its first. Each acts on a
//! column and the pivot column, which contains the noise. Triangular rows stay triangular: a row that ends before column i
//! has zeros in column i and in the pivot.
//!
//! Rows that are rotated together are stored column by column: lane k is row k, which vectorises.

#![allow(clippy::needless_range_loop)] // indices as in the formulas

use crate::math::sqrt;
use crate::root::BLOCK;

/// The rotations that fold the leading entries of one row into its noise.
#[derive(Clone, Copy)]
pub(crate) struct Rotations<const K: usize> {
    pub cosine: [f64; K],
    pub sine: [f64; K],
    /// Root of the sum of squares: what remains of the row.
    pub norm: f64,
}

/// Least noise; its square is the smallest that is safely above underflow.
const LEAST: f64 = 1e-150;

impl<const K: usize> Rotations<K> {
    /// Rotations that change nothing, for a measurement that is not used.
    pub const NONE: Self = Self {
        cosine: [1.0; K],
        sine: [0.0; K],
        norm: 0.0,
    };

    /// Folds the row from its last entry to the first. The partial sums come first: the square roots do not wait for each other.
    #[inline(always)]
    pub fn of(row: &[f64; K], std: f64) -> Self {
        let mut rotations = Self::NONE;
        // Zero folded into zero is no rotation; NaN must propagate.
        let std = if std < LEAST { LEAST } else { std };
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
    pub fn apply(&self, row: &mut [f64; K], mut pivot: f64) -> f64 {
        for i in (0..K).rev() {
            let entry = row[i];
            row[i] = self.cosine[i] * entry - self.sine[i] * pivot;
            pivot = self.cosine[i] * pivot + self.sine[i] * entry;
        }
        pivot
    }

    /// Rotates triangular rows, given by their columns; returns their entries in the pivot column, which are zero before.
    #[inline(always)]
    pub fn turn(&self, columns: &mut [[f64; K]; K]) -> [f64; K] {
        let mut pivots = [0.0; K];
        // Row k has no entries beyond column k: the lanes before a block are zero in its columns.
        const { assert!(K <= 4 * BLOCK) }
        self.turn_block::<{ 3 * BLOCK }>(columns, &mut pivots);
        self.turn_block::<{ 2 * BLOCK }>(columns, &mut pivots);
        self.turn_block::<BLOCK>(columns, &mut pivots);
        self.turn_block::<0>(columns, &mut pivots);
        pivots
    }

    #[inline(always)]
    fn turn_block<const FROM: usize>(&self, columns: &mut [[f64; K]; K], pivots: &mut [f64; K]) {
        for i in (FROM..K.min(FROM + BLOCK)).rev() {
            let (cosine, sine) = (self.cosine[i], self.sine[i]);
            for k in FROM..K {
                let entry = columns[i][k];
                columns[i][k] = cosine * entry - sine * pivots[k];
                pivots[k] = cosine * pivots[k] + sine * entry;
            }
        }
    }
}
