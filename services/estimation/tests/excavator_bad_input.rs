//! Bad input: every row gets an answer, no number is NaN, and unknown quantities are marked.

mod excavator_common;

use estimation::excavator::keys::Description;
use estimation::excavator::{
    Columns, Estimate, Method, MotionFilter, Reason, Regression, Sample, Settings, SwingEstimator,
    Variant,
};
use excavator_common::{COLUMNS, Table, golden_settings, samples};

const STATE_SPACE: [Method; 4] = [
    Method::PostureTorque,
    Method::Torque,
    Method::Posture,
    Method::Velocity,
];

fn base() -> Vec<Sample> {
    samples(&Table::golden("input_base_case2.csv"))
}

/// Small generator of reproducible faults (xorshift).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Replaces a value at random by one that no sensor should deliver.
    fn spoil(&mut self, value: Option<f64>) -> Option<f64> {
        match (self.next() * 40.0) as u32 {
            0 => Some(f64::NAN),
            1 => Some(f64::INFINITY),
            2 => Some(-1e300),
            3 => Some(1e9 * (self.next() - 0.5)),
            4 => Some(4.0 * (self.next() - 0.5)),
            5..=8 => None,
            _ => value,
        }
    }
}

/// A swing in which all signals and the clock are unreliable.
fn spoiled(seed: u64) -> Vec<Sample> {
    let mut noise = Noise(seed);
    let mut rows = base();
    for row in &mut rows {
        row.time = match (noise.next() * 60.0) as u32 {
            0 => f64::NAN,
            1 => row.time - 0.5,
            2 => f64::INFINITY,
            3 => row.time + 0.3,
            _ => row.time,
        };
        row.velocity = noise.spoil(row.velocity);
        row.torque = noise.spoil(row.torque);
        row.posture = row.posture.map(|q| noise.spoil(q));
    }
    rows
}

fn check(e: &Estimate, s: &Settings, method: Method, context: &str) {
    let mut numbers = vec![e.inertia, e.inertia_std, e.velocity, e.acceleration, e.nis];
    for q in [e.damping, e.torque, e.payload, e.friction, e.offset]
        .into_iter()
        .flatten()
    {
        numbers.extend([q.value, q.std]);
        assert!(q.std >= 0.0, "{context}: {e:?}");
    }
    assert!(numbers.iter().all(|x| x.is_finite()), "{context}: {e:?}");
    assert!(e.inertia_std > 0.0, "{context}: {e:?}");
    if matches!(method, Method::Torque | Method::Velocity | Method::SvfRls) {
        let inside = (s.inertia_min..=s.inertia_max).contains(&e.inertia);
        assert!(inside, "{context}: {}", e.inertia);
    }
    if let Some(payload) = e.payload {
        assert!(
            (-50.0..=900.0).contains(&payload.value),
            "{context}: {}",
            payload.value
        );
    }
}

fn variants() -> Vec<(Method, Settings)> {
    let mut all = Vec::new();
    for method in STATE_SPACE {
        for variant in [Variant::Auto, Variant::Known, Variant::Tolerant] {
            for constant_inertia in [false, true] {
                let mut settings = Settings::calibrated();
                settings.estimator.variant = variant;
                settings.estimator.constant_inertia = constant_inertia;
                all.push((method, settings));
            }
        }
    }
    all
}

#[test]
fn state_space_estimates_stay_finite_and_inside_their_limits_on_nonsense() {
    for (method, settings) in variants() {
        for seed in 1..=6 {
            let mut estimator = SwingEstimator::new(&settings, method, COLUMNS).unwrap();
            for (k, row) in spoiled(seed).iter().enumerate() {
                let e = estimator.step(row);
                check(
                    &e,
                    &settings,
                    method,
                    &format!("{method:?} seed {seed} row {k}"),
                );
            }
        }
    }
}

#[test]
fn regressions_stay_finite_on_nonsense() {
    for method in [Method::MultiForgettingRls, Method::SvfRls] {
        for joint in [false, true] {
            let mut settings = Settings::calibrated();
            settings.estimator.estimate_damping = joint;
            settings.estimator.estimate_friction = joint;
            settings.estimator.estimate_offset = joint;
            for seed in 1..=6 {
                let mut filter = MotionFilter::new(&settings, COLUMNS).unwrap();
                let mut regression = Regression::new(&settings, method).unwrap();
                for (k, row) in spoiled(seed).iter().enumerate() {
                    let e = regression.step(&filter.step(row));
                    check(
                        &e,
                        &settings,
                        method,
                        &format!("{method:?} seed {seed} row {k}"),
                    );
                }
            }
        }
    }
}

#[test]
fn a_refused_row_leaves_the_state_untouched() {
    for method in STATE_SPACE {
        let settings = Settings::calibrated();
        let mut clean = SwingEstimator::new(&settings, method, COLUMNS).unwrap();
        let mut dirty = clean.clone();
        let mut filter = MotionFilter::new(&settings, COLUMNS).unwrap();
        let mut other = filter.clone();
        for row in base() {
            for time in [f64::NAN, f64::NEG_INFINITY, row.time - 1.0] {
                let bad = Sample {
                    time,
                    velocity: Some(1.0),
                    ..row
                };
                if row.time > 5.0 {
                    assert!(dirty.step(&bad).flags.refused);
                    assert!(!dirty.step(&bad).flags.trusted());
                    assert!(other.step(&bad).refused);
                }
            }
            let mut expected = clean.step(&row);
            let mut found = dirty.step(&row);
            (expected.refused, found.refused) = (0, 0);
            assert_eq!(expected, found);
            assert_eq!(filter.step(&row), other.step(&row));
        }
    }
}

#[test]
fn nothing_becomes_surer_without_an_accepted_velocity() {
    // The velocity is lost permanently in the middle of the swing.
    for (method, settings) in variants() {
        if method == Method::Velocity {
            continue;
        }
        let mut estimator = SwingEstimator::new(&settings, method, COLUMNS).unwrap();
        let mut last: Option<f64> = None;
        for mut row in base() {
            let lost = row.time > 6.5;
            if lost {
                row.velocity = None;
            }
            let e = estimator.step(&row);
            let share = match e.payload {
                Some(payload) => payload.std,
                None => e.inertia_std / e.inertia,
            };
            // Mode C has a delay of 0.15 s.
            if row.time > 6.7
                && let Some(last) = last
            {
                assert!(
                    share > last * (1.0 - 1e-9),
                    "{method:?} {}: {last} {share}",
                    row.time
                );
            }
            assert!(
                !(row.time > 6.65 && e.flags.trusted()),
                "{method:?} {}",
                row.time
            );
            last = Some(share);
        }
    }
}

#[test]
fn the_payload_does_not_wander_while_the_machine_is_held() {
    for method in [Method::PostureTorque, Method::Posture] {
        let mut estimator = SwingEstimator::new(&golden_settings(), method, COLUMNS).unwrap();
        let mut last: Option<Estimate> = None;
        for row in samples(&Table::golden("input_two_swings.csv")) {
            let e = estimator.step(&row);
            if let Some(last) = last.filter(|last| last.flags.held && e.flags.held) {
                let (before, now) = (last.payload.unwrap().value, e.payload.unwrap().value);
                // The weights of mode C's grid are normalised again at every sample.
                assert!((now - before).abs() < 1e-9, "{method:?} {}", row.time);
            }
            last = Some(e);
        }
    }
}

/// Largest relative error and share of covered samples from 6.0 to 9.3 s at |w| >= 0.1.
fn score(rows: &[Sample], truth: &Table, settings: &Settings) -> (f64, f64) {
    let mut estimator = SwingEstimator::new(settings, Method::Auto, COLUMNS).unwrap();
    let (mut worst, mut covered, mut n) = (0.0_f64, 0, 0);
    for row in rows {
        let e = estimator.step(row);
        let k = ((row.time - 5.0) / 0.01).round() as usize;
        if !(6.0..=9.3).contains(&row.time) || truth.get(k, "true_velocity").unwrap() < 0.1 {
            continue;
        }
        let inertia = truth.get(k, "true_inertia").unwrap();
        worst = worst.max((e.inertia / inertia - 1.0).abs());
        covered += usize::from((e.inertia - inertia).abs() < 1.96 * e.inertia_std);
        n += 1;
    }
    (worst, covered as f64 / f64::from(n))
}

#[test]
fn bias_noise_outliers_and_saturation_are_dealt_with() {
    let truth = Table::golden("input_base_case2.csv");
    let clean = base();
    type Fault = fn(usize, f64) -> Option<f64>;
    let cases: [(&str, Fault, f64); 4] = [
        ("as it is", |_, y| Some(y), 5.0),
        ("bias of 0.01 rad/s", |_, y| Some(y + 0.01), 5.0),
        (
            "every 40th sample 0.3 rad/s off",
            |k, y| Some(if k % 40 == 7 { y + 0.3 } else { y }),
            5.0,
        ),
        ("sensor ends at 0.8 rad/s", |_, y| Some(y.min(0.8)), 0.8),
    ];
    for (name, change, limit) in cases {
        let mut settings = Settings::calibrated();
        settings.sensors.swing_velocity_limit = limit;
        let mut rows = clean.clone();
        for (k, row) in rows.iter_mut().enumerate() {
            row.velocity = row.velocity.and_then(|y| change(k, y));
        }
        let (worst, covered) = score(&rows, &truth, &settings);
        println!(
            "{name}: worst {:.1} %, covered {:.0} %",
            100.0 * worst,
            100.0 * covered
        );
        // One seed: the p95 of the maximum over seeds is 6.5 %.
        assert!(worst < 0.065 && covered > 0.85, "{name}: {worst} {covered}");
    }
}

#[test]
fn what_no_upper_body_and_no_drive_can_do_is_as_if_it_were_missing() {
    type Fault = fn(&mut Sample, Option<f64>);
    let signals: [(Fault, &[f64]); 2] = [
        (|row, word| row.velocity = word, &[3.0, -2.0, 4.9]),
        (
            |row, word| row.torque = word,
            &[65_535.0, -1e6, 6.5e7, 1e12],
        ),
    ];
    for method in [Method::Auto, Method::Torque, Method::PostureTorque] {
        for (fault, words) in signals {
            let with = |word: Option<f64>| {
                let mut estimator =
                    SwingEstimator::new(&Settings::calibrated(), method, COLUMNS).unwrap();
                let rows = base().into_iter().enumerate().map(|(k, mut row)| {
                    // One row, 50 ms, a third of a second.
                    if k == 150 || (220..225).contains(&k) || (300..333).contains(&k) {
                        fault(&mut row, word);
                    }
                    let estimate = estimator.step(&row);
                    (estimate.inertia, estimate.inertia_std)
                });
                rows.collect::<Vec<_>>()
            };
            let missing = with(None);
            for word in words {
                assert_eq!(with(Some(*word)), missing, "{method:?} {word}");
            }
        }
    }
}

#[test]
fn where_the_velocity_is_missing_no_constant_of_the_machine_is_the_reason() {
    let settings = Settings::of(&Description::default());
    // The torque has an offset, which seems friction. The velocity ends after so many rows.
    let last = |rows: usize| {
        let mut estimator = SwingEstimator::new(&settings, Method::Auto, COLUMNS).unwrap();
        let answers = base().into_iter().enumerate().map(|(k, mut row)| {
            row.torque = row.torque.map(|torque| torque + 1250.0);
            row.velocity = row.velocity.filter(|_| k < rows);
            estimator.step(&row)
        });
        let last = answers.last().expect("rows");
        (last.flags.fresh, last.reason)
    };
    let rows = base().len();
    assert_eq!(last(rows), (true, Reason::Friction));
    assert_eq!(last(rows - 50), (false, Reason::None));
}

#[test]
fn a_large_outlier_at_rest_neither_sets_the_machine_off_nor_hides_that_it_stands() {
    for method in [Method::Torque, Method::Posture, Method::PostureTorque] {
        for first in [3, 20, 41] {
            let rows = base();
            let mut clean = SwingEstimator::new(&Settings::calibrated(), method, COLUMNS).unwrap();
            let mut other = clean.clone();
            for (k, row) in rows.iter().enumerate() {
                let mut spoiled = *row;
                if row.time < 5.45 && k % 47 == first {
                    spoiled.velocity = row.velocity.map(|y| y + 1.0);
                }
                let (expected, found) = (clean.step(row), other.step(&spoiled));
                assert!(found.flags.held || row.time > 5.5, "{method:?} row {k}");
                if !(6.0..9.0).contains(&row.time) {
                    continue;
                }
                // The bias comes from 49 samples instead of 50, and the start may be noticed a
                // sample later; a false start costs 10 to 20 %.
                let share = (found.inertia / expected.inertia - 1.0).abs();
                assert!(share < 0.02, "{method:?} outlier {first} row {k}: {share}");
            }
        }
    }
}

#[test]
fn one_absurd_stamp_costs_no_row_after_it_and_a_clock_set_back_is_followed() {
    for method in STATE_SPACE {
        for ahead in [5.0, 1e9, f64::MAX] {
            let settings = Settings::calibrated();
            let mut estimator = SwingEstimator::new(&settings, method, COLUMNS).unwrap();
            let mut filter = MotionFilter::new(&settings, COLUMNS).unwrap();
            for (k, row) in base().into_iter().enumerate() {
                let time = if k == 150 { row.time + ahead } else { row.time };
                let row = Sample { time, ..row };
                let (e, m) = (estimator.step(&row), filter.step(&row));
                assert!(!e.flags.refused && !m.refused, "{method:?} {ahead} row {k}");
                assert!(
                    e.inertia.is_finite() && m.velocity.is_finite() && m.acceleration.is_finite()
                );
                assert!(!e.flags.reset || (150..=151).contains(&k), "{method:?} {k}");
            }
        }
        let mut estimator = SwingEstimator::new(&Settings::calibrated(), method, COLUMNS).unwrap();
        let mut refused = 0;
        for shift in [0.0, -60.0] {
            for row in base() {
                let time = row.time + shift;
                let e = estimator.step(&Sample { time, ..row });
                refused += usize::from(e.flags.refused);
            }
        }
        // One second of rows, and one more if their steps are rounded down.
        assert!((100..=102).contains(&refused), "{method:?} {refused}");
    }
}

#[test]
fn auto_gives_up_a_column_that_never_has_a_value() {
    let mut estimator = SwingEstimator::new(&golden_settings(), Method::Auto, COLUMNS).unwrap();
    assert_eq!(estimator.method(), Method::PostureTorque);
    for mut row in base() {
        row.torque = None;
        let e = estimator.step(&row);
        let expected = if row.time < 5.985 {
            Method::PostureTorque
        } else {
            e.method
        };
        assert_eq!(e.method, expected);
        assert!(!(e.method == Method::PostureTorque && e.flags.trusted()));
    }
    assert_eq!(estimator.method(), Method::Posture);
}

/// The method with velocity only uses the damping to determine the inertia, so it is no fallback for a machine without damping.
#[test]
fn without_damping_the_velocity_does_not_serve_in_place_of_silent_columns() {
    let mut settings = golden_settings();
    settings.nominal_damping = 0.0;
    let mut estimator = SwingEstimator::new(&settings, Method::Auto, COLUMNS).unwrap();
    for mut row in base() {
        (row.torque, row.posture) = (None, [None; 3]);
        let e = estimator.step(&row);
        assert!(e.inertia.is_finite() && e.inertia_std.is_finite() && !e.flags.trusted());
    }
    assert_ne!(estimator.method(), Method::Velocity);
}

#[test]
fn a_gap_of_any_length_leaves_numbers() {
    for method in STATE_SPACE {
        for gap in [1e9, 1e154, 1e308] {
            let settings = golden_settings();
            let mut estimator = SwingEstimator::new(&settings, method, COLUMNS).unwrap();
            for k in 0..65 {
                let at = |n: f64| (0.05 * f64::from(k) * n).sin();
                let row = Sample {
                    time: if k < 64 { 0.01 * f64::from(k) } else { gap },
                    velocity: Some(at(2.0)),
                    torque: Some(at(4.0)),
                    posture: [Some(at(5.0)), Some(at(6.0)), Some(at(7.0))],
                    ..Sample::default()
                };
                let e = estimator.step(&row);
                check(&e, &settings, method, &format!("{gap} row {k}"));
            }
        }
    }
}

#[test]
fn a_source_that_sends_nothing_for_three_seconds_is_as_one_without_rows() {
    let settings = Settings::of(&Description::default());
    // A swing, rows without values from 9.9 to 12.8 s, and the swing again.
    let silence = (99..129).map(|tenth| Sample {
        time: f64::from(tenth) / 10.0,
        ..Sample::default()
    });
    let again = base().into_iter().map(|row| Sample {
        time: row.time + 8.0,
        ..row
    });
    let after = |silence: Vec<Sample>| {
        let mut estimator = SwingEstimator::new(&settings, Method::Auto, COLUMNS).unwrap();
        base().iter().for_each(|row| {
            estimator.step(row);
        });
        for row in &silence {
            let e = estimator.step(row);
            let unknown = e.payload.expect("a payload").std >= settings.prior.payload_std;
            assert!(!e.flags.trusted() && (unknown || row.time < 11.0), "{e:?}");
        }
        again.clone().map(|row| estimator.step(&row)).last()
    };
    let [silent, absent] = [silence.collect(), Vec::new()].map(|rows| after(rows).expect("rows"));
    let apart = (silent.inertia - absent.inertia).abs();
    assert!(apart < 0.02 * absent.inertia_std, "{silent:?} {absent:?}");
    assert!((silent.inertia_std / absent.inertia_std - 1.0).abs() < 0.02);
}

#[test]
fn a_missing_column_is_an_error_that_names_it() {
    let columns = Columns {
        torque: false,
        ..COLUMNS
    };
    let error = SwingEstimator::new(&Settings::calibrated(), Method::Torque, columns).unwrap_err();
    assert!(error.to_string().contains("swing_torque"), "{error}");
}

#[test]
fn one_row_gives_the_prior_held() {
    let mut estimator =
        SwingEstimator::new(&Settings::calibrated(), Method::Auto, COLUMNS).unwrap();
    let e = estimator.step(&base()[0]);
    assert!(e.flags.held && !e.flags.trusted());
    assert!(e.inertia_std > 0.05 * e.inertia);
}

#[test]
fn mode_a_on_a_moving_arm_is_wide_and_never_identifiable() {
    for case in 1..=3 {
        let input = Table::golden(&format!("input_base_case{case}.csv"));
        let rows = samples(&input);
        let mut estimator =
            SwingEstimator::new(&golden_settings(), Method::Velocity, COLUMNS).unwrap();
        for (k, row) in rows.iter().enumerate() {
            let e = estimator.step(row);
            assert!(!e.flags.identifiable && !e.flags.trusted());
            let truth = input.get(k, "true_inertia").unwrap();
            assert!(
                (e.inertia - truth).abs() < 1.96 * e.inertia_std,
                "case {case} row {k}"
            );
        }
    }
}

#[test]
fn the_paper_keeps_an_initial_error_and_never_calls_itself_identifiable() {
    let input = Table::golden("input_paper_case2.csv");
    let rows = samples(&input);
    let run = |inertia: f64| -> Vec<f64> {
        let mut settings = Settings::paper(inertia);
        settings.paper.nominal_rule = false;
        settings.nominal_damping *= inertia / 5451.25995;
        settings.paper.torque *= inertia / 5451.25995;
        let mut filter = MotionFilter::new(&settings, COLUMNS).unwrap();
        let mut regression = Regression::new(&settings, Method::MultiForgettingRls).unwrap();
        rows.iter()
            .map(|row| {
                let e = regression.step(&filter.step(row));
                assert!(!e.flags.identifiable && !e.flags.trusted());
                e.inertia
            })
            .collect()
    };
    // Without the nominal rule the recursion is linear in its initial value.
    let (whole, part) = (run(5451.25995), run(0.8 * 5451.25995));
    for (a, b) in whole.iter().zip(&part) {
        assert!((b - 0.8 * a).abs() <= 1e-9 * a.abs().max(1.0), "{a} {b}");
    }
}

/// Sequence of methods in use if velocity, torque and joint angles first arrive at these times after the first row [s].
fn methods_where(velocity: f64, torque: f64, posture: f64) -> Vec<Method> {
    let auto = SwingEstimator::new(&Settings::calibrated(), Method::Auto, COLUMNS);
    let mut estimator = auto.expect("settings");
    let mut found = Vec::new();
    let rows = base();
    for mut row in rows.iter().copied() {
        let since = row.time - rows[0].time;
        row.velocity = row.velocity.filter(|_| since >= velocity);
        row.torque = row.torque.filter(|_| since >= torque);
        row.posture = row.posture.map(|q| q.filter(|_| since >= posture));
        found.push(estimator.step(&row).method);
    }
    found.dedup();
    found
}

#[test]
fn silence_at_the_start_does_not_exclude_a_signal() {
    const ALL: Method = Method::PostureTorque;
    const NEVER: f64 = f64::INFINITY;
    assert_eq!(methods_where(0.0, 0.0, 0.0), [ALL]);
    // A starting bus: all signals at once, or one by one.
    assert_eq!(methods_where(2.5, 2.5, 2.5), [ALL]);
    assert_eq!(methods_where(2.0, 2.3, 2.7), [ALL]);
    // A late signal counts from its arrival on.
    assert_eq!(methods_where(0.0, 2.0, 0.0), [ALL, Method::Posture, ALL]);
    let one_by_one = [ALL, Method::Velocity, Method::Torque, ALL];
    assert_eq!(methods_where(0.0, 1.5, 3.0), one_by_one);
    // A signal that never arrives is dropped, once.
    assert_eq!(methods_where(0.0, NEVER, 0.0), [ALL, Method::Posture]);
    assert_eq!(methods_where(0.0, NEVER, NEVER), [ALL, Method::Velocity]);
}
