//! What a calibration finds, and what it refuses.

use std::sync::atomic::AtomicBool;

use calibrate::excavator::{Input, Options, Outcome, Role, calibrate};
use config::Tables;
use estimation::Quantity;
use estimation::excavator::Sample;
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
    let options = Options {
        description: &config::Excavator::default(),
        free,
        stop: &AtomicBool::new(false),
        progress: &|_| {},
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
        // Four standard deviations: one seed in 16 000 misses one by chance.
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
    let gain = outcome.quantity(Role::Gain).expect("a value");
    assert!((after.sensors.swing_torque_gain - gain.value).abs() < 1e-3 * gain.std + 1e-9);
}

#[test]
fn a_load_that_is_told_wrong_is_noticed() {
    let truth = Truth::new(4);
    let outcome = run(
        &[
            input("empty", truth.record(0.0, 1), 0.0),
            input("loaded", truth.record(288.0, 2), 423.0),
        ],
        None,
    );
    says(&outcome, "the load of loaded was told as 423 kg");
}

#[test]
fn one_load_only_fixes_no_scale() {
    let outcome = run(&[input("empty", Truth::new(5).record(0.0, 1), 0.0)], None);
    says(&outcome, "all swings carry the same load");
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
    let options = Options {
        description: &config::Excavator::default(),
        free: Some(&free),
        stop: &AtomicBool::new(false),
        progress: &|_| {},
    };
    let error = calibrate(&inputs, &options).expect_err("no such parameter");
    assert!(error.contains("machine.nominal_damping"), "{error}");
}
