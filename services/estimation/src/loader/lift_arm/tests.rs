extern crate std;
use super::*;
use crate::loader::keys::{LiftArm, LiftCylinder};
use std::vec::Vec;

/// A 12 t loader, its pressures made by the statics of its own drawing.
fn settings() -> Settings {
    let mut settings = Settings::DEFAULT;
    settings.machine.mass = 12_500.0;
    settings.machine.wheelbase = 3.0;
    settings.lift_arm = LiftArm {
        length: 2.68,
        pivot_x: -1.05,
        pivot_z: 1.32,
        mass: 690.0,
        mass_distance: 1.47,
        bucket_mass: 560.0,
        payload_distance: 0.59,
        reference_angle: -0.4,
        reference_tilt: 1.05,
        empty_ratio: 0.47,
        empty_ratio_std: 0.006,
        empty_height: 1.25,
        empty_height_std: 0.06,
        ..LiftArm::DEFAULT
    };
    settings.lift_cylinder = LiftCylinder {
        head_area: 4.33e-3,
        rod_area: 2.38e-3,
        base_distance: 0.91,
        rod_distance: 1.39,
        angle: 1.31,
        friction: 0.03,
        ..LiftCylinder::DEFAULT
    };
    settings
}

/// One second of work: angles of arm and bucket and payload at its end, and friction's direction.
struct Second(f64, f64, f64, f64);

/// What the witness says at the end of each second.
fn run(seconds: &[Second]) -> Vec<Option<Weighed>> {
    run_shown(seconds, &|_, head| head)
}

/// The same where the sensor shows another head pressure, by the arm's angle and the true one.
fn run_shown(seconds: &[Second], shown: &dyn Fn(f64, f64) -> f64) -> Vec<Option<Weighed>> {
    let settings = settings();
    let mut witness = LiftWitness::new(&settings).expect("a described arm");
    let drawing = witness.drawing;
    let (mut lift, mut bucket, mut load, mut time) = (seconds[0].0, seconds[0].1, 0.0, 0.0);
    let mut said = Vec::new();
    for second in seconds {
        let (from, turned, held) = (lift, bucket, load);
        for k in 1..=100 {
            let part = f64::from(k) / 100.0;
            (lift, bucket) = (
                from + part * (second.0 - from),
                turned + part * (second.1 - turned),
            );
            load = held + part * (second.2 - held);
            time += 0.01;
            let posture = Posture {
                arm: Turn::of(lift),
                bucket: Turn::of(bucket),
                head: 0.0,
                rod: 0.7e6,
                gravity: 9.81,
                acceleration: 0.0,
                seals: second.3,
                rest: 0.0,
            };
            let (empty, per_load) = drawing.moments(&drawing.values, &posture);
            let missing = empty + load * per_load - drawing.lifting(&drawing.values, &posture);
            let per_pascal = drawing.lever(posture.arm) * 2.0 * 4.33e-3;
            said.push(witness.step(&Sample {
                time,
                lift_angle: Some(lift),
                tilt_angle: Some(bucket - lift),
                lift_head_pressure: Some(shown(lift, missing / per_pascal)),
                lift_rod_pressure: Some(0.7e6),
                acceleration: Some(0.0),
                ..Sample::default()
            }));
        }
    }
    said.into_iter().skip(99).step_by(100).collect()
}

#[test]
fn an_arm_that_is_not_described_weighs_nothing() {
    assert!(LiftWitness::new(&Settings::DEFAULT).is_none());
}

#[test]
fn a_payload_is_reported_from_the_first_row_on_where_an_arm_is_described() {
    use crate::loader::{CgEstimator, Columns, Method};
    let settings = settings();
    let columns = Columns::default();
    let mut estimator = CgEstimator::new(&settings, Method::Full, columns).unwrap();
    // No pressure comes: whatever the bucket holds, and never trusted.
    for k in 0..50 {
        let answer = estimator.step(&Sample {
            time: 0.01 * f64::from(k),
            ..Sample::default()
        });
        let payload = answer.payload.expect("a described arm");
        assert!(
            payload.std > 3000.0 && !answer.trusted_payload,
            "{payload:?}"
        );
    }
    let mut without = CgEstimator::new(&Settings::DEFAULT, Method::Full, columns).unwrap();
    assert_eq!(without.step(&Sample::default()).payload, None);
}

#[test]
fn a_load_is_weighed_where_it_is_carried_and_known_to_be_unknown_where_it_is_dug() {
    let mut work: Vec<Second> = Vec::new();
    // Empty and low, lowered last; digs and curls; carries; lifts; stands; dumps; stands.
    work.extend((0..6).map(|k| Second(-0.5 - 0.03 * f64::from(k.min(4)), 0.0, 0.0, -1.0)));
    work.push(Second(-0.6, 0.4, 2000.0, 1.0));
    work.push(Second(-0.5, 0.75, 3600.0, 1.0));
    work.extend((0..6).map(|_| Second(-0.5, 0.75, 3600.0, 1.0)));
    work.extend((1..=4).map(|k| Second(-0.5 + 0.25 * f64::from(k), 0.75, 3600.0, 1.0)));
    work.extend((0..4).map(|_| Second(0.5, 0.75, 3600.0, 1.0)));
    work.push(Second(0.5, -0.75, 0.0, 1.0));
    work.extend((0..4).map(|_| Second(0.5, -0.75, 0.0, 1.0)));
    let said = run(&work);
    let at = |second: usize| said[second].expect("fresh");
    assert!(at(7).open && at(7).payload.std > 1000.0);
    for (second, payload) in [(5, 0.0), (13, 3600.0), (21, 3600.0), (26, 0.0)] {
        let found = at(second);
        let error = (found.payload.value - payload).abs();
        assert!(!found.open, "{second}");
        assert!(
            error < 50.0 && error < 1.96 * found.payload.std,
            "{second}: {found:?}"
        );
    }
    // The load goes up by 2 m: 3600 of 16 100 kg of it.
    let raised = at(21).height.value - at(13).height.value;
    assert!((0.5..0.9).contains(&raised), "{raised}");
    assert!(at(13).ratio.value - at(5).ratio.value > 0.2);
}

#[test]
fn a_pressure_that_stands_still_while_the_machine_drives_says_nothing() {
    let mut witness = LiftWitness::new(&settings()).expect("a described arm");
    let mut said = None;
    for k in 0..600 {
        said = witness.step(&Sample {
            time: 0.01 * f64::from(k),
            speed: Some(2.0),
            lift_angle: Some(-0.5 + 1e-4 * f64::from(k % 7)),
            tilt_angle: Some(1.2),
            lift_head_pressure: Some(14e6),
            lift_rod_pressure: Some(1e6),
            ..Sample::default()
        });
    }
    assert_eq!(said, None);
}

/// Seconds of standing like this.
fn stays(seconds: usize, posture: [f64; 2], load: f64) -> impl Iterator<Item = Second> {
    (0..seconds).map(move |_| Second(posture[0], posture[1], load, 1.0))
}

#[test]
fn a_bucket_that_rests_on_the_ground_says_nothing_of_the_description() {
    let mut work: Vec<Second> = stays(20, [-0.66, 0.35], 0.0).collect();
    work.extend(stays(10, [-0.4, 0.35], 0.0));
    for part in [0.1, 0.5] {
        let said = run_shown(&work, &|lift, head| {
            if lift < -0.64 { part * head } else { head }
        });
        let at = |second: usize| said[second].expect("fresh");
        assert!(part > 0.25 || at(15).open, "{:?}", at(15));
        let after = at(29);
        assert!(!after.open && !after.wrong, "{part}: {after:?}");
        assert!(after.payload.value.abs() < 50.0 && after.payload.std < 500.0);
    }
}

#[test]
fn a_pressure_that_reads_nothing_is_no_weight() {
    let mut work: Vec<Second> = stays(8, [-0.5, 0.75], 3600.0).collect();
    work.extend(stays(20, [0.5, 0.75], 3600.0));
    let rows = core::cell::Cell::new(0);
    let said = run_shown(&work, &|_, head| {
        rows.set(rows.get() + 1);
        // .6 s each 5 s.
        if rows.get() % 500 < 60 { 0.0 } else { head }
    });
    for weighed in said[7..].iter().flatten().filter(|w| !w.open) {
        let Weighed { payload, wrong, .. } = *weighed;
        let error = (payload.value - 3600.0).abs();
        assert!(error < 1.96 * payload.std && !wrong, "{payload:?}");
    }
}

#[test]
fn a_load_that_the_rear_axle_cannot_balance_is_not_believed() {
    let work: Vec<Second> = stays(20, [0.5, 0.75], 3600.0).collect();
    let at = |gain: f64| run_shown(&work, &|_, head| gain * head)[19].expect("fresh");
    assert!(!at(1.0).wrong && !at(1.3).wrong);
    let wrong = at(4.0);
    assert!(wrong.wrong && wrong.payload.value > 15_000.0, "{wrong:?}");
}

#[test]
fn a_load_that_comes_or_goes_slowly_is_not_held_for_friction() {
    let mut work: Vec<Second> = stays(6, [0.5, 0.75], 3600.0).collect();
    // Dumped at .06 rad/s.
    work.extend((1..=20).map(|k| {
        let part = f64::from(k) / 20.0;
        Second(0.5, 0.75 - 1.2 * part, 3600.0 * (1.0 - part), 1.0)
    }));
    work.extend(stays(6, [0.5, -0.45], 0.0));
    work.push(Second(-0.5, 0.2, 0.0, -1.0));
    work.extend(stays(8, [-0.5, 0.2], 0.0));
    // Filled from above in 15 s.
    work.extend((1..=15).map(|k| Second(-0.5, 0.2, 240.0 * f64::from(k), -1.0)));
    work.extend(stays(8, [-0.5, 0.2], 3600.0));
    let mut open = 0;
    for (second, (said, by)) in run(&work).iter().zip(&work).enumerate().skip(3) {
        let Weighed {
            payload,
            open: is_open,
            ..
        } = said.expect("fresh");
        open += usize::from(is_open);
        let error = (payload.value - by.2).abs();
        assert!(is_open || error < 500.0, "{second}: {payload:?} {}", by.2);
    }
    assert!(open < 30, "{open}");
}
