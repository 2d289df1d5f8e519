//! What a filter believes, a state and how uncertain it is, and how the model's step changes it: by sigma points on a covariance
//! root (`sigma_points`), or by the model's tangent on the covariance (`tangent`).
//!
//! All else of a row (inputs, conditions, noise, gates, verdict) is [`super::CgFilter`]'s and the same for both.

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
    /// The step of the model before its noise.
    type Ahead;
    /// The measurements that follow from it.
    type Expected;

    /// At `state`, with independent standard deviations.
    fn new(state: [f64; N], std: &[f64; N], spread: Spread) -> Self;

    fn state(&self) -> &[f64; N];
    fn state_mut(&mut self) -> &mut [f64; N];

    /// Variance of a state.
    fn variance(&self, i: usize) -> f64;

    /// Finite, and every variance positive.
    fn is_sound(&self) -> bool;

    /// These states are known anew, each with a standard deviation, and nothing of them is known by the others, which get
    /// process noise.
    fn separate(&mut self, states: &[(usize, f64)], process_std: &[f64; N]);

    /// One step of the model; the belief itself stays.
    fn ahead(&self, model: &CgModel) -> Self::Ahead;

    /// The state after that step.
    fn state_ahead(ahead: &Self::Ahead) -> &[f64; N];

    /// Takes the step, with process noise.
    fn predict(
        &mut self,
        ahead: &mut Self::Ahead,
        model: &CgModel,
        process_std: &[f64; N],
    ) -> Self::Expected;

    /// The predicted measurement.
    fn measurement(expected: &Self::Expected) -> &[f64; M];

    /// Its standard deviation, sensor noise not included.
    fn measurement_std(expected: &Self::Expected, j: usize) -> f64;

    /// Variance of the predicted difference of two measurements that are states, sensor noise not included.
    fn difference_variance(expected: &Self::Expected, of: [usize; 2]) -> f64;

    /// Absorbs the accepted measurements; returns the normalised innovation squared.
    fn update(
        &mut self,
        expected: &mut Self::Expected,
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
    ) -> f64;

    /// The filter that can step as the paper prints it.
    fn sigma_points(&mut self) -> Option<&mut SquareRootUkf<N, M>>;

    /// Standard deviation of a state.
    fn std(&self, i: usize) -> f64 {
        sqrt(self.variance(i).max(0.0))
    }
}
