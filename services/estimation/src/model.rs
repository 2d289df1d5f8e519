//! Interface of a model for the filters: one step of the process and the predicted measurement.

use core::ops::Range;

use crate::scalar::Scalar;

/// A process with `N` states and `M` measurements, additive noise on both.
///
/// Written once for any [`Scalar`]: the square-root UKF evaluates it at sigma points, the EKF differentiates it.
pub trait Model<const N: usize, const M: usize> {
    /// The process changes the first `DYNAMIC` states; the others are random walks, which the filter copies.
    const DYNAMIC: usize = N;

    /// These measurements are the predicted states of the same index themselves.
    const DIRECT: Range<usize> = 0..0;

    /// The process does not depend on the states from `PASSIVE` on; only the measurement does, see [`Model::measure`].
    const PASSIVE: usize = N;

    /// The state one step later, and the measurement made there.
    ///
    /// The state's entries from `DYNAMIC` on, and the measurement's in `DIRECT`, are ignored.
    fn predict<T: Scalar>(&self, state: &[T; N]) -> ([T; N], [T; M]);

    /// Same as `predict`, for a state that differs from a predicted one only from `PASSIVE` on; `center` is that prediction.
    fn measure<T: Scalar>(
        &self,
        state: &[T; N],
        center: &([f64; N], [f64; M]),
    ) -> ([T; N], [T; M]) {
        let _ = center;
        self.predict(state)
    }

    /// Derivative of each measurement with respect to the process noise of the step (Q_Y = G diag(q)).
    ///
    /// Rows in `DIRECT` are ignored. Zero: the measurement does not depend on the noise of its own step.
    fn noise_coupling(&self) -> [[f64; N]; M] {
        [[0.0; N]; M]
    }
}

/// Indices of the measurements that are not states. Not a loop over all with a condition, which would not be unrolled.
pub(crate) fn indirect<P: Model<N, M>, const N: usize, const M: usize>()
-> impl Iterator<Item = usize> {
    let Range { start, end } = P::DIRECT;
    (0..M - (end - start)).map(move |q| if q < start { q } else { q + end - start })
}
