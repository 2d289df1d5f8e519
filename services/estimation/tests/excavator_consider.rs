//! Uncertain settings that are not estimated: the interval grows by the effect of an error of the setting.

mod excavator_common;

use estimation::excavator::{Estimate, Method, Sample, Settings, SwingEstimator, Variant};
use excavator_common::{Table, columns_for, golden_settings, samples};

fn run(method: Method, settings: &Settings, rows: &[Sample]) -> Vec<Estimate> {
    let mut estimator = SwingEstimator::new(settings, method, columns_for(method)).unwrap();
    rows.iter().map(|row| estimator.step(row)).collect()
}

fn base() -> Vec<Sample> {
    samples(&Table::golden("input_base_case2.csv"))
}

/// Effects of a setting on the inertia [kg m^2]: the standard deviation that its uncertainty adds, and the change of the estimate by
/// a small change of the setting, per standard deviation of the setting.
struct Pair {
    time: f64,
    added: f64,
    caused: f64,
}

/// `doubt` states an uncertainty; `shift` changes settings and rows by `SMALL` of it.
const SMALL: f64 = 1e-3;

fn pairs(
    method: Method,
    settings: Settings,
    doubt: impl Fn(&mut Settings),
    shift: impl Fn(&mut Settings, &mut [Sample]),
) -> Vec<Pair> {
    let rows = base();
    let mut doubtful = settings;
    doubt(&mut doubtful);
    let (mut changed, mut other) = (settings, rows.clone());
    shift(&mut changed, &mut other);
    let plain = run(method, &settings, &rows);
    let wide = run(method, &doubtful, &rows);
    let moved = run(method, &changed, &other);
    let moving = |k: &usize| (5.8..9.2).contains(&rows[*k].time);
    (0..rows.len())
        .filter(moving)
        .map(|k| {
            assert_eq!(plain[k].inertia, wide[k].inertia, "{}", rows[k].time);
            let square = |e: &Estimate| e.inertia_std * e.inertia_std;
            Pair {
                time: rows[k].time,
                added: (square(&wide[k]) - square(&plain[k])).max(0.0).sqrt(),
                caused: ((moved[k].inertia - plain[k].inertia) / SMALL).abs(),
            }
        })
        .collect()
}

fn torques(rows: &mut [Sample], change: impl Fn(f64) -> f64) {
    for row in rows {
        row.torque = row.torque.map(&change);
    }
}

fn agree(pairs: &[Pair], tolerance: f64) {
    // Where the effect changes its sign, both are small compared with its maximum.
    let largest = pairs.iter().map(|p| p.caused).fold(0.0, f64::max);
    assert!(largest > 0.0);
    for p in pairs {
        assert!(
            (p.added - p.caused).abs() < tolerance * largest,
            "{:.2} s: added {} caused {}",
            p.time,
            p.added,
            p.caused
        );
    }
}

fn known() -> Settings {
    let mut settings = golden_settings();
    settings.estimator.variant = Variant::Known;
    settings
}

/// Settings with known damping and offset, to test one uncertainty alone.
fn certain() -> Settings {
    let mut settings = golden_settings();
    settings.prior.damping_std = 0.0;
    settings.prior.torque_offset_std = settings.prior.known_torque_offset_std;
    settings
}

#[test]
fn an_uncertain_damping_widens_the_method_torque_by_what_it_does_to_the_inertia() {
    let doubt = |s: &mut Settings| s.prior.damping_std = 225.0;
    let shift = |s: &mut Settings, _: &mut [Sample]| s.nominal_damping += 225.0 * SMALL;
    // The sensitivity itself depends on the state, most at small velocity while braking.
    agree(&pairs(Method::Torque, certain(), doubt, shift), 0.08);
}

#[test]
fn an_uncertain_offset_widens_the_method_torque_by_what_it_does_to_the_inertia() {
    let doubt = |s: &mut Settings| s.prior.torque_offset_std = f64::hypot(30.0, 52.0);
    let shift =
        |_: &mut Settings, rows: &mut [Sample]| torques(rows, |torque| torque + 52.0 * SMALL);
    agree(&pairs(Method::Torque, certain(), doubt, shift), 0.08);
}

#[test]
fn an_uncertain_gain_widens_both_methods_with_torque_by_what_it_does_to_the_inertia() {
    let doubt = |s: &mut Settings| s.sensors.swing_torque_gain_std = 0.05;
    let shift = |_: &mut Settings, rows: &mut [Sample]| {
        torques(rows, |torque| torque * (1.0 + 0.05 * SMALL))
    };
    for method in [Method::Torque, Method::PostureTorque] {
        agree(&pairs(method, known(), doubt, shift), 0.08);
    }
}

#[test]
fn an_uncertain_damping_widens_the_method_posture_by_what_it_does_to_the_inertia() {
    let doubt = |s: &mut Settings| s.prior.damping_std = 225.0;
    let shift = |s: &mut Settings, _: &mut [Sample]| s.nominal_damping += 225.0 * SMALL;
    // The weights of the grid are only approximately a parabola.
    agree(&pairs(Method::Posture, certain(), doubt, shift), 0.15);
}

#[test]
fn a_damping_off_by_a_fifth_is_never_trusted_and_wrong() {
    for case in 1..=3 {
        let input = Table::golden(&format!("input_base_case{case}.csv"));
        let rows = samples(&input);
        for (method, share) in [Method::Torque, Method::Posture]
            .into_iter()
            .flat_map(|method| [0.8, 1.2].map(|share| (method, share)))
        {
            let mut settings = Settings::calibrated();
            settings.nominal_damping *= share;
            for (k, e) in run(method, &settings, &rows).iter().enumerate() {
                let truth = input.get(k, "true_inertia").unwrap();
                let error = e.inertia / truth - 1.0;
                assert!(
                    !e.flags.trusted() || error.abs() < 0.1,
                    "{method:?} case {case} damping x {share} row {k}: {error}"
                );
            }
        }
    }
}

#[test]
fn a_declared_constant_inertia_is_known_no_better_than_the_damping() {
    let rows = samples(&Table::golden("input_constant.csv"));
    let mut settings = golden_settings();
    settings.estimator.constant_inertia = true;
    settings.prior.damping_std = 0.1 * settings.nominal_damping;
    for e in run(Method::Velocity, &settings, &rows) {
        assert!(e.inertia_std > 0.1 * e.inertia);
    }
}
