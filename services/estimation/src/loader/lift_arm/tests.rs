extern crate std;
use super::*;
use crate::loader::keys::{LiftArm, LiftCylinder};
use crate::math::norm;
use std::vec::Vec;

/// Greatest age of a value that counts [s].
const FRESH: f64 = Settings::DEFAULT.estimator.fresh;

/// A 12 t loader; its pressures are computed from the statics of its own drawing.
pub(super) fn settings() -> Settings {
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
        bucket_turn: Some(1.0),
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

#[test]
fn the_place_of_a_load_has_the_errors_of_the_drawing() {
    let settings = settings();
    let lifts = Lifts::new(&settings).expect("a described arm");
    let [ahead, above] = lifts.load_place(0.0, 0.0);
    // All level: the lengths add up, and the zeros of the angles raise the load.
    let (arm, load, zero) = (2.68, 0.59, settings.sensors.angle_offset_std);
    let along = norm(&[0.01 * arm, 0.01 * arm, 0.1 * load]);
    let up = norm(&[
        0.01 * arm,
        zero * (arm + load),
        zero * load,
        0.5 * 0.1 * load,
    ]);
    for (found, value, std) in [(ahead, arm + load - 1.05, along), (above, 1.32, up)] {
        assert!((found.value - value).abs() < 1e-12, "{found:?}");
        // An angle of the size of the zeros is no differential.
        assert!((found.std / std - 1.0).abs() < 1e-3, "{found:?} {std}");
    }
}

/// One second of work: angles of arm and bucket [rad] and payload [kg] at its end, and direction of the friction.
struct Second(f64, f64, f64, f64);

/// Estimates at the end of each second.
fn run(seconds: &[Second]) -> Vec<Option<Weighed>> {
    run_shown(seconds, &|_, head| head)
}

/// The same where the sensor shows another head pressure, a function of the arm's angle and the true pressure.
fn run_shown(seconds: &[Second], shown: &dyn Fn(f64, f64) -> f64) -> Vec<Option<Weighed>> {
    let sensors = Sensors {
        shown,
        rod: Some(0.7e6),
        lost: &none_lost,
    };
    estimates_with_sensors(seconds, 1.0, Some(1.0), &sensors)
}

/// Sensors: head pressure shown, a function of the arm's angle and the true pressure, and rod pressure shown.
struct Sensors<'a> {
    shown: &'a dyn Fn(f64, f64) -> f64,
    rod: Option<f64>,
    /// Removes values from a row, by its number.
    lost: &'a dyn Fn(u32, &mut Sample),
}

/// Nothing is missing.
fn none_lost(_: u32, _: &mut Sample) {}

/// The same of a machine with the bucket turn `turn`; the machine file has `stated`.
fn estimates_with_turn(seconds: &[Second], turn: f64, stated: Option<f64>) -> Vec<Option<Weighed>> {
    let sensors = Sensors {
        shown: &|_, head| head,
        rod: Some(0.7e6),
        lost: &none_lost,
    };
    estimates_with_sensors(seconds, turn, stated, &sensors)
}

/// The same with other sensors.
fn estimates_with_sensors(
    seconds: &[Second],
    turn: f64,
    stated: Option<f64>,
    sensors: &Sensors<'_>,
) -> Vec<Option<Weighed>> {
    let mut settings = settings();
    settings.lift_arm.bucket_turn = Some(turn);
    let drawing = Drawing::of(&settings).expect("a described arm");
    settings.lift_arm.bucket_turn = stated;
    let mut witness = LiftWitness::new(&settings).expect("a described arm");
    let (mut lift, mut bucket, mut load, mut time) = (seconds[0].0, seconds[0].1, 0.0, 0.0);
    let (mut estimates, mut row) = (Vec::new(), 0);
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
            let mut sample = Sample {
                time,
                lift_angle: Some(lift),
                tilt_angle: Some(bucket - lift),
                lift_head_pressure: Some((sensors.shown)(lift, missing / per_pascal)),
                lift_rod_pressure: sensors.rod,
                acceleration: Some(0.0),
                ..Sample::default()
            };
            (sensors.lost)(row, &mut sample);
            row += 1;
            estimates.push(witness.step(&sample, FRESH).map(|estimate| *estimate));
        }
    }
    estimates.into_iter().skip(99).step_by(100).collect()
}

#[test]
fn an_arm_that_is_not_described_does_not_weigh() {
    assert!(LiftWitness::new(&Settings::DEFAULT).is_none());
}

#[test]
fn a_payload_is_reported_from_the_first_row_on_where_an_arm_is_described() {
    use crate::loader::{CgEstimator, Columns, Method};
    let settings = settings();
    let columns = Columns::default();
    let mut estimator = CgEstimator::new(&settings, Method::Full, columns).unwrap();
    // Without pressure the payload is the prior, and never trusted.
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
    // Empty and low, lowered before; digs and curls; carries; lifts; stands; dumps; stands.
    work.extend((0..6).map(|k| Second(-0.5 - 0.03 * f64::from(k.min(4)), 0.0, 0.0, -1.0)));
    work.push(Second(-0.6, 0.4, 2000.0, 1.0));
    work.push(Second(-0.5, 0.75, 3600.0, 1.0));
    work.extend((0..6).map(|_| Second(-0.5, 0.75, 3600.0, 1.0)));
    work.extend((1..=4).map(|k| Second(-0.5 + 0.25 * f64::from(k), 0.75, 3600.0, 1.0)));
    work.extend((0..4).map(|_| Second(0.5, 0.75, 3600.0, 1.0)));
    work.push(Second(0.5, -0.75, 0.0, 1.0));
    work.extend((0..4).map(|_| Second(0.5, -0.75, 0.0, 1.0)));
    let estimates = run(&work);
    let at = |second: usize| estimates[second].expect("fresh");
    assert!(at(7).carried.open && at(7).payload.std > 1000.0);
    for (second, payload) in [(5, 0.0), (13, 3600.0), (21, 3600.0), (26, 0.0)] {
        let found = at(second);
        let error = (found.payload.value - payload).abs();
        assert!(!found.carried.open, "{second}");
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

/// Loads that are filled low, lifted and dumped, the bucket turning with the arm by `up` and `down`; the seconds in which one is carried.
fn loading(cycles: u32, [up, down]: [f64; 2]) -> (Vec<Second>, Vec<usize>) {
    let (mut work, mut carried) = (Vec::new(), Vec::new());
    for _ in 0..cycles {
        work.extend((0..3).map(|_| Second(-0.6, 0.0, 0.0, -1.0)));
        work.push(Second(-0.6, 0.4, 2000.0, 1.0));
        work.push(Second(-0.5, 0.7, 3600.0, 1.0));
        work.extend((0..6).map(|_| Second(-0.5, 0.7, 3600.0, 1.0)));
        let rises = |k: i32| 0.25 * f64::from(k);
        work.extend((1..=4).map(|k| Second(-0.5 + rises(k), 0.7 + up * rises(k), 3600.0, 1.0)));
        work.extend((0..3).map(|_| Second(0.5, 0.7 + up, 3600.0, 1.0)));
        carried.push(work.len() - 1);
        work.push(Second(0.5, -0.7, 0.0, 1.0));
        work.extend((0..3).map(|_| Second(0.5, -0.7, 0.0, 1.0)));
        work.push(Second(0.5, 0.3, 0.0, 1.0));
        work.extend((1..=4).map(|k| Second(0.5 - rises(k), 0.3 - down * rises(k), 0.0, -1.0)));
        work.push(Second(-0.6, 0.0, 0.0, -1.0));
    }
    (work, carried)
}

#[test]
fn a_tilt_cylinder_on_the_frame_carries_a_part_of_the_load() {
    let (work, carried) = loading(4, [0.15; 2]);
    let weighed = |stated| {
        let estimates = estimates_with_turn(&work, 0.15, stated);
        let last = *carried.last().expect("a load");
        estimates[last].expect("fresh").payload
    };
    let by = weighed(Some(0.15));
    assert!((by.value - 3600.0).abs() < 60.0, "{by:?}");
    // Not stated: an operator may have turned the bucket as well.
    let open = weighed(None);
    assert!((open.value - 3600.0).abs() < 1.96 * open.std, "{open:?}");
    assert!(open.std > by.std, "{open:?} {by:?}");
    // With the cylinder on the arm the payload would be an eighth less.
    let other = weighed(Some(1.0));
    assert!(other.value < 0.9 * 3600.0, "{other:?}");
}

#[test]
fn where_a_hand_levels_the_bucket_the_interval_holds_both_cylinders() {
    let (work, carried) = loading(4, [0.0, 0.6]);
    for turn in [0.0, 0.2, 1.0] {
        let estimates = estimates_with_turn(&work, turn, None);
        for second in &carried {
            let payload = estimates[*second].expect("fresh").payload;
            let error = (payload.value - 3600.0).abs();
            assert!(error < 1.96 * payload.std, "{turn}: {payload:?}");
        }
    }
}

/// Estimate at the end of a second load of 3600 kg that is filled low and lifted.
fn lifted(shown: impl Fn(f64, f64) -> f64, rod: Option<f64>) -> Weighed {
    let (mut work, carried) = loading(2, [0.15; 2]);
    let last = *carried.last().expect("a load");
    work.truncate(last + 1);
    let sensors = Sensors {
        shown: &shown,
        rod,
        lost: &none_lost,
    };
    let estimates = estimates_with_sensors(&work, 0.15, Some(0.15), &sensors);
    estimates[last].expect("fresh")
}

#[test]
fn a_pressure_that_is_trapped_at_the_top_stop_is_no_load() {
    let top = |lift: f64, head: f64| if lift > 0.49 { 26e6 } else { head };
    let Weighed {
        payload,
        carried: Carried { open, .. },
        ..
    } = lifted(top, Some(0.7e6));
    assert!(
        !open && (payload.value - 3600.0).abs() < 100.0,
        "{payload:?}"
    );
}

#[test]
fn an_arm_that_rests_on_its_lower_stop_weighs_nothing_that_is_less_than_empty() {
    let rests = |lift: f64, head: f64| if lift < -0.58 { 0.8e6 } else { head };
    let (work, carried) = loading(3, [0.15; 2]);
    let sensors = Sensors {
        shown: &rests,
        rod: Some(0.7e6),
        lost: &none_lost,
    };
    let estimates = estimates_with_sensors(&work, 0.15, Some(0.15), &sensors);
    let last = estimates[*carried.last().expect("a load")]
        .expect("fresh")
        .payload;
    assert!((last.value - 3600.0).abs() < 100.0, "{last:?}");
    for (second, weighed) in estimates
        .iter()
        .enumerate()
        .filter(|(_, w)| w.is_some_and(|w| !w.carried.open))
    {
        let payload = weighed.expect("fresh").payload;
        let error = (payload.value - work[second].2).abs();
        assert!(error < 1.96 * payload.std, "{second}: {payload:?}");
    }
}

#[test]
fn a_sensor_at_its_end_weighs_no_less() {
    let free = lifted(|_, head| head, Some(0.7e6)).payload;
    let clipped = lifted(|_, head| head.min(9e6), Some(0.7e6)).payload;
    assert!((free.value - 3600.0).abs() < 60.0, "{free:?}");
    assert!(
        (clipped.value - 3600.0).abs() < 1.96 * clipped.std,
        "{clipped:?}"
    );
}

#[test]
fn a_rod_pressure_that_nobody_measures_is_an_uncertain_one() {
    let error = |more: f64| {
        // The head side balances the rod side.
        let weighed = lifted(|_, head| head + more * 2.38 / 4.33, None).payload;
        (weighed.value - 3600.0).abs() / weighed.std
    };
    assert!(
        error(0.0) < 1.96 && error(2.0e6) < 1.96,
        "{} {}",
        error(0.0),
        error(2.0e6)
    );
}

#[test]
fn the_gain_of_a_pressure_sensor_that_nobody_checked_is_in_doubt() {
    let gained = |by: f64| lifted(|_, head| by * head, Some(0.7e6)).payload;
    let [sound, off] = [gained(1.0), gained(1.1)];
    assert!((sound.value - 3600.0).abs() < 60.0, "{sound:?}");
    assert!((off.value - 3600.0).abs() < 1.96 * off.std, "{off:?}");
}

/// An emptied bucket is little informative of the gain at the pressure of a load; a calibrated span determines it.
#[test]
fn a_gain_that_is_wrong_for_loads_alone_is_in_doubt_until_it_is_calibrated() {
    let left = |std: f64| {
        let mut settings = settings();
        settings.lift_cylinder.span_std = std;
        Drawing::of(&settings)
            .expect("a described arm")
            .gain_left_std
    };
    assert_eq!(left(0.01), 0.0);
    assert!((left(0.0) - 0.06).abs() < 1e-12);
    let off = lifted(
        |_, head| if head > 6e6 { 1.1 * head } else { head },
        Some(0.7e6),
    )
    .payload;
    assert!((off.value - 3600.0).abs() < 1.96 * off.std, "{off:?}");
}

#[test]
fn a_pressure_that_is_stuck_while_machine_or_arm_move_is_not_used() {
    let last = |seconds: f64, speed: f64, rate: f64| {
        let mut witness = LiftWitness::new(&settings()).expect("a described arm");
        let mut said = None;
        for k in 0..(100.0 * seconds) as u32 {
            let time = 0.01 * f64::from(k);
            let row = Sample {
                time,
                speed: Some(speed),
                lift_angle: Some(-0.5 + rate * time + 1e-4 * f64::from(k % 7)),
                tilt_angle: Some(1.2),
                lift_head_pressure: Some(14e6),
                lift_rod_pressure: Some(1e6),
                ..Sample::default()
            };
            said = witness.step(&row, FRESH).map(|said| *said);
        }
        said.expect("a prediction")
    };
    for stuck in [last(6.0, 2.0, 0.0), last(2.0, 0.0, 0.2)] {
        assert!(stuck.silent && stuck.carried.open, "{stuck:?}");
        let capacity = stuck.payload.value / 0.5;
        assert!(stuck.payload.std > 0.4 * capacity, "{stuck:?}");
    }
    assert!(
        !last(6.0, 0.0, 0.0).silent,
        "who stands repeats its pressure"
    );
}

#[test]
fn a_bucket_that_turns_low_may_lie_on_the_ground_and_one_that_turns_high_may_not() {
    let turned = |lift: f64| {
        let work = [0.7, 0.7, -0.3].map(|bucket| Second(lift, bucket, 0.0, 0.0));
        let last = run(&work).last().copied().flatten().expect("fresh");
        (last.carried.open, last.carried.rests)
    };
    assert_eq!(turned(-0.6), (true, true));
    assert_eq!(turned(0.3), (true, false));
}

#[test]
fn an_arm_carried_in_an_odd_posture_at_first_weighs_once_it_is_carried_well() {
    let mut witness = LiftWitness::new(&settings()).expect("a described arm");
    let mut drive = |rows: core::ops::Range<u32>, tilt: f64| {
        let mut estimate = None;
        for k in rows {
            let row = Sample {
                time: 0.01 * f64::from(k),
                speed: Some(2.0),
                lift_angle: Some(-0.5 + 1e-4 * f64::from(k % 5)),
                tilt_angle: Some(tilt),
                lift_head_pressure: Some(5e6 + 1e4 * f64::from(k % 7)),
                lift_rod_pressure: Some(1e6),
                ..Sample::default()
            };
            estimate = witness.step(&row, FRESH).map(|estimate| *estimate);
        }
        estimate
    };
    assert_eq!(drive(0..300, -0.7), None, "turned over");
    assert!(drive(300..1000, 1.2).is_some(), "as others are");
}

#[test]
fn a_row_whose_time_is_refused_changes_no_load() {
    use crate::loader::{CgEstimator, Columns, Method, Status};
    let columns = Columns::default();
    let mut a = CgEstimator::new(&settings(), Method::FullEkf, columns).unwrap();
    for k in 0..300 {
        a.step(&stands(k));
    }
    let mut b = a;
    for late in [299, 298] {
        let twice = Sample {
            lift_head_pressure: Some(2e6),
            ..stands(late)
        };
        assert_eq!(b.step(&twice).status, Status::Refused);
    }
    let (unchanged, other) = (a.step(&stands(300)), b.step(&stands(300)));
    assert_eq!(unchanged.payload, other.payload);
    assert_eq!(unchanged.cg_ratio, other.cg_ratio);
}

/// Row `k` of a standing machine, with a noisy pressure.
fn stands(k: u32) -> Sample {
    Sample {
        time: 0.01 * f64::from(k),
        speed: Some(0.0),
        front_wheel_speed: Some(0.0),
        rear_wheel_speed: Some(0.0),
        front_torque: Some(0.0),
        rear_torque: Some(0.0),
        slope: Some(0.0),
        acceleration: Some(0.0),
        lift_angle: Some(0.1),
        tilt_angle: Some(0.5),
        lift_head_pressure: Some(9e6 + 1e4 * f64::from(k % 3)),
        ..Sample::default()
    }
}

/// Seconds of standing in this posture with this load.
fn stays(seconds: usize, posture: [f64; 2], load: f64) -> impl Iterator<Item = Second> {
    (0..seconds).map(move |_| Second(posture[0], posture[1], load, 1.0))
}

#[test]
fn a_bucket_that_rests_on_the_ground_is_no_evidence_against_the_description() {
    let mut work: Vec<Second> = stays(20, [-0.66, 0.35], 0.0).collect();
    work.extend(stays(10, [-0.4, 0.35], 0.0));
    for part in [0.1, 0.5] {
        let estimates = run_shown(&work, &|lift, head| {
            if lift < -0.64 { part * head } else { head }
        });
        let at = |second: usize| estimates[second].expect("fresh");
        assert!(part > 0.25 || at(15).carried.open, "{:?}", at(15));
        let after = at(29);
        assert!(!after.carried.open && !after.wrong, "{part}: {after:?}");
        assert!(after.payload.value.abs() < 50.0 && after.payload.std < 500.0);
    }
}

#[test]
fn a_pressure_that_reads_nothing_is_no_weight() {
    let mut work: Vec<Second> = stays(8, [-0.5, 0.75], 3600.0).collect();
    work.extend(stays(20, [0.5, 0.75], 3600.0));
    let rows = core::cell::Cell::new(0);
    let estimates = run_shown(&work, &|_, head| {
        rows.set(rows.get() + 1);
        // .6 s each 5 s.
        if rows.get() % 500 < 60 { 0.0 } else { head }
    });
    for weighed in estimates[7..].iter().flatten().filter(|w| !w.carried.open) {
        let Weighed { payload, wrong, .. } = *weighed;
        let error = (payload.value - 3600.0).abs();
        assert!(error < 1.96 * payload.std && !wrong, "{payload:?}");
    }
}

#[test]
fn a_load_that_the_rear_axle_cannot_balance_is_not_trusted() {
    let work: Vec<Second> = stays(20, [0.5, 0.75], 3600.0).collect();
    let rows = core::cell::Cell::new(0);
    let at = |gain: f64| {
        // With noise: a sensor that repeats a value is at the end of its range.
        let shown = |_, head: f64| {
            rows.set(rows.get() + 1);
            gain * head + 1e4 * f64::from(rows.get() % 3)
        };
        run_shown(&work, &shown)[19].expect("fresh")
    };
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
    for (second, (estimate, by)) in run(&work).iter().zip(&work).enumerate().skip(3) {
        let Weighed {
            payload,
            carried: Carried { open: is_open, .. },
            ..
        } = estimate.expect("fresh");
        open += usize::from(is_open);
        let error = (payload.value - by.2).abs();
        assert!(is_open || error < 500.0, "{second}: {payload:?} {}", by.2);
    }
    assert!(open < 30, "{open}");
}

#[test]
fn a_machine_that_rocks_after_a_stop_holds_the_same_load() {
    let work: Vec<Second> = stays(30, [0.5, 0.75], 3600.0).collect();
    let rows = core::cell::Cell::new(0);
    // From 10 s on the pressure swings by half at 2 Hz, and decays in a second.
    let swings = |_, head: f64| {
        rows.set(rows.get() + 1);
        let time = 0.01 * f64::from(rows.get() - 990);
        let swing = if time > 0.0 {
            -0.5 * (-time).exp() * (12.0 * time).sin()
        } else {
            0.0
        };
        (1.0 + swing) * head
    };
    // A pressure that drops by half for .1 s.
    let breaks_in = |_, head: f64| {
        rows.set(rows.get() + 1);
        let share = if (985..995).contains(&rows.get()) {
            0.5
        } else {
            1.0
        };
        share * head
    };
    let shown: [&dyn Fn(f64, f64) -> f64; 2] = [&swings, &breaks_in];
    for shown in shown {
        rows.set(0);
        let estimates = run_shown(&work, shown);
        for (second, weighed) in estimates[8..]
            .iter()
            .flatten()
            .enumerate()
            .filter(|(_, w)| !w.carried.open)
        {
            let Weighed { payload, .. } = *weighed;
            let error = (payload.value - 3600.0).abs();
            assert!(error < 1.96 * payload.std, "{second}: {payload:?}");
        }
        let after = estimates[20].expect("fresh");
        assert!(
            !after.carried.open && after.payload.std < 500.0,
            "{after:?}"
        );
    }
}

/// Estimates of loads that are lifted, with rows that miss values.
fn weighed_without(lost: impl Fn(u32, &mut Sample)) -> Vec<(Second, Option<Weighed>)> {
    let (work, _) = loading(2, [0.15; 2]);
    let sensors = Sensors {
        shown: &|_, head| head,
        rod: Some(0.7e6),
        lost: &lost,
    };
    let estimates = estimates_with_sensors(&work, 0.15, Some(0.15), &sensors);
    work.into_iter().zip(estimates).collect()
}

/// Number of seconds that end with a known load; none of them may be wrong.
fn known_loads(estimates: &[(Second, Option<Weighed>)]) -> usize {
    let closed = |(second, weighed): &(Second, Option<Weighed>)| {
        let Weighed {
            payload,
            carried: Carried { open, .. },
            ..
        } = (*weighed)?;
        let error = (payload.value - second.2).abs();
        assert!(
            open || error < 1.96 * payload.std,
            "{} {payload:?}",
            second.2
        );
        (!open && error < 100.0).then_some(())
    };
    estimates.iter().filter_map(closed).count()
}

#[test]
fn a_cell_that_is_missing_now_and_then_is_the_last_one() {
    let all = known_loads(&weighed_without(none_lost));
    assert!(all > 25, "{all}");
    let tilt = weighed_without(|row, sample| {
        if row % 10 == 3 {
            sample.tilt_angle = None;
        }
    });
    let rod = weighed_without(|row, sample| {
        if row % 20 != 3 {
            sample.lift_rod_pressure = None;
        }
    });
    // Angles in even rows, pressures in odd ones.
    let in_turn = weighed_without(|row, sample| {
        if row % 2 == 0 {
            (sample.lift_head_pressure, sample.lift_rod_pressure) = (None, None);
        } else {
            (sample.lift_angle, sample.tilt_angle) = (None, None);
        }
    });
    for estimates in [tilt, rod, in_turn] {
        let known = known_loads(&estimates);
        assert!(known + 2 >= all, "{known} of {all}");
    }
}

#[test]
fn an_angle_that_is_too_old_weighs_nothing() {
    let angles: [fn(&mut Sample); 2] = [
        |sample| sample.tilt_angle = None,
        |sample| sample.lift_angle = None,
    ];
    for lose in angles {
        let estimates = weighed_without(|row, sample| {
            if row >= 500 {
                lose(sample);
            }
        });
        assert!(estimates[4].1.is_some());
        assert!(
            estimates[5..]
                .iter()
                .all(|(_, weighed)| weighed.is_none_or(|w| w.carried.open))
        );
    }
}

#[test]
fn an_arm_whose_signals_are_missing_may_hold_another_load_elsewhere() {
    let silent: [fn(&mut Sample); 2] = [
        |sample| sample.lift_head_pressure = None,
        |sample| {
            (sample.lift_angle, sample.tilt_angle) = (None, None);
            sample.lift_head_pressure = None;
        },
    ];
    let all = weighed_without(none_lost);
    for lose in silent {
        // Silent from the first load on, which is carried, dumped, and followed by another.
        let from = 1200;
        let estimates = weighed_without(|row, sample| {
            if row >= from {
                lose(sample);
            }
        });
        for ((_, now), (_, sees)) in estimates.iter().zip(&all).skip(12) {
            let (now, sees) = (now.expect("it was weighed"), sees.expect("fresh"));
            assert!(now.silent && now.carried.open && !sees.silent);
            for (may, is) in [
                (now.ratio, sees.ratio),
                (now.height, sees.height),
                (now.payload, sees.payload),
            ] {
                assert!(
                    (may.value - is.value).abs() < 1.96 * may.std,
                    "{may:?} {is:?}"
                );
            }
        }
        // The deviation grows with the age of the last weight.
        let std = |second: usize| estimates[second].1.expect("weighed").payload.std;
        assert!(
            std(12) < std(16) && std(16) < std(24),
            "{} {} {}",
            std(12),
            std(16),
            std(24)
        );
    }
    // Before the first weight there is no estimate.
    let never = weighed_without(|_, sample| sample.lift_head_pressure = None);
    assert!(never.iter().all(|(_, weighed)| weighed.is_none()));
}

#[test]
fn a_silent_arm_names_what_is_missing_and_a_reported_load_counts_then() {
    use crate::loader::load::payload::Payload;
    use crate::loader::{CgEstimator, Columns, Method, Reason};
    let settings = settings();
    let answers = |reported: Option<Payload>| {
        let columns = Columns { acceleration: true };
        let mut estimator = CgEstimator::new(&settings, Method::Full, columns).unwrap();
        estimator.set_payload(reported);
        // A noisy pressure, missing from the third second on.
        let row = |k: u32| Sample {
            lift_head_pressure: stands(k).lift_head_pressure.filter(|_| k < 300),
            ..stands(k)
        };
        (0..600)
            .map(|k| estimator.step(&row(k)))
            .collect::<Vec<_>>()
    };
    let unreported = answers(None);
    assert!(unreported[310].fresh, "as old as an input may be");
    let last = unreported[599];
    assert!(!last.fresh && last.reason == Reason::Missing, "{last:?}");
    assert!(!last.trusted_ratio && !last.trusted_height && !last.trusted_payload);
    assert!(last.cg_ratio.std > 2.0 * unreported[299].cg_ratio.std);
    let told = answers(Some(Payload::new(2000.0, 1.5, 1.3)))[599];
    assert!(told.cg_ratio.std < last.cg_ratio.std, "{told:?} {last:?}");
}

#[test]
fn a_load_is_not_trusted_while_its_tilt_cylinder_may_be_in_either_place() {
    use crate::loader::{CgEstimator, Columns, Method};
    let weighed = |turn: Option<f64>, head: f64| {
        let mut settings = settings();
        settings.lift_arm.bucket_turn = turn;
        let mut estimator =
            CgEstimator::new(&settings, Method::FullEkf, Columns::default()).unwrap();
        let row = |k: u32| Sample {
            time: 0.01 * f64::from(k),
            speed: Some(0.0),
            lift_angle: Some(0.1),
            tilt_angle: Some(0.0),
            lift_head_pressure: Some(head + 1e4 * f64::from(k % 3)),
            lift_rod_pressure: Some(0.7e6),
            acceleration: Some(0.0),
            ..Sample::default()
        };
        let last = (0..1000).map(|k| estimator.step(&row(k))).last();
        // A clock that hangs.
        let hung = (0..100).map(|_| estimator.step(&row(999))).last();
        assert!(!hung.expect("rows").trusted_payload);
        last.expect("rows")
    };
    let full = 16e6;
    let [stated, open] = [Some(0.15), None].map(|turn| weighed(turn, full));
    assert!(stated.trusted_payload && !open.trusted_payload, "{open:?}");
    assert!(open.payload.expect("weighed").value > 2500.0, "{open:?}");
    let light = weighed(None, 7e6);
    assert!(light.trusted_payload, "{light:?}");
}

/// Estimates at the end of each second of a load that is filled, carried and dumped twice. `sensor`: head pressure shown, a function of the
/// number of the row (100 a second) and the true pressure.
fn carried_twice(sensor: &dyn Fn(u32, f64) -> f64) -> Vec<Weighed> {
    let (work, _) = loading(2, [1.0, 1.0]);
    let row = core::cell::Cell::new(0);
    let shown = |_: f64, head: f64| {
        row.set(row.get() + 1);
        sensor(row.get(), head)
    };
    run_shown(&work, &shown).into_iter().flatten().collect()
}

#[test]
fn a_lift_pressure_that_steps_while_a_load_is_carried_is_not_trusted() {
    // The first load is carried from the sixth to the tenth second on.
    for gain in [0.8, 1.25, 2.0] {
        let estimates = carried_twice(&|row, head| if row > 820 { gain * head } else { head });
        let (before, after) = (&estimates[7], &estimates[9]);
        assert!(!before.wrong && after.wrong, "{gain}");
        let away = (after.payload.value - 3600.0).abs();
        assert!(away < 1.96 * after.payload.std, "{gain}: {after:?}");
        assert!(
            estimates[10..].iter().all(|estimate| estimate.wrong),
            "{gain}"
        );
    }
    let blow = carried_twice(&|row, head| {
        if (820..830).contains(&row) {
            1.5 * head
        } else {
            head
        }
    });
    assert!(blow.iter().all(|estimate| !estimate.wrong));
}

/// Estimates of an empty bucket that is lowered flat within two seconds, and then shows this part of its pressure for six; driven at
/// `speed` [m/s], by torques that do not push.
fn lowered_flat(part: f64, speed: f64) -> Vec<Weighed> {
    let mut work: Vec<Second> = stays(8, [0.2, 0.0], 0.0).collect();
    work.extend([Second(-0.2, 0.0, 0.0, -1.0), Second(-0.55, 0.0, 0.0, -1.0)]);
    work.extend((0..6).map(|_| Second(-0.55, 0.0, 0.0, -1.0)));
    let drives = |row: u32, sample: &mut Sample| {
        sample.speed = Some(speed);
        (sample.front_torque, sample.rear_torque) = (Some(0.0), Some(0.0));
        // With noise: a working sensor repeats no value.
        let noise = f64::from(row % 3);
        sample.lift_head_pressure = sample.lift_head_pressure.map(|head| head + 1e4 * noise);
        sample.lift_angle = sample.lift_angle.map(|lift| lift + 1e-4 * noise);
    };
    let sensors = Sensors {
        shown: &|lift, head| if lift < -0.53 { part * head } else { head },
        rod: Some(0.7e6),
        lost: &drives,
    };
    let estimates = estimates_with_sensors(&work, 1.0, Some(1.0), &sensors);
    estimates.into_iter().flatten().collect()
}

#[test]
fn a_bucket_that_drags_over_the_ground_while_the_machine_backs_weighs_nothing() {
    let drags = lowered_flat(0.6, -2.0);
    assert!(
        drags[11..].iter().all(|weighed| weighed.carried.rests),
        "{drags:?}"
    );
    let hangs = lowered_flat(1.0, -2.0);
    assert!(hangs[11..].iter().all(|weighed| !weighed.carried.open));
}

#[test]
fn a_heap_that_a_flat_bucket_drives_into_is_no_load() {
    let in_the_heap = lowered_flat(4.0, 0.5);
    assert!(
        in_the_heap[11..]
            .iter()
            .all(|weighed| weighed.carried.rests),
        "{in_the_heap:?}"
    );
}
