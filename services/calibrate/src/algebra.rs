//! Dense linear algebra of a fit, on faer: triangular factors of tall matrices, least squares, singular
//! values, covariances.

use faer::prelude::*;
use faer::{Mat, Side};

/// Square triangular factor of the rows of `tall`; missing rows are filled with zeros.
pub fn triangle(tall: &Mat<f64>) -> Mat<f64> {
    let n = tall.ncols();
    if tall.nrows() < n {
        let filled = Mat::from_fn(
            n,
            n,
            |i, j| {
                if i < tall.nrows() { tall[(i, j)] } else { 0.0 }
            },
        );
        return filled.qr().thin_R().to_owned();
    }
    tall.qr().thin_R().to_owned()
}

/// Stacks the rows of matrices with equal numbers of columns.
pub fn stacked(parts: &[&Mat<f64>]) -> Mat<f64> {
    let columns = parts.first().map_or(0, |p| p.ncols());
    let rows = parts.iter().map(|p| p.nrows()).sum();
    let mut whole = Mat::zeros(rows, columns);
    let mut first = 0;
    for part in parts {
        for i in 0..part.nrows() {
            for j in 0..columns {
                whole[(first + i, j)] = part[(i, j)];
            }
        }
        first += part.nrows();
    }
    whole
}

/// The first `n` columns.
pub fn columns(matrix: &Mat<f64>, n: usize) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), n, |i, j| matrix[(i, j)])
}

/// Solution of `matrix x = right` in the least-squares sense, by QR; zeros where it is singular.
pub fn least_squares(matrix: &Mat<f64>, right: &[f64]) -> Vec<f64> {
    let right = Mat::from_fn(right.len(), 1, |i, _| right[i]);
    let solution = matrix.col_piv_qr().solve_lstsq(&right);
    (0..matrix.ncols())
        .map(|i| solution[(i, 0)])
        .map(|v| if v.is_finite() { v } else { 0.0 })
        .collect()
}

/// Inverse of `root' root`; `None` unless that is positive definite.
pub fn covariance(root: &Mat<f64>) -> Option<Mat<f64>> {
    inverse(&(root.transpose() * root))
}

/// Inverse of a positive definite matrix; `None` for any other.
pub fn inverse(matrix: &Mat<f64>) -> Option<Mat<f64>> {
    let n = matrix.nrows();
    let factor = matrix.llt(Side::Lower).ok()?;
    let inverse = factor.solve(Mat::<f64>::identity(n, n));
    let finite = (0..n).all(|j| (0..n).all(|i| inverse[(i, j)].is_finite()));
    finite.then_some(inverse)
}

/// `L^-1 matrix` where `covariance` is `L L'`; `None` unless it is positive definite.
pub fn whitened(covariance: &Mat<f64>, matrix: &Mat<f64>) -> Option<Mat<f64>> {
    let factor = covariance.llt(Side::Lower).ok()?;
    let mut whitened = matrix.clone();
    factor.L().solve_lower_triangular_in_place(&mut whitened);
    Some(whitened)
}

/// Singular values, largest first, each with its direction in the space of the columns.
pub fn directions(matrix: &Mat<f64>) -> Vec<(f64, Vec<f64>)> {
    let Ok(svd) = matrix.thin_svd() else {
        return Vec::new();
    };
    let values = svd.S().column_vector();
    (0..values.nrows())
        .map(|k| {
            let direction = (0..matrix.ncols()).map(|i| svd.V()[(i, k)]).collect();
            (values[k], direction)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_triangle_has_the_same_products_as_the_rows() {
        let tall = Mat::from_fn(7, 3, |i, j| ((i * 3 + j * j) as f64).sin());
        let (a, b) = (triangle(&tall), tall.transpose() * &tall);
        let c = a.transpose() * &a;
        assert!((0..3).all(|i| (0..3).all(|j| (b[(i, j)] - c[(i, j)]).abs() < 1e-12)));
        assert_eq!(triangle(&Mat::zeros(1, 3)).nrows(), 3);
    }

    #[test]
    fn a_line_is_found_and_a_singular_direction_left_alone() {
        let line = Mat::from_fn(5, 2, |i, j| if j == 0 { 1.0 } else { i as f64 });
        let found = least_squares(&line, &[1.0, 3.0, 5.0, 7.0, 9.0]);
        assert!((found[0] - 1.0).abs() < 1e-12 && (found[1] - 2.0).abs() < 1e-12);
        let same = Mat::from_fn(4, 2, |i, _| i as f64);
        assert!(directions(&same)[1].0 < 1e-12);
    }

    #[test]
    fn what_is_whitened_has_the_products_of_the_inverse() {
        let covariance = Mat::from_fn(3, 3, |i, j| if i == j { 2.0 } else { 0.5 });
        let matrix = Mat::from_fn(3, 2, |i, j| (1 + i * 2 + j) as f64);
        let white = whitened(&covariance, &matrix).unwrap();
        let expected = matrix.transpose() * inverse(&covariance).unwrap() * &matrix;
        let difference = white.transpose() * &white - expected;
        assert!(difference.norm_max() < 1e-12);
        assert!(whitened(&Mat::zeros(3, 3), &matrix).is_none());
    }
}
