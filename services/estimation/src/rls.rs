//! Recursive least squares, two kinds.
//!
//! [`MultipleForgettingRls`] gives every parameter its own forgetting factor (Oh, Yi, Seo, Kim, Lee
//! 2017, Eqs. 13-27, after Vahidi). It is **not** ordinary RLS with equal factors: each parameter
//! keeps a scalar variance and the parameters meet only in the innovation. [`Rls`] is the ordinary
//! one: one factor, full covariance.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | phi | `regressor` | column of known signals |
//! | theta | `parameters` | what is estimated |
//! | y | `output` | measured combination of them |
//! | lambda_i | `forgetting` | forgetting factor of parameter i, in (0, 1] |
//! | P_i, P | `variance`, `covariance` | uncertainty in units of the output's variance |
//!
//! Misprints of the source corrected here: rows and columns mixed in Eqs. 13-15 (columns); true
//! parameters inside the cost of Eq. 16 (estimates, Eq. 23); the regressor missing in the right-hand
//! sums of Eq. 18; L_i for L_i(k) in Eq. 19; matrix notation for the scalars of Eqs. 20-22.

use nalgebra::{SMatrix, SVector};

/// Limit of a variance. Beyond it a variance carries no information and only loses digits; without excitation of its parameter it
/// would grow without bound.
const VARIANCE_LIMIT: f64 = 1e14;

/// Recursive least squares with one forgetting factor per parameter.
///
/// ```
/// use estimation::rls::MultipleForgettingRls;
///
/// let mut line = MultipleForgettingRls::new([0.0, 0.0], [1e6, 1e6]);
/// for row in 0..400 {
///     let x = f64::from(row % 7);
///     line.update(&[x, 1.0], 3.0 * x - 2.0, &[0.99, 0.95]);
/// }
/// assert!((line.parameters[0] - 3.0).abs() < 1e-3 && (line.parameters[1] + 2.0).abs() < 1e-3);
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MultipleForgettingRls<const N: usize> {
    /// Current parameters.
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    pub parameters: [f64; N],
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    variance: [f64; N],
}

impl<const N: usize> MultipleForgettingRls<N> {
    /// Starts at `parameters` with the scalar variances P_i.
    pub fn new(parameters: [f64; N], variance: [f64; N]) -> Self {
        Self {
            parameters,
            variance,
        }
    }

    /// The scalar variances P_i.
    pub fn variance(&self) -> [f64; N] {
        self.variance
    }

    /// Takes in one sample and returns its innovation `y - phi . theta`.
    ///
    /// Closed form of Eq. 26 by the matrix determinant lemma: with D_i = P_i / lambda_i the joint
    /// solution is a gain D_i phi_i / (1 + sum D_j phi_j^2). There is no singular case.
    #[inline]
    pub fn update(&mut self, regressor: &[f64; N], output: f64, forgetting: &[f64; N]) -> f64 {
        let (mut d, mut spread) = ([0.0; N], [0.0; N]);
        let (mut innovation, mut s) = (output, 1.0);
        for i in 0..N {
            d[i] = self.variance[i] / forgetting[i];
            // From the squared regressor: this sum does not wait for the previous step, as the variance does.
            let own = d[i] * (regressor[i] * regressor[i]);
            spread[i] = 1.0 + own;
            s += own;
            innovation -= regressor[i] * self.parameters[i];
        }
        let share = innovation / s;
        for i in 0..N {
            self.parameters[i] += d[i] * regressor[i] * share; // (26)
            self.variance[i] = (d[i] / spread[i]).min(VARIANCE_LIMIT); // (22)
        }
        innovation
    }
}

impl MultipleForgettingRls<3> {
    /// The same step by solving Eq. 26 as printed: unit diagonal, L_i phi_j off the diagonal.
    ///
    /// With g_i = L_i phi_i and theta_i = old theta_i + L_i u_i the system becomes u_i + sum_{j != i} g_j u_j = e. The
    /// differences of its rows give (1 - g_i) u_i = m for all i, and m = e / (1 + sum g_i / (1 - g_i)): the determinant of Eq. 27, which
    /// the source only refers to, over prod (1 - g_i). 1 - g_i is positive, but loses its digits as P_i phi_i^2 grows; it is
    /// bounded away from zero. [`update`](Self::update) loses no digits there.
    #[inline]
    pub fn update_by_solve(
        &mut self,
        regressor: &[f64; 3],
        output: f64,
        forgetting: &[f64; 3],
    ) -> f64 {
        let mut step = [0.0; 3];
        let (mut innovation, mut determinant) = (output, 1.0);
        for i in 0..3 {
            let scaled = self.variance[i] * regressor[i];
            let spread = forgetting[i] + scaled * regressor[i];
            let gain = scaled / spread; // (20)
            step[i] = gain / (1.0 - gain * regressor[i]).max(f64::EPSILON);
            determinant += step[i] * regressor[i]; // (27)
            innovation -= regressor[i] * self.parameters[i];
            self.variance[i] = (self.variance[i] / spread).min(VARIANCE_LIMIT); // (22)
        }
        let m = innovation / determinant;
        for (parameter, step) in self.parameters.iter_mut().zip(step) {
            *parameter += step * m; // (26)
        }
        innovation
    }
}

/// Ordinary recursive least squares: one forgetting factor, full covariance.
///
/// ```
/// use estimation::rls::Rls;
///
/// let mut line = Rls::new([0.0, 0.0], [1e6, 1e6]);
/// for row in 0..20 {
///     let x = f64::from(row);
///     line.update(&[x, 1.0], 3.0 * x - 2.0, 1.0);
/// }
/// assert!((line.parameters[0] - 3.0).abs() < 1e-4 && (line.parameters[1] + 2.0).abs() < 1e-3);
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rls<const N: usize> {
    /// Current parameters.
    pub parameters: SVector<f64, N>,
    covariance: SMatrix<f64, N, N>,
    limit: SVector<f64, N>,
}

impl<const N: usize> Rls<N> {
    /// Starts at `parameters`; `variance` are the prior variances in units of the output's noise
    /// variance. Forgetting never raises a parameter's variance above its prior. A prior of 0 holds
    /// a parameter fixed.
    pub fn new(parameters: [f64; N], variance: [f64; N]) -> Self {
        let limit = SVector::from(variance);
        Self {
            parameters: parameters.into(),
            covariance: SMatrix::from_diagonal(&limit),
            limit,
        }
    }

    /// Covariance in units of the output's noise variance.
    pub fn covariance(&self) -> &SMatrix<f64, N, N> {
        &self.covariance
    }

    /// Forgets as after samples without excitation whose forgetting factors have the product `factor`.
    pub fn forget(&mut self, factor: f64) {
        self.covariance /= factor;
        self.bound();
    }

    /// Takes in one sample and returns its innovation.
    pub fn update(&mut self, regressor: &[f64; N], output: f64, forgetting: f64) -> f64 {
        let phi = SVector::<f64, N>::from(*regressor);
        let p_phi = self.covariance * phi;
        let innovation = output - phi.dot(&self.parameters);
        let gain = p_phi / (forgetting + phi.dot(&p_phi));
        self.parameters += gain * innovation;
        let updated = (self.covariance - gain * p_phi.transpose()) / forgetting;
        self.covariance = (updated + updated.transpose()) * 0.5;
        self.bound();
        innovation
    }

    /// Scales rows and columns back where forgetting without excitation has raised a variance
    /// above the prior.
    fn bound(&mut self) {
        for i in 0..N {
            let variance = self.covariance[(i, i)];
            if variance > self.limit[i] {
                let scale = crate::math::sqrt(self.limit[i] / variance);
                self.covariance.row_mut(i).scale_mut(scale);
                self.covariance.column_mut(i).scale_mut(scale);
            }
        }
    }
}
