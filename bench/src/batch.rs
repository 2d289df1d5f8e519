//! The consistent step of [`estimation::srukf`] for several machines at once: each number becomes a vector with a lane for each
//! machine.
//!
//! The step is generic over any [`Scalar`]. With `f64` it is another form of the single step. With a type of lanes every
//! operation serves all machines, and the dependency chains that bound a single step (a root and a division for each state) are
//! shared. The product does not step machines in this form: it shows the possible gain from lanes. No branch depends on data, so
//! lanes do not wait for each other.
//!
//! Only for models whose measurements are their leading states. A measurement that is missing in one lane has innovation 0 and a
//! large standard deviation there; no operation is skipped.

// Formulas with two indices each are more readable with indices than with iterators.
#![allow(clippy::needless_range_loop)]

use estimation::scalar::Scalar;
use estimation::sigma_points::{Spread, Weights};

/// A process in lanes; the first `M` states are measured.
pub trait LaneModel<T, const N: usize> {
    /// Number of leading states with dynamics; the others are random walks.
    const DYNAMIC: usize;

    /// The state one step later; entries from `DYNAMIC` on are ignored.
    fn predict(&self, state: &[T; N]) -> [T; N];
}

/// The filters of all lanes.
#[derive(Clone, Copy, Debug)]
pub struct BatchUkf<T, const N: usize, const M: usize> {
    /// States.
    pub state: [T; N],
    /// Lower roots of the covariances.
    pub root: [[T; N]; N],
    weights: Weights,
}

/// Columns of the predicted root before it is triangular: odd and even parts of the images, (23) in pair form.
struct Spreads<T, const N: usize> {
    odd: [[T; N]; N],
    even: [[T; N]; N],
}

impl<T: Scalar, const N: usize, const M: usize> BatchUkf<T, N, M> {
    /// Filters at `state` with independent standard deviations.
    #[inline(always)]
    pub fn new(state: [T; N], std: &[T; N], spread: Spread) -> Self {
        let mut root = [[T::constant(0.0); N]; N];
        for (i, row) in root.iter_mut().enumerate() {
            row[i] = std[i];
        }
        Self {
            state,
            root,
            weights: spread.weights(N),
        }
    }

    /// One step of every lane; returns the normalised innovations squared.
    #[inline(always)]
    pub fn step<P: LaneModel<T, N>>(
        &mut self,
        model: &P,
        process_std: &[f64; N],
        measurement: &[T; M],
        measurement_std: &[T; M],
    ) -> T {
        let mut spreads = self.images(model);
        self.triangularise(&mut spreads, process_std);
        let mut nis = T::constant(0.0);
        for j in 0..M {
            let z = self.absorb(j, measurement[j], measurement_std[j]);
            nis = nis + z * z;
        }
        nis
    }

    /// Propagates the sigma points through the model and sets the state to their mean.
    #[inline(always)]
    fn images<P: LaneModel<T, N>>(&mut self, model: &P) -> Spreads<T, N> {
        let zero = T::constant(0.0);
        let mut spreads = Spreads {
            odd: self.root,
            even: [[zero; N]; N],
        };
        let center = model.predict(&self.state);
        let mut shift = [zero; N];
        for i in 0..N {
            let (mut above, mut below) = (self.state, self.state);
            for k in i..N {
                let offset = self.root[k][i] * self.weights.scale;
                above[k] = self.state[k] + offset;
                below[k] = self.state[k] - offset;
            }
            let (plus, minus) = (model.predict(&above), model.predict(&below));
            for k in 0..P::DYNAMIC {
                let bend = ((plus[k] - center[k]) + (minus[k] - center[k])) * 0.5;
                spreads.odd[k][i] = (plus[k] - minus[k]) * self.weights.odd;
                spreads.even[k][i] = bend * self.weights.even;
                shift[k] = shift[k] + bend;
            }
        }
        for k in 0..P::DYNAMIC {
            self.state[k] = center[k] + shift[k] * self.weights.mean;
        }
        spreads
    }

    /// The predicted root by Householder reflections, as in [`estimation::root`].
    #[inline(always)]
    fn triangularise(&mut self, spreads: &mut Spreads<T, N>, process_std: &[f64; N]) {
        for i in 0..N {
            let (odd, even) = (spreads.odd[i], spreads.even[i]);
            let square = dot(&odd, &odd) + dot(&even, &even) + process_std[i] * process_std[i];
            let norm = square.sqrt();
            let pivot = norm + process_std[i];
            let scale = T::constant(1.0) / (norm * pivot).max(T::constant(f64::MIN_POSITIVE));
            self.root[i][i] = norm;
            for k in i + 1..N {
                let along = scale * (dot(&odd, &spreads.odd[k]) + dot(&even, &spreads.even[k]));
                for c in 0..N {
                    spreads.odd[k][c] = spreads.odd[k][c] - along * odd[c];
                    spreads.even[k][c] = spreads.even[k][c] - along * even[c];
                }
                self.root[k][i] = along * pivot;
            }
        }
    }

    /// Updates the root with the measurement of state j by Givens rotations; returns the whitened innovation.
    #[inline(always)]
    fn absorb(&mut self, j: usize, measured: T, std: T) -> T {
        let innovation = measured - self.state[j];
        let (mut sum, mut norm) = (std * std, std);
        let mut pivot = [T::constant(0.0); N];
        for i in (0..=j).rev() {
            let entry = self.root[j][i];
            sum = sum + entry * entry;
            let next = sum.sqrt();
            let reciprocal = T::constant(1.0) / next;
            let (cosine, sine) = (norm * reciprocal, entry * reciprocal);
            for k in i..N {
                let old = self.root[k][i];
                self.root[k][i] = cosine * old - sine * pivot[k];
                pivot[k] = cosine * pivot[k] + sine * old;
            }
            norm = next;
        }
        let z = innovation / norm;
        for k in 0..N {
            self.state[k] = self.state[k] + pivot[k] * z;
        }
        z
    }
}

#[inline(always)]
fn dot<T: Scalar, const N: usize>(a: &[T; N], b: &[T; N]) -> T {
    let mut sum = a[0] * b[0];
    for i in 1..N {
        sum = sum + a[i] * b[i];
    }
    sum
}
