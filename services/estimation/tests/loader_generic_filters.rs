//! The generic filters against textbook algebra: nalgebra's QR of the whole array, and the Kalman filter.

use core::ops::Range;

use estimation::ekf::Ekf;
use estimation::model::Model;
use estimation::prediction::Update;
use estimation::root::triangularise;
use estimation::scalar::Scalar;
use estimation::sigma_points::Spread;
use estimation::srukf::SquareRootUkf;
use nalgebra::{SMatrix, SVector};

/// Factor of measurements and states together.
type Factor = SMatrix<f64, 7, 7>;

const N: usize = 4;
const M: usize = 3;

/// Two moving states, two parameters; one measured state, two nonlinear measurements that share noise with the states.
struct Bent;

impl Model<N, M> for Bent {
    const DYNAMIC: usize = 2;
    const DIRECT: Range<usize> = 0..1;

    fn predict<T: Scalar>(&self, x: &[T; N]) -> ([T; N], [T; M]) {
        let next = [
            x[0] + (x[1] * x[2]).sin() * 0.1,
            x[1] * 0.9 + x[3] * x[0],
            x[2],
            x[3],
        ];
        (
            next,
            [next[0], next[1] * x[2] + next[0], (next[0] * x[3]).tanh()],
        )
    }

    fn noise_coupling(&self) -> [[f64; N]; M] {
        [[0.0; N], [1.0, 2.0, 0.0, 0.0], [0.3, 0.0, 0.0, 0.0]]
    }
}

/// The same model without declared structure: every state may move, and no measurement is a state.
struct Undeclared;

impl Model<N, M> for Undeclared {
    fn predict<T: Scalar>(&self, x: &[T; N]) -> ([T; N], [T; M]) {
        Bent.predict(x)
    }

    fn noise_coupling(&self) -> [[f64; N]; M] {
        let mut coupling = Bent.noise_coupling();
        coupling[0][0] = 1.0; // the measured state carries its own noise
        coupling
    }
}

const X: [f64; N] = [0.4, -0.7, 1.3, 0.25];
const S: [[f64; N]; N] = [
    [0.2, 0.0, 0.0, 0.0],
    [0.05, 0.3, 0.0, 0.0],
    [-0.1, 0.02, 0.15, 0.0],
    [0.03, -0.04, 0.01, 0.1],
];
const Q: [f64; N] = [0.02, 0.05, 0.0, 0.01];
const R: [f64; M] = [0.1, 0.2, 0.3];

/// Lower factor of the whole array [D_Y Q_Y R; D_X Q 0] by nalgebra's QR, straight from the sigma points.
fn textbook_factor(alpha: f64) -> Factor {
    let c = alpha * alpha * N as f64;
    let weight = 1.0 / (2.0 * c);
    let image = |x: &[f64; N]| {
        let (next, y): ([f64; N], [f64; M]) = Bent.predict(x);
        y.iter().chain(&next).copied().collect::<Vec<f64>>()
    };
    let center = image(&X);
    let mut a = SMatrix::<f64, 7, 15>::zeros();
    for i in 0..N {
        for (half, sign) in [1.0, -1.0].into_iter().enumerate() {
            let point = core::array::from_fn(|k| X[k] + sign * c.sqrt() * S[k][i]);
            for (row, (z, z0)) in image(&point).iter().zip(&center).enumerate() {
                a[(row, half * N + i)] = weight.sqrt() * (z - z0);
            }
        }
        a[(M + i, 2 * N + i)] = Q[i];
        a[(0, 2 * N + i)] = if i == 0 { Q[0] } else { 0.0 };
        for p in 1..M {
            a[(p, 2 * N + i)] = Bent.noise_coupling()[p][i] * Q[i];
        }
    }
    for j in 0..M {
        a[(j, 3 * N + j)] = R[j];
    }
    let mut factor = a.transpose().qr().r().transpose();
    for i in 0..M + N {
        if factor[(i, i)] < 0.0 {
            factor.column_mut(i).neg_mut();
        }
    }
    factor
}

fn factor(update: &Update<N, M>, root: &[[f64; N]; N]) -> Factor {
    Factor::from_fn(|i, j| match (i < M, j < M) {
        (true, true) => update.innovation_root[i][j],
        (false, true) => update.gain_root[i - M][j],
        (false, false) => root[i - M][j - M],
        (true, false) => 0.0,
    })
}

#[test]
fn structured_step_equals_the_qr_of_the_whole_array() {
    for alpha in [1.0, 0.3] {
        let spread = Spread {
            alpha,
            ..Spread::UNIT
        };
        let ukf = SquareRootUkf::<N, M>::with_root(X, S, spread);
        let e = [0.1, -0.2, 0.05];
        let golden = textbook_factor(alpha);
        let all = [true; M];
        let (mut declared, mut undeclared) = (ukf.predict(&Bent, &Q), ukf.predict(&Undeclared, &Q));
        let predicted = [declared.state, undeclared.state];
        let updates = [
            declared.absorb(&e, &R, &all),
            undeclared.absorb(&e, &R, &all),
        ];
        let states = [declared.state, undeclared.state];
        let roots = [declared.root(), undeclared.root()];
        for which in 0..2 {
            let (update, state) = (&updates[which], &states[which]);
            // The two orders of elimination differ by rounding.
            assert!((factor(update, &roots[which]) - golden).amax() < 1e-14);
            let s_y = golden.fixed_view::<M, M>(0, 0).into_owned();
            let z = s_y.lu().solve(&SVector::<f64, M>::from(e)).unwrap();
            for (ours, theirs) in update.whitened.iter().zip(z.iter()) {
                assert!((ours - theirs).abs() < 1e-13);
            }
            let moved = golden.fixed_view::<N, M>(M, 0) * z;
            for k in 0..N {
                assert!((state[k] - predicted[which][k] - moved[k]).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn a_rejected_measurement_is_as_if_it_did_not_exist() {
    let ukf = SquareRootUkf::<N, M>::with_root(X, S, Spread::UNIT);
    for skipped in 0..M {
        let accepted = core::array::from_fn(|j| j != skipped);
        let (mut e, mut r) = ([0.1, -0.2, 0.05], R);
        let (mut without, mut with) = (ukf.predict(&Bent, &Q), ukf.predict(&Bent, &Q));
        let update = without.absorb(&e, &r, &accepted);
        (e[skipped], r[skipped]) = (0.0, 1e9);
        with.absorb(&e, &r, &[true; M]);
        for k in 0..N {
            assert!((with.state[k] - without.state[k]).abs() < 1e-12);
            for i in 0..N {
                assert!((with.root()[k][i] - without.root()[k][i]).abs() < 1e-12);
            }
        }
        assert_eq!(update.whitened[skipped], 0.0);
    }
}

#[test]
fn predicted_measurement_deviation_is_the_row_norm_of_the_factor() {
    let prediction = SquareRootUkf::<N, M>::with_root(X, S, Spread::UNIT).predict(&Bent, &Q);
    let factor = textbook_factor(1.0);
    for (j, noise) in R.into_iter().enumerate() {
        let total = factor.row(j).norm();
        let ours = prediction.measurement_std(j).hypot(noise);
        assert!((ours - total).abs() < 1e-14);
    }
}

#[test]
fn triangularise_equals_qr_and_bears_rows_of_zeros() {
    let rows = [[[1.0, -2.0, 0.5]], [[0.0, 0.0, 0.0]], [[3.0, 1.0, 0.25]]];
    let diagonal = [0.1, 0.0, 2.0];
    let root = triangularise(&mut rows.clone(), &diagonal);
    let ours = SMatrix::<f64, 3, 3>::from_fn(|i, j| root[i][j]);
    let dense = SMatrix::<f64, 3, 3>::from_fn(|i, j| rows[i][0][j]);
    let noise = SMatrix::<f64, 3, 3>::from_diagonal(&diagonal.into());
    let covariance = dense * dense.transpose() + noise * noise;
    assert!((ours * ours.transpose() - covariance).amax() < 1e-14);
    assert!(
        ours.iter().all(|x| x.is_finite()) && ours.upper_triangle().sum() == ours.diagonal().sum()
    );
}

/// Constant acceleration, position and velocity measured.
struct Linear;

impl Model<2, 1> for Linear {
    const DIRECT: Range<usize> = 0..1;

    fn predict<T: Scalar>(&self, x: &[T; 2]) -> ([T; 2], [T; 1]) {
        let next = [x[0] + x[1] * 0.1, x[1] * 0.99];
        (next, [next[0]])
    }
}

#[test]
fn on_a_linear_model_both_filters_are_the_kalman_filter() {
    let (q, r) = ([0.01, 0.02], [0.1]);
    let mut ukf = SquareRootUkf::<2, 1>::new([0.0, 1.0], &[1.0, 0.5], Spread::UNIT);
    let mut ekf = Ekf::<2, 1>::new([0.0, 1.0], &[1.0, 0.5]);
    let (mut x, mut p) = (
        [0.0, 1.0],
        SMatrix::<f64, 2, 2>::from_diagonal(&[1.0, 0.25].into()),
    );
    let f = SMatrix::<f64, 2, 2>::new(1.0, 0.1, 0.0, 0.99);
    for k in 0..200 {
        let y = (f64::from(k) * 0.1).sin();
        let nis = (
            ukf.step(&Linear, &q, &[y], &r),
            ekf.step(&Linear, &q, &[y], &r),
        );
        x = [x[0] + 0.1 * x[1], 0.99 * x[1]];
        p = f * p * f.transpose() + SMatrix::<f64, 2, 2>::from_diagonal(&[1e-4, 4e-4].into());
        let s = p[(0, 0)] + 0.01;
        let e = y - x[0];
        x = [x[0] + p[(0, 0)] / s * e, x[1] + p[(1, 0)] / s * e];
        p -= p.column(0) * p.row(0) / s;
        assert!((nis.0 - e * e / s).abs() < 1e-11 && (nis.1 - e * e / s).abs() < 1e-11);
        let of_root = ukf.root[1][0] * ukf.root[1][0] + ukf.root[1][1] * ukf.root[1][1];
        for (state, covariance) in [(ukf.state, of_root), (ekf.state, ekf.covariance[1][1])] {
            assert!((state[0] - x[0]).abs() < 1e-12 && (state[1] - x[1]).abs() < 1e-12);
            assert!((covariance - p[(1, 1)]).abs() < 1e-13);
        }
    }
}

/// The condition in the documentation of `ekf`: with process noise no accuracy is lost down to R/P = 1e-9.
#[test]
fn the_exact_row_keeps_the_covariance_where_the_measurement_is_far_better_than_the_prior() {
    let (q, r) = ([1e-4, 1e-3], [1e-4]);
    let start = [1e-4 / 1e-9_f64.sqrt(); 2];
    let mut ukf = SquareRootUkf::<2, 1>::new([0.0, 1.0], &start, Spread::UNIT);
    let mut ekf = Ekf::<2, 1>::new([0.0, 1.0], &start);
    for k in 0..500 {
        let y = [(f64::from(k) * 0.01).sin()];
        ukf.step(&Linear, &q, &y, &r);
        ekf.step(&Linear, &q, &y, &r);
        for i in 0..2 {
            let of_root: f64 = ukf.root[i].iter().map(|x| x * x).sum();
            let error = (ekf.covariance[i][i] / of_root - 1.0).abs();
            // State 0 is exact from the first row on; the variance of state 1 falls to 1e-7 of its initial value.
            assert!(
                error < if i == 0 { 1e-6 } else { 1e-5 },
                "{k}, {i}: {error:e}"
            );
            assert!(
                (ekf.state[i] - ukf.state[i]).abs() < 1e-4 * of_root.sqrt(),
                "{k}"
            );
        }
        assert_eq!(ekf.covariance[0][1], ekf.covariance[1][0]);
    }
}

/// The indirect measurements, the noise they share with the states and the rejected ones, against the root's own step.
#[test]
fn the_ekf_on_the_covariance_is_the_joseph_form() {
    let product = |i: usize, j: usize| (0..N).map(|c| S[i][c] * S[j][c]).sum();
    let covariance = core::array::from_fn(|i| core::array::from_fn(|j| product(i, j)));
    for accepted in [[true; M], [true, false, true], [false, true, true]] {
        let mut ekf = Ekf::<N, M> {
            state: X,
            covariance,
        };
        let expected = ekf.predict(&Bent, &Q);
        let predicted = SMatrix::<f64, N, N>::from_fn(|i, j| ekf.covariance[i][j]);
        let cross = SMatrix::<f64, N, M>::from_fn(|i, j| expected.cross[j][i]);
        let own = SMatrix::<f64, M, M>::from_fn(|i, j| {
            let noise = if accepted[i] { R[i] * R[i] } else { 1e12 };
            expected.own[i][j] + if i == j { noise } else { 0.0 }
        });
        let gain = cross * own.try_inverse().unwrap();
        let after = predicted - gain * cross.transpose();
        ekf.update(&expected, &[0.1, -0.2, 0.05], &R, &accepted, 0..1);
        for i in 0..N {
            for j in 0..N {
                assert!(
                    (ekf.covariance[i][j] - after[(i, j)]).abs() < 1e-13,
                    "{i} {j}"
                );
            }
        }
    }
}

#[test]
fn covariance_stays_positive_through_a_million_precise_measurements() {
    let mut ukf = SquareRootUkf::<2, 1>::new([0.0, 0.0], &[1e3, 1e3], Spread::PAPER);
    for _ in 0..1_000_000 {
        ukf.step(&Linear, &[0.0, 1e-9], &[0.0], &[1e-8]);
    }
    assert!(
        ukf.root[0][0] > 0.0 && ukf.root[1][1] > 0.0 && ukf.state.iter().all(|x| x.is_finite())
    );
}
