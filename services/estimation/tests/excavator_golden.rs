//! The estimators reproduce the numbers of the reference implementation.

mod excavator_common;

use estimation::excavator::{
    Estimate, Method, MotionFilter, Regression, Settings, SwingEstimator, Variant,
};
use estimation::kalman::{Gain, VelocityFilter};
use estimation::keys::Numbers;
use estimation::rls::MultipleForgettingRls;
use excavator_common::{COLUMNS, Table, close, golden_settings, samples};

/// Tolerance for rounding only.
const EXACT: f64 = 1e-12;

#[test]
fn kalman_filter_takes_the_reference_steps_including_a_missing_sample() {
    let golden = Table::golden("lkf_steps.csv");
    let (period, q, r) = (0.01, 4.7e-5, 2.5e-5);
    let mut filter = VelocityFilter::new(golden.get(0, "y").unwrap(), r);
    for k in 0..golden.rows.len() {
        if k > 0 {
            filter.predict(period, q);
        }
        let innovation = filter.correct(golden.get(k, "y"), r);
        let [p11, p12, p22] = filter.covariance();
        let ours = [
            ("S", innovation.variance),
            ("x1", filter.velocity()),
            ("x2", filter.acceleration()),
            ("P11", p11),
            ("P12", p12),
            ("P22", p22),
        ];
        for (name, value) in ours {
            let reference = golden.get(k, name).unwrap();
            assert!(
                close(value, reference, EXACT, 1e-15),
                "{name} at {k}: {value} {reference}"
            );
        }
        let reference = golden.get(k, "innovation").unwrap_or(0.0);
        assert!(
            close(innovation.value, reference, EXACT, 1e-15),
            "innovation at {k}"
        );
    }
}

#[test]
fn steady_gain_and_convergence_delay_follow_in_closed_form() {
    // T, q, R, K1, K2, P11, P12, P22, wn, delay of excavator_lkf_steady.json.
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/golden/excavator_lkf_steady.json"
    ))
    .unwrap();
    let number = |block: &str, key: &str| -> f64 {
        let rest = block.split(&format!("\"{key}\":")).nth(1).unwrap();
        rest.split([',', '\n', '}'])
            .next()
            .unwrap()
            .trim()
            .parse()
            .unwrap()
    };
    let blocks: Vec<&str> = text.split("\"T=").skip(1).collect();
    assert_eq!(blocks.len(), 6);
    for block in blocks {
        let (t, q, r) = (number(block, "T"), number(block, "q"), number(block, "R"));
        let gain = Gain::steady(t, q, r);
        let [p11, p12, p22] = gain.covariance;
        let ours = [
            ("K1", gain.velocity),
            ("K2", gain.acceleration),
            ("P11", p11),
            ("P12", p12),
            ("P22", p22),
        ];
        for (key, value) in ours {
            assert!(
                close(value, number(block, key), 1e-9, 0.0),
                "{key}: {value}"
            );
        }
        let delay = gain.convergence_delay(t);
        assert!(
            close(delay, number(block, "delay_5pct_s"), 1e-12, 0.0),
            "{delay}"
        );
    }
}

#[test]
fn closed_form_and_solved_regression_take_the_reference_steps() {
    let golden = Table::golden("rls_steps.csv");
    let start = ([5000.0, 1500.0, 2500.0], [100.0, 100.0, 1e4]);
    let mut closed = MultipleForgettingRls::new(start.0, start.1);
    let mut solved = closed.clone();
    let forgetting = [0.99, 0.95, 0.3];
    for k in 0..golden.rows.len() {
        let get = |name: &str| golden.get(k, name).unwrap();
        let phi = [get("phi1"), get("phi2"), get("phi3")];
        closed.update(&phi, get("y"), &forgetting);
        solved.update_by_solve(&phi, get("y"), &forgetting);
        for i in 0..3 {
            let n = i + 1;
            let theta = get(&format!("theta{n}"));
            let by_solve = get(&format!("theta{n}_3x3"));
            let variance = get(&format!("P{n}"));
            assert!(
                close(closed.parameters[i], theta, 1e-9, 0.0),
                "theta{n} at {k}"
            );
            assert!(
                close(solved.parameters[i], by_solve, 1e-9, 0.0),
                "solved theta{n} at {k}"
            );
            assert!(
                close(closed.variance()[i], variance, 1e-11, 0.0),
                "P{n} at {k}"
            );
        }
    }
}

#[test]
fn nominal_and_forgetting_rules_act_where_the_reference_acts() {
    let golden = Table::golden("rls_rules.csv");
    for reading in ["I1", "I2"] {
        let mut settings = Settings::paper(5000.0);
        settings.paper.change_times = Numbers::new(&[7.5]).unwrap();
        settings.paper.start_time = None;
        settings.paper.stop_time = None;
        settings.paper.covariance = [1e2, 1e4, 1e6];
        settings.paper.torque = 2500.0;
        (settings.paper.lambda_normal, settings.paper.lambda_window) = if reading == "I1" {
            ([0.99, 0.69, 0.1], [1.0, 0.69, 0.1])
        } else {
            ([0.95, 0.99, 0.9], [0.99, 0.99, 0.1])
        };
        let mut regression = Regression::new(&settings, Method::MultiForgettingRls).unwrap();
        for k in (0..golden.rows.len()).filter(|&k| golden.rows[k][0] == reading) {
            let get = |name: &str| golden.get(k, name).unwrap();
            let estimate = regression.step(&estimation::excavator::Motion {
                time: get("t"),
                period: 0.01,
                velocity: get("w"),
                acceleration: get("a"),
                convergence_delay: 0.25,
                measured: true,
                ..Default::default()
            });
            // theta3 passes through zero: the tolerance there is 1e-9 of its usual size.
            compare_paper(&estimate, &golden, k, 1e-9, 1e-6);
        }
    }
}

fn compare_paper(estimate: &Estimate, golden: &Table, k: usize, relative: f64, absolute: f64) {
    let theta1 = golden.get(k, "theta1").unwrap();
    assert!(
        close(estimate.inertia, theta1, relative, 0.0),
        "theta1 {k}: {} {theta1}",
        estimate.inertia
    );
    for (name, value) in [("theta2", estimate.damping), ("theta3", estimate.torque)] {
        let reference = golden.get(k, name).unwrap();
        let value = value.unwrap().value;
        assert!(
            close(value, reference, relative, absolute),
            "{name} {k}: {value} {reference}"
        );
    }
    for (name, flag) in [
        ("nominal", estimate.flags.nominal),
        ("window", estimate.flags.window),
    ] {
        assert_eq!(
            f64::from(u8::from(flag)),
            golden.get(k, name).unwrap(),
            "{name} {k}"
        );
    }
}

#[test]
fn paper_mode_gives_the_reference_trajectories_and_table() {
    // Mean, std, maximum of excavator_out_paper_summary.json [%].
    let table = [
        (
            4452.02786,
            -0.23470088383524,
            3.3510291238865983,
            6.185847687543189,
        ),
        (
            5451.25995,
            0.22259019519221274,
            3.8186673127494486,
            10.806712415980257,
        ),
        (
            5919.65,
            -0.33064760804935617,
            4.003335797719922,
            12.971679549621362,
        ),
    ];
    for (case, (start, mean, std, max)) in (1..=3).zip(table) {
        let input = Table::golden(&format!("input_paper_case{case}.csv"));
        let golden = Table::golden(&format!("out_paper_case{case}.csv"));
        let settings = Settings::paper(start);
        let mut filter = MotionFilter::new(&settings, COLUMNS).unwrap();
        let mut regression = Regression::new(&settings, Method::MultiForgettingRls).unwrap();
        let mut errors = Vec::new();
        for (k, sample) in samples(&input).iter().enumerate() {
            let motion = filter.step(sample);
            let estimate = regression.step(&motion);
            let Some(row) = k.checked_sub(50).filter(|&row| row < golden.rows.len()) else {
                continue;
            };
            // theta2 and theta3 vary by thousands between samples; the estimated quantity is J.
            compare_paper(&estimate, &golden, row, 1e-6, 0.05);
            errors.push(100.0 * (estimate.inertia / input.get(k, "true_inertia").unwrap() - 1.0));
        }
        let (m, s, x) = statistics(&errors);
        for (ours, reference) in [(m, mean), (s, std), (x, max)] {
            assert!(
                (ours - reference).abs() < 1e-4,
                "case {case}: {ours} {reference}"
            );
        }
    }
}

/// Mean, population standard deviation, maximum.
fn statistics(errors: &[f64]) -> (f64, f64, f64) {
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let variance = errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / n;
    (
        mean,
        variance.sqrt(),
        errors.iter().fold(0.0, |m, e| m.max(e.abs())),
    )
}

#[test]
fn equal_filters_with_a_scalar_regression_give_the_reference_trajectories() {
    for input in [
        "base_case1",
        "base_case2",
        "base_case3",
        "gentle_case2",
        "paper_case2",
    ] {
        let golden = Table::golden(&format!("out_BSVF_{input}.csv"));
        let rows = samples(&Table::golden(&format!("input_{input}.csv")));
        let settings = golden_settings();
        let mut filter = MotionFilter::new(&settings, COLUMNS).unwrap();
        let mut regression = Regression::new(&settings, Method::SvfRls).unwrap();
        for (k, sample) in rows.iter().enumerate() {
            let motion = filter.step(sample);
            let estimate = regression.step(&motion);
            if k % 5 != 0 {
                continue;
            }
            let reference = golden.get(k / 5, "J_hat").unwrap();
            assert!(close(estimate.inertia, reference, 1e-7, 0.0), "{input} {k}");
            let acceleration = golden.get(k / 5, "aux").unwrap();
            assert!(
                close(motion.filtered_acceleration, acceleration, 1e-6, 1e-6),
                "{input} {k}"
            );
        }
    }
}

/// Start-up bias of the "bad" input, subtracted from every sample.
const BIAS: f64 = 0.008978557476875;

/// Runs a state-space mode over an input and compares each fifth sample.
fn compare(mode: &str, input: &str, method: Method, change: impl Fn(&mut Settings)) {
    let golden = Table::golden(&format!("out_{mode}_{input}.csv"));
    let mut settings = golden_settings();
    change(&mut settings);
    let mut rows = samples(&Table::golden(&format!("input_{input}.csv")));
    if input == "bad" {
        for row in &mut rows {
            row.velocity = row.velocity.map(|y| y - BIAS);
        }
    }
    let mut estimator = SwingEstimator::new(&settings, method, COLUMNS).unwrap();
    let factor = match (method, settings.estimator.variant) {
        (Method::Torque, Variant::Known) => settings.estimator.interval_factor,
        _ => 1.0,
    };
    let mut compared = 0;
    let mut k = 0;
    let mut last = rows[0].time - 0.01;
    for row in &rows {
        // The index in the files includes the samples of a gap.
        k += ((row.time - last) / 0.01).round() as usize;
        last = row.time;
        let estimate = estimator.step(row);
        let at = k - 1;
        if at % 5 != 0 {
            continue;
        }
        let context = format!("{mode} {input} k {at}");
        compare_row(&estimate, &estimator, &golden, at / 5, factor, &context);
        compared += 1;
    }
    assert!(
        compared + 2 >= golden.rows.len(),
        "{mode} {input}: {compared} rows"
    );
}

fn compare_row(
    estimate: &Estimate,
    estimator: &SwingEstimator,
    golden: &Table,
    row: usize,
    factor: f64,
    context: &str,
) {
    let reference = |name: &str| golden.get(row, name);
    let inertia = reference("J_hat").unwrap();
    assert_eq!(
        f64::from(estimator.code()),
        reference("state").unwrap(),
        "{context} state"
    );
    assert!(
        close(estimate.inertia, inertia, 1e-7, 0.0),
        "{context}: {} {inertia}",
        estimate.inertia
    );
    let std = reference("sd_J").unwrap() * factor;
    assert!(
        close(estimate.inertia_std, std, 1e-6, 0.0),
        "{context}: sd {} {std}",
        estimate.inertia_std
    );
    // The files have the correction of the torque; `offset` is the error of the measured torque, with the opposite sign.
    let offset = if estimate.offset.is_some() {
        estimate.offset.map(|q| -q.value)
    } else {
        estimate.torque.map(|q| q.value)
    };
    let ours = [
        ("payload", estimate.payload.map(|q| q.value)),
        ("b_hat", estimate.damping.map(|q| q.value)),
        ("offset", offset),
        ("w_hat", Some(estimator.details().velocity)),
    ];
    for (name, value) in ours {
        if let (Some(value), Some(reference)) = (value, reference(name)) {
            assert!(
                close(value, reference, 1e-6, 1e-6),
                "{context} {name}: {value} {reference}"
            );
        }
    }
    compare_aux(estimator, estimate, golden, row, context);
}

fn compare_aux(
    estimator: &SwingEstimator,
    estimate: &Estimate,
    golden: &Table,
    row: usize,
    context: &str,
) {
    let aux = golden.get(row, "aux").unwrap();
    let d = estimator.details();
    let flag = |on: bool| f64::from(u8::from(on));
    let mode = context.split(' ').next().unwrap();
    let (ours, tolerance) = match mode {
        "D_auto" => (flag(d.change_mode) + 2.0 * flag(d.opening), 0.0),
        "C" | "C_weak" | "A" | "A_const" => (flag(d.flagged), 0.0),
        _ => (estimate.nis, 1e-6),
    };
    assert!(
        close(ours, aux, tolerance, tolerance),
        "{context} aux: {ours} {aux}"
    );
}

const BASE: [&str; 3] = ["base_case1", "base_case2", "base_case3"];

#[test]
fn mode_d_with_known_damping_gives_the_reference_trajectories() {
    for input in BASE
        .into_iter()
        .chain(["gentle_case2", "constant", "two_swings"])
    {
        compare("D_known", input, Method::PostureTorque, |s| {
            s.estimator.variant = Variant::Known
        });
    }
}

#[test]
fn mode_d_tolerant_gives_the_reference_trajectories() {
    for input in BASE.into_iter().chain(["gentle_case2", "two_swings"]) {
        compare("D_tol", input, Method::PostureTorque, |s| {
            s.estimator.variant = Variant::Tolerant
        });
    }
}

#[test]
fn the_default_gives_the_reference_trajectories_also_where_the_payload_drops() {
    for input in BASE.into_iter().chain(["two_swings", "drop"]) {
        compare("D_auto", input, Method::Auto, |_| ());
    }
}

#[test]
fn mode_bm_gives_the_reference_trajectories() {
    for input in BASE
        .into_iter()
        .chain(["gentle_case2", "constant", "two_swings"])
    {
        compare("BM_known", input, Method::Torque, |s| {
            s.estimator.variant = Variant::Known
        });
    }
    compare("BM_tol", "base_case2", Method::Torque, |s| {
        s.estimator.variant = Variant::Tolerant
    });
}

#[test]
fn mode_c_gives_the_reference_trajectories_with_and_without_weak_onset_detector() {
    for input in BASE
        .into_iter()
        .chain(["gentle_case2", "constant", "bad", "soft_brake"])
    {
        compare("C", input, Method::Posture, |s| {
            s.estimator.variant = Variant::Known;
            s.estimator.weak_onset = false;
        });
    }
    for input in BASE.into_iter().chain(["bad", "soft_brake"]) {
        compare("C_weak", input, Method::Posture, |s| {
            s.estimator.variant = Variant::Known
        });
    }
}

#[test]
fn mode_a_gives_the_reference_trajectories() {
    for input in BASE.into_iter().chain(["gentle_case2"]) {
        compare("A", input, Method::Velocity, |s| {
            s.estimator.weak_onset = false
        });
    }
    compare("A_const", "constant", Method::Velocity, |s| {
        s.estimator.variant = Variant::Known;
        s.estimator.constant_inertia = true;
        s.estimator.weak_onset = false;
    });
}
