//! Spread and weights of the sigma points, and their pair form.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | alpha, beta, kappa | `alpha`, `beta`, `kappa` | spread parameters of (21), (22) |
//! | Lu | - | alpha^2 (n + kappa) - n |
//! | c = n + Lu | `scale` squared | points at x +- sqrt(c) S\[:, i\] (21) |
//! | w_i | - | weight 1/(2 c) of each outer point (22) |
//!
//! Misprints of (22): w_c0 is w_m0 + (1 - alpha^2 + beta), w_i is 1/(2 c), and i runs to 2n.
//!
//! **Pair form.** With the images Z+ and Z- of the two points of an axis, and Z0 of the centre, c = (Z+ - Z-)/2 and
//! d = (Z+ + Z-)/2 - Z0 give sum of w (Z - Z0)(Z - Z0)' = 2w sum (c c' + d d') over the axes: the covariance about point 0,
//! (23), with positive terms only. It equals the usual scaled covariance with beta = alpha^2, so no downdate exists, and the
//! weight -9999 of the centre at alpha = 0.01 never appears. The mean is Z0 + 2w sum d.

use crate::math::sqrt;

/// Spread parameters of the unscented transformation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Spread {
    /// Distance of the points: 1 is the product's choice, 0.01 the paper's.
    pub alpha: f64,
    /// Weight of the centre in the printed cross covariance; without effect elsewhere.
    pub beta: f64,
    /// Secondary scale, usually 0.
    pub kappa: f64,
}

impl Spread {
    /// Points sqrt(n) standard deviations away, one for n = 1; no weight on the centre.
    pub const UNIT: Self = Self {
        alpha: 1.0,
        beta: 2.0,
        kappa: 0.0,
    };
    /// The paper's choice.
    pub const PAPER: Self = Self {
        alpha: 0.01,
        beta: 2.0,
        kappa: 0.0,
    };

    /// Scale and weights for n states.
    pub fn weights(&self, n: usize) -> Weights {
        let c = self.alpha * self.alpha * (n as f64 + self.kappa);
        let scale = sqrt(c);
        Weights {
            scale,
            odd: 0.5 / scale,
            even: 1.0 / scale,
            mean: 1.0 / c,
        }
    }
}

/// The factors that turn images of sigma points into columns of a root.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Weights {
    /// sqrt(c): the points lie at x +- scale S\[:, i\].
    pub scale: f64,
    /// Column of C: odd (Z+ - Z-).
    pub odd: f64,
    /// Column of D: even ((Z+ + Z-)/2 - Z0).
    pub even: f64,
    /// Mean: Z0 + mean sum ((Z+ + Z-)/2 - Z0).
    pub mean: f64,
}
