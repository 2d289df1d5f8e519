//! The loader's estimator with rows that it must not trust.

use std::ops::Range;

use estimation::loader::keys::Description;
use estimation::loader::{
    CgEstimator, Columns, Estimate, Machine, Method, Payload, Sample, Settings, Status,
};

const COLUMNS: Columns = Columns { acceleration: true };

fn estimator(method: Method) -> CgEstimator {
    with_columns(method, COLUMNS)
}

fn with_columns(method: Method, columns: Columns) -> CgEstimator {
    let settings = Settings::of(&Description::default(), method);
    CgEstimator::new(&settings, method, columns).unwrap()
}

/// Steady driving at 2.5 m/s on a level road: the torque balances only the rolling resistance.
fn cruise(time: f64) -> Sample {
    let machine = Machine::default();
    let force = machine.rolling_resistance * machine.mass * 9.81;
    let torque = 0.5 * force * machine.wheel_radius;
    let slip = |share: f64| 0.5 * force / (19.0 * share * machine.mass * 9.81);
    Sample {
        time,
        speed: Some(2.5),
        front_wheel_speed: Some(2.5 * (1.0 + slip(0.45)) / machine.wheel_radius),
        rear_wheel_speed: Some(2.5 * (1.0 + slip(0.55)) / machine.wheel_radius),
        front_torque: Some(torque),
        rear_torque: Some(torque),
        slope: Some(0.0),
        acceleration: Some(0.0),
        mass: Some(machine.mass),
        spade_force_x: Some(0.0),
        spade_force_z: Some(0.0),
        ..Sample::default()
    }
}

/// Cruises at 100 Hz through these rows, and returns the last answer.
fn drive(estimator: &mut CgEstimator, rows: Range<u32>) -> Estimate {
    for k in rows {
        estimator.step(&cruise(f64::from(k) * 0.01));
    }
    *estimator.last()
}

fn numbers(e: &Estimate) -> Vec<f64> {
    let mut all = vec![
        e.time,
        e.speed,
        e.front_wheel_speed,
        e.rear_wheel_speed,
        e.cg_distance,
        e.nis,
    ];
    for q in [
        Some(e.slip_stiffness),
        Some(e.cg_height),
        Some(e.cg_ratio),
        e.spade_force_x,
    ] {
        all.extend(q.iter().flat_map(|q| [q.value, q.std]));
    }
    all.extend(
        [e.slope_bias, e.front_radius_scale, e.rear_radius_scale]
            .iter()
            .flatten(),
    );
    all
}

/// A row whose cells are drawn from the values of a broken bus.
fn nasty(k: u64) -> Sample {
    const CELLS: [Option<f64>; 12] = [
        None,
        Some(f64::NAN),
        Some(f64::INFINITY),
        Some(f64::NEG_INFINITY),
        Some(f64::MAX),
        Some(-1e300),
        Some(1e9),
        Some(-1e6),
        Some(0.0),
        Some(f64::MIN_POSITIVE),
        Some(1.0),
        Some(-3.0),
    ];
    let mut seed = k.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03;
    let mut cell = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        CELLS[(seed % 12) as usize]
    };
    Sample {
        time: k as f64 * 0.01,
        speed: cell(),
        front_wheel_speed: cell(),
        rear_wheel_speed: cell(),
        front_torque: cell(),
        rear_torque: cell(),
        slope: cell(),
        acceleration: cell(),
        mass: cell(),
        spade_force_x: cell(),
        spade_force_z: cell(),
        boom_moving: k.is_multiple_of(5),
        articulation: cell(),
        yaw_rate: cell(),
        brake: k.is_multiple_of(7),
        lift_angle: cell(),
        tilt_angle: cell(),
        lift_head_pressure: cell(),
        lift_rod_pressure: cell(),
        truck: cell(),
    }
}

#[test]
fn every_answer_is_finite_whatever_the_rows_hold() {
    for method in Method::ALL {
        for acceleration in [true, false] {
            let columns = Columns { acceleration };
            let mut estimator = with_columns(method, columns);
            for k in 0..3000 {
                let answer = estimator.step(&nasty(k));
                let finite = numbers(&answer).iter().all(|x| x.is_finite());
                assert!(finite, "{method}, row {k}: {answer:?}");
            }
        }
    }
}

#[test]
fn what_no_drive_and_no_road_can_do_is_as_if_it_were_missing() {
    type Fault = fn(&mut Sample, Option<f64>);
    let signals: [(Fault, &[f64]); 3] = [
        (
            |row, word| row.front_torque = word,
            &[65_535.0, -1e5, 6.5e7],
        ),
        (|row, word| row.rear_torque = word, &[65_535.0, -1e5, 6.5e7]),
        (|row, word| row.slope = word, &[0.6, -0.7, 1.2]),
    ];
    for (fault, words) in signals {
        let with = |word: Option<f64>| {
            let mut estimator = estimator(Method::Full);
            let rows = (0..600_u32).map(|k| {
                let time = f64::from(k) * 0.01;
                // In signals without noise a step is not detected: a held signal may have changed in the meantime.
                let noise = f64::from(k * 7919 % 13) / 13.0;
                let row = cruise(time);
                let mut row = Sample {
                    front_torque: row.front_torque.map(|t| t + noise),
                    rear_torque: row.rear_torque.map(|t| t - noise),
                    slope: Some(1e-4 * noise),
                    ..row
                };
                // One row, 50 ms, a third of a second.
                if k == 150 || (220..225).contains(&k) || (300..333).contains(&k) {
                    fault(&mut row, word);
                }
                numbers(&estimator.step(&row))
            });
            rows.collect::<Vec<_>>()
        };
        let missing = with(None);
        for word in words {
            assert_eq!(with(Some(*word)), missing, "{word}");
        }
    }
}

#[test]
fn full_finds_back_after_a_broken_bus() {
    let mut estimator = estimator(Method::Full);
    for k in 0..500 {
        estimator.step(&nasty(k));
    }
    // A slope signal whose noise disappears is stuck, so it needs noise here.
    let noise = |k: u32| 0.001 * f64::from(k * 7919 % 13) / 13.0;
    for k in 500..1500 {
        let row = cruise(f64::from(k) * 0.01);
        let slope = row.slope.map(|slope| slope + noise(k));
        estimator.step(&Sample { slope, ..row });
    }
    let last = *estimator.last();
    assert!((last.speed - 2.5).abs() < 0.05, "{}", last.speed);
    assert!(last.fresh && last.consistent, "{last:?}");
}

#[test]
fn a_refused_time_changes_nothing() {
    let mut a = estimator(Method::Full);
    drive(&mut a, 0..100);
    let mut b = a;
    for time in [0.99, 0.5, -1.0, f64::NAN, f64::NEG_INFINITY, f64::INFINITY] {
        let answer = b.step(&Sample {
            time,
            speed: Some(50.0),
            ..cruise(0.0)
        });
        assert_eq!(answer.status, Status::Refused);
        assert_eq!(answer.time, 0.99);
    }
    assert_eq!(b.last().refused, 6);
    let (x, y) = (a.step(&cruise(1.0)), b.step(&cruise(1.0)));
    assert_eq!(numbers(&x), numbers(&y));
    assert_eq!(a.state(), b.state());
}

#[test]
fn one_time_far_ahead_costs_no_row_after_it() {
    let mut estimator = estimator(Method::Full);
    drive(&mut estimator, 0..200);
    let ahead = estimator.step(&cruise(1e6));
    assert_eq!(ahead.status, Status::Gap);
    for k in 200..300 {
        let answer = estimator.step(&cruise(k as f64 * 0.01));
        assert_eq!(answer.status, Status::Updated, "row {k}");
        assert!(answer.fresh && answer.time == k as f64 * 0.01);
    }
    assert_eq!(estimator.last().refused, 0);
}

#[test]
fn a_clock_set_back_is_followed_after_a_second_and_shown_as_a_reset() {
    let mut estimator = estimator(Method::Full);
    // The clock goes back by more than the ten seconds up to which rows continue without a reset.
    let before = drive(&mut estimator, 0..2000);
    let answers: Vec<Estimate> = (0..200)
        .map(|k| estimator.step(&cruise(k as f64 * 0.01)))
        .collect();
    let back = answers
        .iter()
        .position(|e| e.status == Status::ClockSetBack)
        .unwrap();
    // One second of rows with increasing times, and one more if the steps are rounded down.
    assert!((100..=101).contains(&back), "{back}");
    assert!(answers[..back].iter().all(|e| e.status == Status::Refused));
    assert!(!answers[back - 1].fresh && !answers[back - 1].trusted_ratio);
    assert_eq!((answers[back].resets, answers[back].reset), (1, true));
    // The estimate is retained.
    assert_eq!(answers[back].cg_ratio.value, before.cg_ratio.value);
    let after = &answers[back + 1..];
    assert!(after.iter().all(|e| e.status == Status::Updated));
}

#[test]
fn a_clock_that_stands_still_does_not_stay_fresh() {
    let mut estimator = estimator(Method::Full);
    drive(&mut estimator, 0..100);
    for k in 0..100 {
        let answer = estimator.step(&cruise(0.5));
        // 0.25 s are 25 rows; times are rounded.
        assert!((24..26).contains(&k) || answer.fresh == (k < 25), "{k}");
    }
    assert!(estimator.step(&cruise(1.0)).fresh);
}

#[test]
fn rows_before_the_first_time_leave_the_prior() {
    let mut estimator = estimator(Method::Full);
    let answer = estimator.step(&cruise(f64::NAN));
    assert!(!answer.started);
    assert_eq!(answer.cg_height.value, 0.9);
    assert_eq!(estimator.step(&cruise(5.0)).status, Status::First);
}

#[test]
fn height_is_not_trusted_on_a_cruise() {
    for method in Method::ALL {
        let mut estimator = estimator(method);
        for k in 0..12_000 {
            let answer = estimator.step(&cruise(k as f64 * 0.01));
            assert!(
                !answer.trusted_height && !answer.excited_height,
                "{method}, row {k}"
            );
        }
        // The prior has 0.1 m; the reported standard deviation may be at most 15 % smaller.
        assert!(
            estimator.last().cg_height.std > 0.085,
            "{method}: {:?}",
            estimator.last().cg_height
        );
        assert!(
            !estimator.last().trusted_ratio,
            "{method}: torque is constant"
        );
    }
}

#[test]
fn lost_signals_are_stale_after_a_quarter_second_and_the_interval_grows() {
    let mut estimator = estimator(Method::Full);
    let before = drive(&mut estimator, 0..6000);
    assert!(before.fresh);
    let mut after = before;
    for k in 6000..6050 {
        after = estimator.step(&Sample {
            speed: None,
            ..cruise(k as f64 * 0.01)
        });
        assert_eq!(after.fresh, k < 6000 + 25, "row {k}");
    }
    assert!(!after.trusted_ratio && after.cg_ratio.std >= before.cg_ratio.std * 0.999);
}

#[test]
fn standing_still_freezes_the_parameters() {
    let mut estimator = estimator(Method::Full);
    let mut last = *estimator.last();
    for k in 0..3000 {
        let still = Sample {
            speed: Some(0.0),
            front_wheel_speed: Some(0.0),
            rear_wheel_speed: Some(0.0),
            front_torque: Some(0.0),
            rear_torque: Some(0.0),
            ..cruise(k as f64 * 0.01)
        };
        last = estimator.step(&still);
    }
    assert!(last.frozen && !last.trusted_ratio && !last.trusted_height);
    assert!((last.cg_ratio.value - 0.45).abs() < 1e-3 && (last.cg_height.value - 0.9).abs() < 1e-3);
}

/// Information per second, not per row: ten times the rate with the same noise per second ends at the same interval.
#[test]
fn the_interval_does_not_depend_on_the_rate() {
    let run = |rate: f64, std_scale: f64| {
        let mut settings = Settings::default();
        settings.sensors.speed_std *= std_scale;
        settings.sensors.wheel_speed_std *= std_scale;
        settings.sensors.acceleration_std *= std_scale;
        let mut estimator = CgEstimator::new(&settings, Method::Full, COLUMNS).unwrap();
        let mut last = *estimator.last();
        for k in 0..(20.0 * rate) as usize {
            last = estimator.step(&cruise(k as f64 / rate));
        }
        (
            last.slip_stiffness.std,
            last.cg_ratio.std,
            last.cg_height.std,
        )
    };
    let (at_100, at_1000) = (run(100.0, 1.0), run(1000.0, 10.0_f64.sqrt()));
    for (a, b) in [
        (at_100.0, at_1000.0),
        (at_100.1, at_1000.1),
        (at_100.2, at_1000.2),
    ] {
        // The specific force of neighbouring rows shares a sample, so the rates are not exactly equal.
        assert!((a / b - 1.0).abs() < 0.1, "{a} {b}");
    }
}

#[test]
fn a_stated_payload_is_added_to_the_empty_machine() {
    let mut estimator = estimator(Method::Full);
    estimator.set_payload(Some(Payload::new(0.0, 0.0, 0.0)));
    drive(&mut estimator, 0..100);
    estimator.set_payload(Some(Payload::new(1500.0, 1.5, 1.35)));
    let answer = estimator.step(&cruise(1.0));
    let empty = estimator.state();
    let ratio = (4700.0 * empty[5] + 1500.0 * (2.3 + 1.35) / 2.3) / 6200.0;
    let height = (4700.0 * empty[4] + 1500.0 * 1.5) / 6200.0;
    assert!((answer.cg_ratio.value - ratio).abs() < 1e-12);
    assert!((answer.cg_height.value - height).abs() < 1e-12);
    // The uncertainty of the stated payload remains in the interval.
    assert!(answer.cg_ratio.std > 1500.0 / 6200.0 * 0.05 / 2.3);
    estimator.set_payload(Some(Payload::new(f64::NAN, 0.0, 0.0)));
    assert!(estimator.step(&cruise(1.01)).cg_ratio.value.is_finite());
}

#[test]
fn a_first_mass_far_beyond_the_described_one_is_a_load() {
    let mut description = Description::default();
    description.machine.mass = 4600.0;
    let settings = Settings::of(&description, Method::Full);
    // Ratio after three rows with this mass.
    let begins = |mass: f64| {
        let mut estimator = CgEstimator::new(&settings, Method::Full, COLUMNS).unwrap();
        for k in 0..3 {
            let row = Sample {
                mass: Some(mass),
                ..cruise(f64::from(k) * 0.01)
            };
            estimator.step(&row);
        }
        estimator.last().cg_ratio
    };
    let (empty, loaded) = (begins(4600.0), begins(1.3 * 4600.0));
    // Three quarters of the bucket's reach ahead of the front axle.
    let at = 1.0 + 0.75 * settings.machine.bucket_reach / settings.machine.wheelbase;
    let expected = (empty.value + 0.3 * at) / 1.3;
    assert!((loaded.value - expected).abs() < 0.05, "{loaded:?}");
    assert!(loaded.std < 0.12, "{loaded:?} {empty:?}");
    // A heavier machine than described, or a small load: either.
    let little = begins(1.07 * 4600.0);
    assert!((little.value - empty.value).abs() < 0.01 && little.std > empty.std);
}

#[test]
fn unusable_settings_are_named() {
    let refuse = |change: fn(&mut Settings), key: &str| {
        let mut settings = Settings::default();
        change(&mut settings);
        let error = CgEstimator::new(&settings, Method::Full, COLUMNS).unwrap_err();
        assert_eq!(error.key, key);
    };
    refuse(|s| s.machine.mass = 0.0, "machine.mass");
    refuse(|s| s.machine.friction = -1.0, "machine.friction");
    refuse(|s| s.sensors.speed_std = -0.1, "sensors.speed_std");
    refuse(|s| s.prior.cg_ratio_std = 0.0, "prior.cg_ratio_std");
    refuse(|s| s.prior.cg_height = f64::NAN, "prior.cg_height");
    refuse(|s| s.estimator.substeps = 0, "estimator.substeps");
    refuse(|s| s.estimator.gate = 30.0, "estimator.gate");
}
