//! Square-root unscented Kalman filter on any [`Model`]: the consistent step, and the improved SR-UKF of Yang, Wang, Han
//! 2021 exactly as printed.
//!
//! ```text
//! X_0 = x, X_i = x + sqrt(c) S[:,i], X_(n+i) = x - sqrt(c) S[:,i]        (21)
//! Z = f(X),  x^- = Z_0 + w sum (Z_i - Z_0)                                (23), mean without cancellation
//! D = sqrt(w) [Z_i - Z_0]                                                 (23), referenced to point 0
//! ```
//! The *consistent* step continues as [`crate::prediction`] describes: gain and covariance come from one factor. The
//! *printed* step, [`SquareRootUkf::step_printed`], takes S_y from the propagated points without process noise (26) but
//! S^- with it (28): its gain and its covariance disagree, by some 10 % in the gain.
//!
//! The sigma points are not redrawn after the process noise is added. For linear measurements both agree.

#![allow(clippy::needless_range_loop)] // indices as in the formulas

use crate::model::{Model, indirect};
use crate::pair::Pair;
use core::marker::PhantomData;

use crate::images::Images;
use crate::prediction::Prediction;
use crate::root::{Row, solve_lower, solve_lower_transposed, triangularise};
use crate::scalar::Scalar;
use crate::sigma_points::{Spread, Weights};

/// Placeholder of rows that are neither written nor read: states that stand still, direct measurements. Zeros would be written bytewise.
const UNWRITTEN: f64 = f64::NAN;

/// The filter: a state and the lower root of its covariance.
///
/// ```
/// use estimation::srukf::SquareRootUkf;
/// use estimation::model::Model;
/// use estimation::scalar::Scalar;
/// use estimation::sigma_points::Spread;
///
/// /// A cart at a steady speed whose place is measured each second.
/// struct Cart;
/// impl Model<2, 1> for Cart {
///     fn predict<T: Scalar>(&self, [place, speed]: &[T; 2]) -> ([T; 2], [T; 1]) {
///         ([*place + *speed, *speed], [*place + *speed])
///     }
/// }
///
/// let mut filter = SquareRootUkf::<2, 1>::new([0.0, 0.0], &[10.0, 10.0], Spread::UNIT);
/// for row in 1..=50 {
///     filter.step(&Cart, &[1e-3, 1e-3], &[2.0 * f64::from(row)], &[0.1]);
/// }
/// assert!((filter.state[1] - 2.0).abs() < 1e-3);
/// ```
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SquareRootUkf<const N: usize, const M: usize> {
    /// State x.
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    pub state: [f64; N],
    /// Lower root S of the covariance, P = S S'.
    #[cfg_attr(feature = "serde", serde(with = "crate::written::rows"))]
    pub root: [[f64; N]; N],
    spread: Spread,
    weights: Weights,
}

impl<const N: usize, const M: usize> SquareRootUkf<N, M> {
    /// A filter at `state` with independent standard deviations.
    pub fn new(state: [f64; N], std: &[f64; N], spread: Spread) -> Self {
        let mut root = [[0.0; N]; N];
        for (i, row) in root.iter_mut().enumerate() {
            row[i] = std[i];
        }
        Self::with_root(state, root, spread)
    }

    /// A filter at `state` with a lower-triangular covariance root.
    pub fn with_root(state: [f64; N], root: [[f64; N]; N], spread: Spread) -> Self {
        Self {
            state,
            root,
            spread,
            weights: spread.weights(N),
        }
    }

    /// The spread of the sigma points.
    pub fn spread(&self) -> Spread {
        self.spread
    }

    /// Predicts one step; `process_std` is the additive process noise of the step.
    #[inline]
    pub fn predict<P: Model<N, M>>(
        &self,
        model: &P,
        process_std: &[f64; N],
    ) -> Prediction<P, N, M> {
        self.images(model).predict(process_std)
    }

    /// Takes over the state and root of an updated prediction.
    #[inline(always)]
    pub fn accept<P: Model<N, M>>(&mut self, updated: &Prediction<P, N, M>) {
        self.state = updated.state;
        // Entries beyond the diagonal stay zero.
        for (k, row) in self.root.iter_mut().enumerate() {
            for (x, column) in row.iter_mut().zip(&updated.columns).take(k + 1) {
                *x = column[k];
            }
        }
    }

    /// One consistent step with every measurement present; returns the normalised innovation squared.
    #[inline]
    pub fn step<P: Model<N, M>>(
        &mut self,
        model: &P,
        process_std: &[f64; N],
        measurement: &[f64; M],
        measurement_std: &[f64; M],
    ) -> f64 {
        let mut prediction = self.predict(model, process_std);
        let innovation = core::array::from_fn(|j| measurement[j] - prediction.measurement[j]);
        let update = prediction.absorb(&innovation, measurement_std, &[true; M]);
        self.accept(&prediction);
        update.nis()
    }

    /// Passes the sigma points through the model: the prediction before the process noise is added.
    #[inline(always)]
    pub fn images<P: Model<N, M>>(&self, model: &P) -> Images<P, N, M> {
        let center = model.predict(&self.state);
        let mut images = Images {
            state: self.state,
            measurement: center.1,
            moving: [[[UNWRITTEN; N]; 2]; N],
            still: core::array::from_fn(|i| {
                let from = i.max(P::DYNAMIC);
                core::array::from_fn(|k| if k < from { 0.0 } else { self.root[k][i] })
            }),
            measured: [[[UNWRITTEN; N]; 2]; M],
            noise_coupling: model.noise_coupling(),
            shift: [0.0; N],
            model: PhantomData,
        };
        let mut shift_measured = [0.0; M];
        // Both points of an axis at once, one per lane. Row k of the root ends at column k: the states before i are those of the centre.
        let mut points = self.state.map(Pair::constant);
        for i in 0..N {
            for k in i..N {
                let offset = self.weights.scale * self.root[k][i];
                points[k] = Pair([self.state[k] + offset, self.state[k] - offset]);
            }
            let (image, measured) = if i < P::PASSIVE {
                model.predict(&points)
            } else {
                model.measure(&points, &center)
            };
            points[i] = Pair::constant(self.state[i]);
            for k in 0..P::DYNAMIC {
                let Pair([plus, minus]) = image[k];
                images.shift[k] += self.pair(&mut images.moving[k], i, plus, minus, center.0[k]);
            }
            for p in indirect::<P, N, M>() {
                let Pair([plus, minus]) = measured[p];
                shift_measured[p] +=
                    self.pair(&mut images.measured[p], i, plus, minus, center.1[p]);
            }
        }
        for k in 0..P::DYNAMIC {
            images.shift[k] *= self.weights.mean;
            images.state[k] = center.0[k] + images.shift[k];
        }
        for p in 0..M {
            images.measurement[p] = if P::DIRECT.contains(&p) {
                images.state[p]
            } else {
                center.1[p] + self.weights.mean * shift_measured[p]
            };
        }
        images
    }

    /// Writes column i of C and D of one quantity; returns the distance of the pair's mean from the centre.
    #[inline(always)]
    fn pair(&self, row: &mut Row<N, 2>, i: usize, plus: f64, minus: f64, center: f64) -> f64 {
        let bend = 0.5 * ((plus - center) + (minus - center));
        row[0][i] = self.weights.odd * (plus - minus);
        row[1][i] = self.weights.even * bend;
        bend
    }
}

/// Intermediate results of a printed step.
#[derive(Clone, Copy, Debug)]
pub struct PrintedStep<const N: usize, const M: usize> {
    /// Predicted state (23).
    pub predicted: [f64; N],
    /// Predicted root S^- (23).
    pub predicted_root: [[f64; N]; N],
    /// S_y (26), process noise not included.
    pub innovation_root: [[f64; M]; M],
    /// P_xy (26).
    pub cross_covariance: [[f64; M]; N],
    /// Gain K (27).
    pub gain: [[f64; M]; N],
    /// S^- (I - F U'^-1 (U + V)^-1 F') (28), not triangular.
    pub updated_root: [[f64; N]; N],
    /// |S_y^-1 (y - y^)|^2.
    pub nis: f64,
}

impl<const N: usize, const M: usize> SquareRootUkf<N, M> {
    /// One step of the improved SR-UKF as printed, (23)-(28), for models whose measurements are all direct.
    ///
    /// A missing measurement has innovation 0 and a large standard deviation. (20): the root of P_0 is meant. (27): the
    /// gain is (P_xy / S_y') / S_y. (28) is Andrews' update; its result is triangularised again.
    pub fn step_printed<P: Model<N, M>>(
        &mut self,
        model: &P,
        process_std: &[f64; N],
        measurement_std: &[f64; M],
        innovation: impl Fn(&[f64; M]) -> [f64; M],
    ) -> PrintedStep<N, M> {
        let images = self.images(model);
        let mut rows: [Row<N, 2>; N] = core::array::from_fn(|k| {
            if k < P::DYNAMIC {
                images.moving[k]
            } else {
                [self.root[k], [0.0; N]]
            }
        });
        let measured: [Row<N, 2>; M] = core::array::from_fn(|j| rows[j]);
        let cross_covariance = self.cross_covariance(&rows, &measured, &images.shift);
        let innovation_root = triangularise(&mut measured.clone(), measurement_std); // (26)
        let predicted_root = triangularise(&mut rows, process_std); // (23)
        let innovation = innovation(&images.measurement);

        let gain = cross_covariance.map(|row| {
            let mut k = row;
            solve_lower(&innovation_root, &mut k);
            solve_lower_transposed(&innovation_root, &mut k);
            k
        }); // (27)
        self.state = core::array::from_fn(|i| images.state[i] + inner(&gain[i], &innovation));
        let updated_root = andrews(&predicted_root, measurement_std); // (28)
        self.root = triangularise(&mut updated_root.map(|row| [row]), &[0.0; N]);

        let mut whitened = innovation;
        solve_lower(&innovation_root, &mut whitened);
        PrintedStep {
            predicted: images.state,
            predicted_root,
            innovation_root,
            cross_covariance,
            gain,
            updated_root,
            nis: inner(&whitened, &whitened),
        }
    }

    /// P_xy of (26) about the means, with w_c0 on the centre: 2w sum (c c' + d d') + (beta - alpha^2) m m'.
    fn cross_covariance(
        &self,
        rows: &[Row<N, 2>; N],
        measured: &[Row<N, 2>; M],
        shift: &[f64; N],
    ) -> [[f64; M]; N] {
        let excess = self.spread.beta - self.spread.alpha * self.spread.alpha;
        core::array::from_fn(|k| {
            core::array::from_fn(|j| {
                let spread = inner(rows[k].as_flattened(), measured[j].as_flattened());
                spread + excess * shift[k] * shift[j]
            })
        })
    }
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// S (I - F U'^-1 (U + V)^-1 F') with F = S' H', U U' = F'F + V V', H the leading unit rows.
fn andrews<const N: usize, const M: usize>(root: &[[f64; N]; N], std: &[f64; M]) -> [[f64; N]; N] {
    let f: [[f64; N]; M] = core::array::from_fn(|j| root[j]); // F', row by row
    let u = triangularise(&mut f.map(|row| [row]), std);
    let mut u_plus_v = u;
    for (j, row) in u_plus_v.iter_mut().enumerate() {
        row[j] += std[j];
    }
    // Columns of (U + V)^-1 F', then of U'^-1 (U + V)^-1 F'.
    let mut correction = [[0.0; N]; N];
    for i in 0..N {
        let mut column: [f64; M] = core::array::from_fn(|j| f[j][i]);
        solve_lower(&u_plus_v, &mut column);
        solve_lower_transposed(&u, &mut column);
        for (k, row) in correction.iter_mut().enumerate() {
            row[i] = (0..M).map(|j| f[j][k] * column[j]).sum();
        }
    }
    core::array::from_fn(|k| {
        core::array::from_fn(|i| {
            root[k][i] - (0..N).map(|l| root[k][l] * correction[l][i]).sum::<f64>()
        })
    })
}
