//! Triangular roots: L lower with positive diagonal and L L' = A A', for the arrays that square-root filters meet.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | A = \[C D diag(q)\] | `rows`, `diagonal` | one row per state: `B` blocks of `W` columns, then independent noise |
//! | L | result | lower-triangular root, L L' = C C' + D D' + diag(q)^2 |
//!
//! A textbook QR of \[C D diag(q)\]' spends most of its work on the zeros of diag(q). Here column i of the diagonal is the
//! pivot of row i. No other row uses it before or afterwards, so a reflection only
//! works on the dense blocks and on one further number per row. Each reflection maps (q_i, c, d) to (-norm, 0, 0). q_i is
//! never negative, so the pivot is formed without cancellation; the sign is reversed afterwards.
//!
//! This is no rank-revealing factorisation. A row of zeros gives a zero on the diagonal.

#![allow(clippy::needless_range_loop)] // indices as in the formulas

use core::ops::Range;

use crate::math::sqrt;

/// One row of the dense part: `B` blocks of `W` columns.
pub type Row<const W: usize, const B: usize> = [[f64; W]; B];

/// Scalar product as two independent partial sums, so that it vectorises; the order is fixed.
///
/// The sums start with the first products instead of zeros: every reflection waits for this sum.
#[inline(always)]
pub(crate) fn dot<const W: usize, const B: usize>(a: &Row<W, B>, b: &Row<W, B>) -> f64 {
    dot_to(W, a, b)
}

/// Scalar product of rows whose blocks are zero from entry `to` on.
#[inline(always)]
fn dot_to<const W: usize, const B: usize>(to: usize, a: &Row<W, B>, b: &Row<W, B>) -> f64 {
    let mut even = a[0][0] * b[0][0];
    let mut odd = if to > 1 { a[0][1] * b[0][1] } else { 0.0 };
    for c in 0..B {
        let mut i = if c == 0 { 2 } else { 0 };
        while i + 1 < to {
            even += a[c][i] * b[c][i];
            odd += a[c][i + 1] * b[c][i + 1];
            i += 2;
        }
        if i < to {
            even += a[c][i] * b[c][i];
        }
    }
    even + odd
}

/// Number of lanes that are skipped together where they are zero.
pub(crate) const BLOCK: usize = 4;

/// A Householder reflection that sends (pivot, row) to (-norm, 0).
#[derive(Clone, Copy)]
pub(crate) struct Reflection<const W: usize, const B: usize> {
    row: Row<W, B>,
    pivot: f64,
    scale: f64,
}

impl<const W: usize, const B: usize> Reflection<W, B> {
    /// The reflection and the norm it leaves.
    #[inline(always)]
    pub fn of(row: &Row<W, B>, pivot: f64) -> (Self, f64) {
        Self::of_leading(W, row, pivot)
    }

    /// The same of a row that is zero from entry `to` on.
    #[inline(always)]
    pub fn of_leading(to: usize, row: &Row<W, B>, pivot: f64) -> (Self, f64) {
        let norm = sqrt(pivot * pivot + dot_to(to, row, row));
        let pivot = pivot + norm;
        // A row of zeros needs no reflection: the guard keeps its scale finite.
        let scale = 1.0 / (norm * pivot).max(f64::MIN_POSITIVE);
        (
            Self {
                row: *row,
                pivot,
                scale,
            },
            norm,
        )
    }

    /// Reflects another row, whose entry in the pivot column is `entry`; returns the new entry, sign reversed.
    #[inline(always)]
    pub fn apply(&self, row: &mut Row<W, B>, entry: f64) -> f64 {
        self.apply_leading(W, row, entry)
    }

    /// The same for a reflection of a row that is zero from entry `to` on.
    #[inline(always)]
    pub fn apply_leading(&self, to: usize, row: &mut Row<W, B>, entry: f64) -> f64 {
        let along = self.scale * (self.pivot * entry + dot_to(to, &self.row, row));
        for (x, v) in row.iter_mut().zip(&self.row) {
            for i in 0..to {
                x[i] -= along * v[i];
            }
        }
        along * self.pivot - entry
    }
}

impl<const N: usize> Reflection<N, 1> {
    /// Reflects rows `i + 1..`, stored side by side by their columns, where row `i` ends at column `i`. Returns their new entries
    /// in the pivot column, which are zero before. The contents of the other rows are undefined afterwards.
    #[inline(always)]
    pub fn apply_lanes(&self, columns: &mut [[f64; N]; N], i: usize) -> [f64; N] {
        const { assert!(N <= 4 * BLOCK) }
        match (i + 1) / BLOCK {
            0 => self.apply_from::<0>(columns, i),
            1 => self.apply_from::<BLOCK>(columns, i),
            2 => self.apply_from::<{ 2 * BLOCK }>(columns, i),
            _ => self.apply_from::<{ 3 * BLOCK }>(columns, i),
        }
    }

    #[inline(always)]
    fn apply_from<const FROM: usize>(&self, columns: &mut [[f64; N]; N], i: usize) -> [f64; N] {
        let [row] = &self.row;
        let mut along = [0.0; N];
        for (column, x) in columns.iter().zip(row).take(i + 1) {
            for k in FROM..N {
                along[k] += x * column[k];
            }
        }
        along = along.map(|sum| self.scale * sum);
        for (column, x) in columns.iter_mut().zip(row).take(i + 1) {
            for k in FROM..N {
                column[k] -= along[k] * x;
            }
        }
        along.map(|along| along * self.pivot)
    }
}

/// Lower-triangular L with L L' = C C' + D D' + diag(q)^2; overwrites `rows`.
///
/// `diagonal` must not be negative. The diagonal of L is not negative.
#[inline]
pub fn triangularise<const R: usize, const W: usize, const B: usize>(
    rows: &mut [Row<W, B>; R],
    diagonal: &[f64; R],
) -> [[f64; R]; R] {
    let mut root = [[0.0; R]; R];
    for i in 0..R {
        let (reflection, norm) = Reflection::of(&rows[i], diagonal[i]);
        root[i][i] = norm;
        for k in i + 1..R {
            root[k][i] = reflection.apply(&mut rows[k], 0.0);
        }
    }
    root
}

/// Lower-triangular root of the rows outside `skipped`, which have no diagonal; written into `root`, which must be zero.
#[inline(always)]
pub(crate) fn triangularise_rest<const P: usize, const W: usize, const B: usize>(
    rows: &mut [Row<W, B>; P],
    root: &mut [[f64; P]; P],
    skipped: Range<usize>,
) {
    for i in 0..P {
        if skipped.contains(&i) {
            continue;
        }
        let (reflection, norm) = Reflection::of(&rows[i], 0.0);
        root[i][i] = norm;
        for k in i + 1..P {
            if !skipped.contains(&k) {
                root[k][i] = reflection.apply(&mut rows[k], 0.0);
            }
        }
    }
}

/// Solves L x = b for lower-triangular L, in place.
pub fn solve_lower<const R: usize>(root: &[[f64; R]; R], b: &mut [f64; R]) {
    for i in 0..R {
        let known: f64 = (0..i).map(|j| root[i][j] * b[j]).sum();
        b[i] = (b[i] - known) / root[i][i];
    }
}

/// Solves L' x = b for lower-triangular L, in place.
pub fn solve_lower_transposed<const R: usize>(root: &[[f64; R]; R], b: &mut [f64; R]) {
    for i in (0..R).rev() {
        let known: f64 = (i + 1..R).map(|j| root[j][i] * b[j]).sum();
        b[i] = (b[i] - known) / root[i][i];
    }
}
