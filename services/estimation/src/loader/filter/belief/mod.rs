//! Belief of a filter: its state and uncertainty, and their change in the model's step. That is by sigma points on a covariance root
//! (`sigma_points`), or by the model's tangent on the covariance (`tangent`).
//!
//! All other parts of a row (inputs, conditions, noise, gates, verdict) are in [`super::CgFilter`], and the same for both.

use core::fmt::Debug;

use crate::loader::physics::cg_model::CgModel;
use crate::math::sqrt;
use crate::sigma_points::Spread;
use crate::srukf::SquareRootUkf;

mod sigma_points;
mod tangent;

/// A state with its uncertainty.
pub(in crate::loader) trait Belief<const N: usize, const M: usize>:
    Copy + Debug
{
    /// Result of the model's step, before its noise.
    type Ahead;
    /// Measurements predicted from it.
    type Expected;

    /// Belief at `state`, with independent standard deviations.
    fn new(state: [f64; N], std: &[f64; N], spread: Spread) -> Self;

    fn state(&self) -> &[f64; N];
    fn state_mut(&mut self) -> &mut [f64; N];

    /// Variance of a state.
    fn variance(&self, i: usize) -> f64;

    /// Whether all numbers are finite, and every variance is positive.
    fn is_sound(&self) -> bool;

    /// Resets each of these states to a standard deviation of its own, uncorrelated with the others. The others get process noise.
    fn separate(&mut self, states: &[(usize, f64)], process_std: &[f64; N]);

    /// Computes one step of the model; the belief itself stays.
    fn ahead(&self, model: &CgModel) -> Self::Ahead;

    /// State after that step.
    fn state_ahead(ahead: &Self::Ahead) -> &[f64; N];

    /// Applies the step, with process noise.
    fn predict(
        &mut self,
        ahead: &mut Self::Ahead,
        model: &CgModel,
        process_std: &[f64; N],
    ) -> Self::Expected;

    /// Predicted measurement.
    fn measurement(expected: &Self::Expected) -> &[f64; M];

    /// Standard deviation of the predicted measurement, sensor noise not included.
    fn measurement_std(expected: &Self::Expected, j: usize) -> f64;

    /// Variance of the predicted difference of two measurements that are states, sensor noise not included.
    fn difference_variance(expected: &Self::Expected, of: [usize; 2]) -> f64;

    /// Updates with the accepted measurements; returns the normalised innovation squared.
    fn update(
        &mut self,
        expected: &mut Self::Expected,
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
    ) -> f64;

    /// Returns the sigma-point filter, which can step as the paper prints it.
    fn sigma_points(&mut self) -> Option<&mut SquareRootUkf<N, M>>;

    /// Standard deviation of a state.
    fn std(&self, i: usize) -> f64 {
        sqrt(self.variance(i).max(0.0))
    }
}
