//! The consistent step of [`estimation::srukf`] for several machines at once: one number of a machine becomes one number for each.
//!
//! Written over any [`Scalar`]. With `f64` it is one more form of the single step; with a type that holds a lane for each machine every
//! operation serves all of them, and the dependency chains that bound a single step (a root and a division for each state) are
//! paid once for all. No product steps machines so: it is what lanes could give. There is no selection by data, so lanes do not wait for each other.
//!
//! Only for models whose measurements are their leading states. A measurement that is missing in one lane has innovation 0 and
//! a large standard deviation there; nothing is left out.

// Formulas with two indices each read better with them than with iterators.
#![allow(clippy::needless_range_loop)]

use estimation::scalar::Scalar;
use estimation::sigma_points::{Spread, Weights};

/// A process in lanes; the first `M` states are measured.
pub trait LaneModel<T, const N: usize> {
    /// The process changes the first `DYNAMIC` states; the others are random walks.
    const DYNAMIC: usize;

    /// The state one step later; entries from `DYNAMIC` on are not looked at.
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

    /// Sends the sigma points through the model and moves the state to their mean.
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

    /// The predicted root by Householder reflections, as [`estimation::root`] does it.
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

    /// Folds the measurement of state j into the root by Givens rotations, and returns the whitened innovation.
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
