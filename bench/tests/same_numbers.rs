//! Both sides of a comparison of times compute the same numbers.

use bench::problem::{Filter, regression_data, rover_data, velocity_data};
use bench::{ours, peers};

/// The largest difference of two filters over the data, relative to the size of each state.
fn difference<Z, A, B, const N: usize>(mut a: A, mut b: B, data: &[Z]) -> f64
where
    A: Filter<Z, N>,
    B: Filter<Z, N>,
{
    let mut worst: f64 = 0.0;
    for sample in data {
        a.step(sample);
        b.step(sample);
        for (x, y) in a.state().into_iter().zip(b.state()) {
            assert!(x.is_finite() && y.is_finite());
            worst = worst.max((x - y).abs() / (1.0 + x.abs()));
        }
    }
    worst
}

fn against_ours<Ours, Peer, Z, const N: usize>(data: &[Z], tolerance: f64)
where
    Ours: Filter<Z, N> + Default,
    Peer: Filter<Z, N> + Default,
{
    let worst = difference::<Z, _, _, N>(Ours::default(), Peer::default(), data);
    assert!(
        worst < tolerance,
        "{}: {worst:e}",
        std::any::type_name::<Peer>()
    );
}

/// Tolerance for equal formulas in another order: rounding only.
const ROUNDING: f64 = 1e-10;
/// Tolerance for a covariance against its root: rounding, amplified by the condition of the covariance.
const ROOT: f64 = 1e-8;

#[test]
fn kalman_filters_agree() {
    let data = velocity_data();
    against_ours::<ours::Kalman, peers::kalman::Textbook, _, 2>(&data, ROUNDING);
    against_ours::<ours::Kalman, peers::kalman::Smelly, _, 2>(&data, ROUNDING);
    against_ours::<ours::Kalman, peers::kalman::Kfilter, _, 2>(&data, ROUNDING);
    against_ours::<ours::Kalman, peers::kalman::Minikalman, _, 2>(&data, ROUNDING);
    against_ours::<ours::Kalman, peers::kalman::Numeris, _, 2>(&data, ROUNDING);
    against_ours::<ours::Kalman, peers::kalman::Adskalman, _, 2>(&data, ROUNDING);
}

#[test]
fn regressions_with_a_factor_each_agree() {
    let data = regression_data();
    against_ours::<ours::Regression<false>, ours::Regression<true>, _, 3>(&data, ROOT);
    against_ours::<ours::Regression<false>, peers::regression::TextbookSolve, _, 3>(&data, ROOT);
}

#[test]
fn unscented_filters_agree() {
    let data = rover_data();
    against_ours::<ours::Unscented, peers::square_root::Textbook, _, 6>(&data, ROOT);
    against_ours::<ours::Unscented, peers::unscented::Textbook, _, 6>(&data, ROOT);
    against_ours::<ours::Unscented, peers::unscented::Smelly, _, 6>(&data, ROOT);
    against_ours::<ours::Unscented, peers::unscented::Kfilter, _, 6>(&data, ROOT);
    against_ours::<ours::Unscented, peers::unscented::NumerisUkf, _, 6>(&data, ROOT);
    against_ours::<ours::Unscented, peers::unscented::NumerisSrUkf, _, 6>(&data, ROOT);
}

/// minikalman does not redraw the sigma points after the prediction. It agrees with the textbook filter without redraw, and only
/// approximately with heft's.
#[test]
fn minikalman_agrees_with_the_filter_without_redraw() {
    let data = rover_data();
    let without = peers::unscented::Textbook::new(false);
    let worst = difference::<_, _, _, 6>(without, peers::unscented::Minikalman::default(), &data);
    assert!(worst < ROOT, "{worst:e}");
    let worst = difference::<_, _, _, 6>(
        ours::Unscented::default(),
        peers::unscented::Minikalman::default(),
        &data,
    );
    assert!(worst > ROOT && worst < 0.1, "{worst:e}");
}

#[test]
fn extended_filters_agree() {
    let data = rover_data();
    against_ours::<ours::Extended, peers::extended::Textbook, _, 6>(&data, ROOT);
    against_ours::<ours::Extended, peers::extended::Smelly, _, 6>(&data, ROOT);
    against_ours::<ours::Extended, peers::extended::Kfilter, _, 6>(&data, ROOT);
    against_ours::<ours::Extended, peers::extended::Numeris, _, 6>(&data, ROOT);
}
