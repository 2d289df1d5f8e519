//! Tests whether parts of the recordings are consistent with one machine.
//!
//! A score test (Rao 1948): with gradient rows J and right side r at the maximum, the information C of all blocks and
//! J_p, r_p of a part, parameter i of that part alone would differ from the common value by
//! ```text
//! d = -j' r_p / V,   j = column i of J_p,   V = j'j - j'J_p C^-1 J_p'j,   variance 1/V
//! ```
//! Swings scatter by more than noise, so V is multiplied by the squared factor f of the jackknife in z. An error e of a held parameter k, with
//! tolerance t and gradient J_k, moves the fit and both sides of the difference, and is no other machine (Schmidt 1966):
//! ```text
//! z = -j' r_p / sqrt(f^2 V + sum_k (t_k j'(J_kp - J_p C^-1 J' J_k))^2)
//! ```

use faer::Mat;

use crate::algebra;
use crate::fit::Fit;
use crate::honesty::Uncertainty;

/// A parameter with a deviating value in one part of the recordings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Number of the part.
    pub part: usize,
    /// The parameter.
    pub parameter: usize,
    /// Difference to the common value, in prior standard deviations.
    pub by: f64,
    /// The same in its own standard deviations.
    pub sizes: f64,
}

/// Differences of these parameters in each part, the most significant first. A part is a set of blocks; `held` are the tolerances of fixed
/// parameters, in prior standard deviations.
pub fn differences(
    fit: &Fit,
    uncertainty: &Uncertainty,
    (fixed, held): (&[bool], &[f64]),
    parts: &[Vec<usize>],
    asked: &[usize],
) -> Vec<Difference> {
    let n = fixed.len();
    let free: Vec<usize> = (0..n).filter(|&i| !fixed[i]).collect();
    let whole = algebra::stacked(&fit.information.iter().collect::<Vec<_>>());
    let product = |rows: &Mat<f64>, i: usize, j: usize| -> f64 {
        (0..rows.nrows()).map(|k| rows[(k, i)] * rows[(k, j)]).sum()
    };
    let curvature = Mat::from_fn(free.len(), free.len(), |a, b| {
        product(&whole, free[a], free[b]) + f64::from(a == b)
    });
    let Some(covariance) = algebra::inverse(&curvature) else {
        return Vec::new();
    };
    // How the fit follows an error of each held parameter.
    let considered: Vec<usize> = (0..n).filter(|&k| fixed[k] && held[k] > 0.0).collect();
    let follows = Mat::from_fn(free.len(), considered.len(), |a, k| {
        held[considered[k]] * product(&whole, free[a], considered[k])
    });
    let follows = &covariance * follows;
    let mut found = Vec::new();
    for (part, blocks) in parts.iter().enumerate() {
        if blocks.is_empty() {
            continue;
        }
        let rows: Vec<_> = blocks.iter().map(|&b| &fit.information[b]).collect();
        let rows = algebra::triangle(&algebra::stacked(&rows));
        for &i in asked.iter().filter(|&&i| !fixed[i]) {
            let across = Mat::from_fn(free.len(), 1, |a, _| product(&rows, i, free[a]));
            let shared = (across.transpose() * &covariance * &across)[(0, 0)];
            let own = product(&rows, i, i);
            let variance = own - shared;
            // A parameter that only this part determines cannot be compared.
            if variance > 1e-6 * own {
                let score = -product(&rows, i, n);
                let moved = across.transpose() * &follows;
                let of_held = considered
                    .iter()
                    .enumerate()
                    .map(|(k, &h)| (held[h] * product(&rows, i, h) - moved[(0, k)]).powi(2));
                let noise = uncertainty.widened.powi(2) * variance;
                let (by, sizes) = (
                    score / variance,
                    score / (noise + of_held.sum::<f64>()).sqrt(),
                );
                found.push(Difference {
                    part,
                    parameter: i,
                    by,
                    sizes,
                });
            }
        }
    }
    found.sort_by(|a, b| b.sizes.abs().total_cmp(&a.sizes.abs()));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks that each measure one parameter once, with this error in units of their noise.
    fn fit(errors: &[f64]) -> Fit {
        let block = |e: &f64| algebra::triangle(&Mat::from_fn(1, 2, |_, j| [10.0, *e][j]));
        Fit {
            place: vec![0.0],
            cost: 0.0,
            information: errors.iter().map(block).collect(),
            interrupted: false,
        }
    }

    fn clearest(errors: &[f64]) -> Option<Difference> {
        let fit = fit(errors);
        let exact = Uncertainty {
            covariance: Mat::zeros(1, 1),
            noise: vec![0.0],
            widened: 1.0,
        };
        let parts = [vec![0, 1, 2, 3], vec![4, 5, 6, 7]];
        let found = differences(&fit, &exact, (&[false], &[0.0]), &parts, &[0]);
        found.first().copied()
    }

    #[test]
    fn halves_that_give_another_value_are_distinguished_and_equal_ones_are_not() {
        let same = clearest(&[1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0]).expect("two parts");
        assert!(same.sizes.abs() < 1e-9, "{same:?}");
        // Four residuals of 3 in each direction: means that differ by 6 noises of 0.1, each known to 0.05.
        let other = clearest(&[3.0, 3.0, 3.0, 3.0, -3.0, -3.0, -3.0, -3.0]).expect("two parts");
        assert!((other.by.abs() - 0.6).abs() < 0.01, "{other:?}");
        assert!(
            (other.sizes.abs() - 0.6 / 0.1 * 2.0_f64.sqrt()).abs() < 0.1,
            "{other:?}"
        );
    }

    #[test]
    fn what_a_held_parameter_explains_within_its_tolerance_is_no_difference() {
        // The held one acts on the second half only, by as much as that half differs.
        let block = |k: usize| {
            let row = match k < 4 {
                true => [10.0, 0.0, 3.0],
                false => [10.0, 10.0, -3.0],
            };
            algebra::triangle(&Mat::from_fn(1, 3, |_, j| row[j]))
        };
        let fit = Fit {
            place: vec![0.0; 2],
            cost: 0.0,
            information: (0..8).map(block).collect(),
            interrupted: false,
        };
        let exact = Uncertainty {
            covariance: Mat::zeros(2, 2),
            noise: vec![0.0; 2],
            widened: 1.0,
        };
        let parts = [vec![0, 1, 2, 3], vec![4, 5, 6, 7]];
        let size = |tolerance: f64| {
            let settings = (&[false, true][..], &[0.0, tolerance][..]);
            let found = differences(&fit, &exact, settings, &parts, &[0]);
            found.first().expect("two parts").sizes.abs()
        };
        assert!(
            size(0.0) > 8.0 && size(0.6) < 1.1,
            "{} {}",
            size(0.0),
            size(0.6)
        );
    }
}
