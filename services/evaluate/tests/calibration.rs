//! Results of a calibration, and refused recordings.

use std::sync::atomic::AtomicBool;

use calibrate::excavator::{Input, Options, Outcome, Role, calibrate};
use config::Tables;
use estimation::Quantity;
use estimation::excavator::{Doubts, Geometry, Sample};
use evaluate::excavator::calibration::Truth;
use sim::excavator::Path;

fn input(name: &str, samples: Vec<Sample>, load: f64) -> Input {
    Input {
        name: name.into(),
        samples,
        payload: Some(Quantity {
            value: load,
            std: 0.0,
        }),
    }
}

fn run(inputs: &[Input], free: Option<&[String]>) -> Outcome {
    let description = config::Excavator::default();
    let options = Options {
        free,
        ..Options::of(&description)
    };
    calibrate(inputs, &options).expect("known keys")
}

fn says(outcome: &Outcome, words: &str) {
    assert!(
        outcome.faults.iter().any(|f| f.contains(words)),
        "{words}: {:?}",
        outcome.faults
    );
}

#[test]
fn two_recordings_find_the_machine_within_its_intervals_and_the_description_holds_it() {
    let truth = Truth::new(3);
    let outcome = run(
        &[
            input("empty", truth.record(0.0, 1), 0.0),
            input("loaded", truth.record(423.0, 2), 423.0),
        ],
        None,
    );
    assert_eq!(outcome.faults, Vec::<String>::new());
    for (role, true_value, tolerance) in [
        (Role::Gain, truth.gain, 0.01),
        (Role::Damping, truth.damping, 0.05 * truth.damping),
        (Role::Friction, truth.friction, 0.15 * truth.friction),
        (Role::Efficiency, truth.efficiency, 0.01),
        (Role::Links, truth.links, 0.02),
        (Role::Delay, truth.delay, 0.002),
    ] {
        let q = outcome.quantity(role).expect("a value");
        let error = (q.value - true_value).abs();
        // Four standard deviations: one seed in 16 000 exceeds them by chance.
        assert!(
            error < 4.0 * q.std && error < tolerance,
            "{role:?} {q:?} {true_value}"
        );
    }
    let found = outcome.found.as_ref().expect("a fit");
    assert!(
        (0.9..1.1).contains(&found.unseen[1].nis),
        "{:?}",
        found.unseen
    );
    let before = config::Excavator::default();
    let (after, text) = outcome.description(&before, &[]).expect("a description");
    assert_eq!(
        config::Excavator::parse(&text, "written"),
        Ok(after.clone())
    );
    // Gain and masses are identified together, so their errors are correlated.
    let m = &after.machine;
    assert!(m.links_gain_correlation < Some(-0.5), "{m:?}");
    assert!(m.upper_tolerance < Some(0.06) && m.bucket_tolerance < Some(0.07));
    let gain = outcome.quantity(Role::Gain).expect("a value");
    assert!((after.sensors.swing_torque_gain - gain.value).abs() < 1e-3 * gain.std + 1e-9);
}

#[test]
fn a_load_that_is_stated_wrong_is_noticed() {
    let truth = Truth::new(4);
    let outcome = run(
        &[
            input("empty", truth.record(0.0, 1), 0.0),
            input("loaded", truth.record(288.0, 2), 423.0),
        ],
        None,
    );
    says(&outcome, "the load of loaded was stated as 423 kg");
}

#[test]
fn one_load_only_fixes_no_scale() {
    let outcome = run(&[input("empty", Truth::new(5).record(0.0, 1), 0.0)], None);
    says(&outcome, "no two recordings have different stated loads");
}

#[test]
fn what_cannot_be_learnt_from_a_recording_is_said_with_what_to_record() {
    let truth = Truth::new(6);
    let both = |samples: &dyn Fn(f64, u64) -> Vec<Sample>| {
        run(
            &[
                input("empty", samples(0.0, 1), 0.0),
                input("loaded", samples(423.0, 2), 423.0),
            ],
            None,
        )
    };
    let still = both(&|load, seed| {
        let mut samples = truth.record(load, seed);
        samples.truncate(540);
        samples
    });
    says(&still, "stands still");
    let one_side = both(&|load, seed| {
        let mut samples = truth.record(load, seed);
        samples.retain(|s| s.time.rem_euclid(16.0) < 10.5);
        samples
    });
    says(&one_side, "to one side only");
    let constant = both(&|load, seed| truth.record_on(Path::constant(), load, seed));
    says(&constant, "the same posture");
    assert!(still.found.is_none());
}

#[test]
fn a_key_that_no_recording_can_tell_is_refused_with_those_that_can() {
    let inputs = [input("empty", Vec::new(), 0.0)];
    let free = ["sensors.rate".to_owned()];
    let description = config::Excavator::default();
    let options = Options {
        free: Some(&free),
        ..Options::of(&description)
    };
    let error = calibrate(&inputs, &options).expect_err("no such parameter");
    assert!(error.contains("machine.nominal_damping"), "{error}");
}

/// The same recording on ground inclined by these angles across and along the machine at its beginning. The drive
/// without losses balances the slope.
fn on_slope(truth: &Truth, mut samples: Vec<Sample>, load: f64, slope: [f64; 2]) -> Vec<Sample> {
    let geometry = Geometry::default();
    let (upper, _) = Doubts::default().upper_moment(&geometry);
    let (mut angle, mut last) = (0.0, 0.0);
    for sample in &mut samples {
        angle += sample.velocity.expect("measured") * (sample.time - last);
        last = sample.time;
        let inertia = geometry.inertia(sample.posture.map(|q| q.expect("measured")));
        let moment = upper + truth.links * inertia.moment + load * inertia.radius;
        let (sin, cos) = f64::sin_cos(angle);
        let pull = 9.80665 * moment * (slope[0] * cos + slope[1] * sin);
        sample.torque = sample.torque.map(|t| t - truth.gain * pull);
    }
    samples
}

#[test]
fn a_slope_of_the_ground_is_taken_out_and_reported() {
    let truth = Truth {
        efficiency: 1.0,
        ..Truth::new(3)
    };
    let slope = [0.03, -0.02];
    let record = |load, seed| on_slope(&truth, truth.record(load, seed), load, slope);
    let outcome = run(
        &[
            input("empty", record(0.0, 1), 0.0),
            input("loaded", record(423.0, 2), 423.0),
        ],
        None,
    );
    assert_eq!(outcome.faults, Vec::<String>::new());
    for (role, true_value) in [
        (Role::Gain, truth.gain),
        (Role::Damping, truth.damping),
        (Role::Friction, truth.friction),
        (Role::Offset, truth.offset),
        (Role::Across(0), slope[0]),
        (Role::Along(1), slope[1]),
    ] {
        let q = outcome.quantity(role).expect("a value");
        let error = (q.value - true_value).abs();
        assert!(error < 4.0 * q.std, "{role:?} {q:?} {true_value}");
    }
    let tells = |r: &String| r.contains("empty: the ground is inclined, by 2.");
    assert!(outcome.remarks.iter().any(tells), "{:?}", outcome.remarks);
}

#[test]
fn lengths_within_their_tolerance_leave_the_gain_inside_its_interval() {
    let truth = Truth::new(3);
    let mut description = config::Excavator::default();
    let g = &mut description.geometry;
    for length in [&mut g.boom_length, &mut g.arm_length, &mut g.payload_centre] {
        *length *= 1.008;
    }
    let inputs = [
        input("empty", truth.record(0.0, 1), 0.0),
        input("loaded", truth.record(423.0, 2), 423.0),
    ];
    let gain = |tolerance| {
        let mut description = description.clone();
        description.machine.geometry_tolerance = tolerance;
        description.sensors.angle_offset_std = 0.0;
        let outcome = calibrate(&inputs, &Options::of(&description)).expect("known keys");
        assert_eq!(outcome.faults, Vec::<String>::new());
        let q = outcome.quantity(Role::Gain).expect("a value");
        (q.value - truth.gain).abs() / q.std
    };
    let (honest, sure) = (gain(0.008), gain(0.0));
    assert!(honest < 2.0 && sure > 3.0, "{honest} {sure}");
}

#[test]
fn a_boom_pin_that_is_guessed_must_be_measured_first() {
    let truth = Truth::new(3);
    let inputs = [
        input("empty", truth.record(0.0, 1), 0.0),
        input("loaded", truth.record(423.0, 2), 423.0),
    ];
    let mut description = config::Excavator::default();
    let asks = |description: &config::Excavator| {
        let outcome = calibrate(&inputs, &Options::of(description)).expect("known keys");
        outcome.faults.iter().any(|f| f.contains("boom_pin"))
    };
    description.machine.operating_mass = Some(5500.0);
    assert!(!asks(&description), "stated");
    description.geometry.boom_pin = description.of_its_size().geometry.boom_pin;
    assert!(asks(&description));
}

#[test]
fn recordings_of_two_machines_do_not_fit_together() {
    let (one, other) = (
        Truth::new(3),
        Truth {
            damping: 1.4 * Truth::new(3).damping,
            ..Truth::new(3)
        },
    );
    let outcome = run(
        &[
            input("empty", one.record(0.0, 1), 0.0),
            input("loaded", other.record(423.0, 2), 423.0),
        ],
        None,
    );
    says(&outcome, "does not fit the rest: the viscous damping");
}

/// Samples whose boom angle is measured too high \[rad\].
fn with_boom_offset(samples: Vec<Sample>, offset: f64) -> Vec<Sample> {
    let higher = |mut sample: Sample| {
        sample.posture[0] = sample.posture[0].map(|boom| boom + offset);
        sample
    };
    samples.into_iter().map(higher).collect()
}

#[test]
fn the_offset_of_the_boom_angle_is_found_written_and_used() {
    const OFFSET: f64 = 0.03;
    let truth = Truth::new(3);
    let record = |name, payload, seed| {
        let samples = with_boom_offset(truth.record(payload, seed), OFFSET);
        input(name, samples, payload)
    };
    let inputs = [record("empty", 0.0, 1), record("loaded", 423.0, 2)];
    let mut before = config::Excavator::default();
    before.sensors.angle_offset_std = 0.035;
    let found = |description: &config::Excavator| {
        let outcome = calibrate(&inputs, &Options::of(description)).expect("known keys");
        assert_eq!(outcome.faults, Vec::<String>::new());
        let offset = outcome.quantity(Role::AngleOffset(0)).expect("a value");
        assert!(
            (offset.value - OFFSET).abs() < 2.0 * offset.std,
            "{offset:?}"
        );
        assert!(offset.std < 0.01, "{offset:?}");
        outcome
            .description(description, &[])
            .expect("a description")
            .0
    };
    let after = found(&before);
    let written = after.sensors.boom_angle_offset;
    assert!((written - OFFSET).abs() < 0.01, "{written}");
    // The written one is that of the description in the next calibration.
    let again = found(&after).sensors.boom_angle_offset;
    assert!((again - written).abs() < 0.005, "{written} {again}");
}

#[test]
fn an_offset_far_beyond_its_tolerance_names_the_key() {
    let truth = Truth::new(3);
    let record = |name, payload, seed| {
        let samples = with_boom_offset(truth.record(payload, seed), 0.1);
        input(name, samples, payload)
    };
    let outcome = run(&[record("empty", 0.0, 1), record("loaded", 423.0, 2)], None);
    says(&outcome, "sensors.angle_offset_std");
}

#[test]
fn a_boom_sensor_that_moved_between_the_recordings_is_named() {
    let truth = Truth::new(3);
    let moved = with_boom_offset(truth.record(423.0, 2), 0.06);
    let mut description = config::Excavator::default();
    description.sensors.angle_offset_std = 0.035;
    let inputs = [
        input("empty", truth.record(0.0, 1), 0.0),
        input("loaded", moved, 423.0),
    ];
    let outcome = calibrate(&inputs, &Options::of(&description)).expect("known keys");
    says(
        &outcome,
        "does not fit the rest: the offset of the boom angle",
    );
}

#[test]
fn what_a_user_mixed_up_is_said_in_the_words_of_the_user() {
    let truth = Truth::new(3);
    let (empty, loaded) = (truth.record(0.0, 1), truth.record(423.0, 2));
    let changed = |samples: &[Sample], change: fn(&mut Sample)| {
        let mut samples = samples.to_vec();
        samples.iter_mut().for_each(change);
        samples
    };
    let judge = |empty: &[Sample], loaded: &[Sample], loads: [f64; 2], words: &str| {
        let inputs = [
            input("empty", empty.to_vec(), loads[0]),
            input("loaded", loaded.to_vec(), loads[1]),
        ];
        says(&run(&inputs, None), words);
    };
    judge(&empty, &empty, [0.0, 423.0], "loaded was stated as 423 kg");
    judge(&empty, &loaded, [423.0, 0.0], "empty was stated as 423 kg");
    let kilo: fn(&mut Sample) = |s| s.torque = s.torque.map(|t| 1e-3 * t);
    let [e, l] = [&empty, &loaded].map(|s| changed(s, kilo));
    judge(
        &e,
        &l,
        [0.0, 423.0],
        "was expected: a column of another unit",
    );
    let blind = changed(&loaded, |s| s.velocity = None);
    judge(
        &empty,
        &blind,
        [0.0, 423.0],
        "neither swing velocity nor angle",
    );
    let folded = changed(&loaded, |s| s.posture[0] = None);
    judge(
        &empty,
        &folded,
        [0.0, 423.0],
        "the three joint angles are not",
    );
    let backward: Vec<Sample> = loaded.iter().rev().copied().collect();
    judge(
        &empty,
        &backward,
        [0.0, 423.0],
        "the time does not increase",
    );
}

#[test]
fn a_fit_that_is_stopped_blames_no_recording() {
    let truth = Truth::new(3);
    let stop = AtomicBool::new(false);
    let description = config::Excavator::default();
    let options = Options {
        stop: &stop,
        progress: &|_| stop.store(true, std::sync::atomic::Ordering::Relaxed),
        ..Options::of(&description)
    };
    let inputs = [
        input("empty", truth.record(0.0, 1), 0.0),
        input("loaded", truth.record(423.0, 2), 423.0),
    ];
    let outcome = calibrate(&inputs, &options).expect("known keys");
    let blames = |f: &String| f.contains("does not fit");
    assert!(!outcome.faults.iter().any(blames), "{:?}", outcome.faults);
    assert!(outcome.found.is_some_and(|f| f.fit.interrupted));
}

#[test]
fn what_is_calibrated_is_trusted_on_another_load_though_it_stays_when_the_bucket_opens() {
    let options = evaluate::Options {
        seeds: 2,
        ..evaluate::Options::default()
    };
    let report = evaluate::excavator::calibration::evaluate(&options).expect("a table");
    let after = &report.json["after"];
    let share = |name: &str| after[name].as_f64().expect("a number");
    assert!(share("trusted") > 70.0, "{after}");
    assert!(share("rms") < 1.0 && share("wrong") < 7.0, "{after}");
}

#[test]
fn a_bucket_heavier_than_stated_goes_to_the_bucket_and_not_to_the_upper_body() {
    let truth = Truth {
        bucket: 1.15,
        ..Truth::new(3)
    };
    let outcome = run(
        &[
            input("empty", truth.record(0.0, 1), 0.0),
            input("loaded", truth.record(423.0, 2), 423.0),
        ],
        None,
    );
    assert_eq!(outcome.faults, Vec::<String>::new());
    let upper = Geometry::default().upper_inertia;
    for (role, true_value) in [
        (Role::Bucket, truth.bucket * truth.links),
        (Role::Links, truth.links),
        (Role::Inertia, upper),
        (Role::Gain, truth.gain),
    ] {
        let q = outcome.quantity(role).expect("a value");
        let error = (q.value - true_value).abs();
        assert!(error < 2.5 * q.std, "{role:?} {q:?} {true_value}");
    }
    let before = config::Excavator::default();
    let (after, _) = outcome.description(&before, &[]).expect("a description");
    let scale = after.geometry.bucket_mass / before.geometry.bucket_mass;
    let bucket = outcome.quantity(Role::Bucket).expect("a value");
    assert!((scale - bucket.value).abs() < 0.1 * bucket.std, "{scale}");
    assert!(after.machine.bucket_gain_correlation.is_some());
    let settings = estimation::excavator::Settings::of(&after);
    assert_eq!(settings.check(), Ok(()));
}

#[test]
fn oil_that_was_cold_in_the_loaded_recording_is_called_so() {
    let warm = Truth::new(3);
    let cold = Truth {
        damping: 1.5 * warm.damping,
        friction: 1.5 * warm.friction,
        ..warm
    };
    let outcome = run(
        &[
            input("empty", warm.record(0.0, 1), 0.0),
            input("loaded", cold.record(423.0, 2), 423.0),
        ],
        None,
    );
    says(&outcome, "oil that was cold");
}

#[test]
fn two_weighed_loads_need_no_empty_recording() {
    let truth = Truth::new(3);
    let outcome = run(
        &[
            input("half", truth.record(200.0, 1), 200.0),
            input("loaded", truth.record(423.0, 2), 423.0),
        ],
        None,
    );
    assert_eq!(outcome.faults, Vec::<String>::new());
    let gain = outcome.quantity(Role::Gain).expect("a value");
    assert!((gain.value - truth.gain).abs() < 3.0 * gain.std, "{gain:?}");
}

#[test]
fn a_guessed_load_centre_leaves_the_gain_no_wider_than_its_prior() {
    let truth = Truth::new(3);
    let mut description = config::Excavator::default();
    description.machine.operating_mass = Some(5500.0);
    description.geometry.payload_centre = description.of_its_size().geometry.payload_centre;
    assert!(description.load_centre_share() > 0.02);
    let inputs = [
        input("empty", truth.record(0.0, 1), 0.0),
        input("loaded", truth.record(423.0, 2), 423.0),
    ];
    let outcome = calibrate(&inputs, &Options::of(&description)).expect("known keys");
    let gain = outcome.quantity(Role::Gain).expect("a value");
    assert!(gain.std < 0.05, "{gain:?}");
    assert!((gain.value - truth.gain).abs() < 2.0 * gain.std, "{gain:?}");
}

#[test]
fn a_load_stated_wrong_within_what_the_motion_can_tell_is_inside_the_interval() {
    let truth = Truth::new(3);
    let loaded = Input {
        payload: Some(Quantity {
            value: 1.08 * 423.0,
            std: 2.0,
        }),
        ..input("loaded", truth.record(423.0, 2), 0.0)
    };
    let outcome = run(&[input("empty", truth.record(0.0, 1), 0.0), loaded], None);
    let gain = outcome.quantity(Role::Gain).expect("a value");
    let error = (gain.value - truth.gain).abs();
    assert!(
        !outcome.faults.is_empty() || error < 2.0 * gain.std,
        "{gain:?} {}",
        truth.gain
    );
}
