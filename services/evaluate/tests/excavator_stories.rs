//! Estimates of the excavator during single events, one story each.

mod estimates;

use estimation::excavator::{Estimate, Method, Settings};
use sim::excavator::{Row, Story};
use sim::fault::{FaultKind, ROW};

/// Each row of a story with the estimate of a method.
fn estimates(story: &Story, method: Method) -> Vec<(Row, Estimate)> {
    estimates::estimates(story.clone().rows(), &Settings::calibrated(), method)
}

/// Asserts that every trusted inertia is within three standard deviations or within 4 % of the truth.
fn assert_honest(estimates: &[(Row, Estimate)]) {
    for (row, e) in estimates.iter().filter(|(_, e)| e.flags.trusted()) {
        let away = (e.inertia - row.truth.inertia).abs();
        assert!(
            away < 3.0 * e.inertia_std || away < 0.04 * row.truth.inertia,
            "{} s: {} ± {} of {}",
            row.time,
            e.inertia,
            e.inertia_std,
            row.truth.inertia
        );
    }
}

fn trusted(estimates: &[(Row, Estimate)]) -> usize {
    estimates.iter().filter(|(_, e)| e.flags.trusted()).count()
}

/// Methods that estimate a load; `Posture` is never trusted after a single swing.
const TESTED: [Method; 3] = [Method::PostureTorque, Method::Torque, Method::Posture];

#[test]
fn one_swing_determines_the_inertia() {
    for seed in 1..=3 {
        let estimates = estimates(
            &Story::at_rest().seed(seed).swing_to(1.7),
            Method::PostureTorque,
        );
        assert_honest(&estimates);
        assert!(
            trusted(&estimates) > 50,
            "seed {seed}: {}",
            trusted(&estimates)
        );
    }
}

#[test]
fn a_machine_at_standstill_gives_no_information() {
    for method in TESTED {
        let estimates = estimates(&Story::at_rest().rest(10.0), method);
        assert_eq!(trusted(&estimates), 0, "{method:?}");
    }
}

#[test]
fn a_load_that_was_dumped_is_missing_from_the_next_swing() {
    let story = Story::at_rest().swing_to(1.7).dump(420.0).swing_to(0.0);
    for seed in 1..=3 {
        let estimates = estimates(&story.clone().seed(seed), Method::PostureTorque);
        assert_honest(&estimates);
        let of = |from: f64, to: f64| {
            let rows = estimates
                .iter()
                .filter(|(row, _)| (from..to).contains(&row.time));
            let mut loads = rows
                .filter(|(_, e)| e.flags.trusted())
                .filter_map(|(_, e)| e.payload);
            loads.next_back().expect("a trusted load")
        };
        let dumped = estimates.iter().find(|(row, _)| row.truth.payload < 1.0);
        let dumped = dumped.expect("it is dumped").0.time;
        let (before, after) = (of(0.0, dumped - 1.0), of(dumped, f64::INFINITY));
        assert!(
            (before.value - 420.0).abs() < 3.0 * before.std,
            "{before:?}"
        );
        assert!(after.value.abs() < 3.0 * after.std, "{after:?}");
    }
}

#[test]
fn a_load_that_was_taken_up_is_in_the_next_swing() {
    let story = Story::at_rest().swing_to(1.7).take_up(300.0).swing_to(0.0);
    let estimates = estimates(&story, Method::PostureTorque);
    assert_honest(&estimates);
    let mut trusted = estimates.iter().filter(|(_, e)| e.flags.trusted());
    let last = trusted
        .next_back()
        .and_then(|(_, e)| e.payload)
        .expect("a trusted load");
    assert!((last.value - 300.0).abs() < 3.0 * last.std, "{last:?}");
}

#[test]
fn what_needs_the_torque_is_not_trusted_without_it() {
    let story = Story::at_rest().lose("swing_torque", 60.0).swing_to(1.7);
    for method in [Method::PostureTorque, Method::Torque] {
        assert_eq!(trusted(&estimates(&story, method)), 0, "{method:?}");
    }
    let estimates = estimates(&story, Method::Posture);
    assert_honest(&estimates);
}

#[test]
fn a_sensor_that_is_silent_for_a_while_makes_nothing_wrong() {
    for channel in ["swing_velocity", "swing_torque", "boom_angle"] {
        let begin = Story::at_rest().rest(1.0).lose(channel, 2.0);
        let story = begin.swing_to(1.7).swing_to(0.0);
        for method in TESTED {
            let estimates = estimates(&story, method);
            assert_honest(&estimates);
            let comes_back = trusted(&estimates) > 0 || method == Method::Posture;
            assert!(comes_back, "{channel} {method:?}");
        }
    }
}

#[test]
fn a_velocity_that_freezes_is_not_trusted() {
    let begin = Story::at_rest().swing_to(1.7);
    let story = begin
        .suffer("swing_velocity", FaultKind::Hold, 60.0)
        .swing_to(0.0);
    for method in TESTED {
        let estimates = estimates(&story, method);
        assert_honest(&estimates);
        let moves_again = |row: &Row| row.time > 7.0 && row.truth.velocity < -0.1;
        let wrong = estimates
            .iter()
            .filter(|(row, e)| moves_again(row) && e.flags.trusted());
        assert_eq!(wrong.count(), 0, "{method:?}");
        let before = trusted(&estimates) > 0 || method == Method::Posture;
        assert!(before, "{method:?}");
    }
}

#[test]
fn a_long_gap_resets_the_filter_and_sets_the_flag() {
    let begin = Story::at_rest().swing_to(1.7);
    let story = begin.lose(ROW, 3.0).rest(3.0).swing_to(0.0);
    for method in TESTED {
        let estimates = estimates(&story, method);
        let resets: Vec<_> = estimates.iter().filter(|(_, e)| e.flags.reset).collect();
        assert_eq!(resets.len(), 1, "{method:?}");
        assert!(!resets[0].1.flags.trusted());
    }
}
