//! Calibration of recordings that follow the model exactly, and of bad ones.

use super::*;
use config::Tables;
use made::{guess, samples};

fn run(inputs: &[Input], weighed: StatedLoad) -> Outcome {
    let description = Description::default();
    let options = Options {
        weighed,
        ..Options::of(&description)
    };
    calibrate(inputs, &options).expect("keys")
}

fn quantity(value: f64, std: f64) -> Option<Quantity> {
    Some(Quantity { value, std })
}

fn input(name: &str, samples: Vec<Sample>, mass: Option<Quantity>) -> Input {
    Input {
        name: name.into(),
        samples,
        stated: StatedLoad {
            mass,
            ..StatedLoad::default()
        },
        payload: None,
    }
}

/// A machine with a load in its bucket.
fn loaded(empty: guess::Guess) -> guess::Guess {
    guess::Guess {
        mass: 6200.0,
        ratio: 0.7,
        ..empty
    }
}

fn inputs(stated: f64) -> [Input; 2] {
    let rows = |g| samples(&g, 0.2, 7);
    [
        input("flat", rows(guess()), None),
        input("loaded", rows(loaded(guess())), quantity(stated, 30.0)),
    ]
}

const SCALES: StatedLoad = StatedLoad {
    mass: None,
    ratio: Some(Quantity {
        value: 0.45,
        std: 0.001,
    }),
    height: None,
    reach: None,
    lift: None,
};

#[test]
fn a_machine_that_differs_from_its_description_is_found() {
    let outcome = run(&inputs(6200.0), SCALES);
    let truth = guess();
    for (role, value, within) in [
        (Role::LoadSensitivity, truth.load_sensitivity, 1e-3),
        (Role::FrontRadius, truth.radius_errors[0], 5e-4),
        (Role::RearRadius, truth.radius_errors[1], 5e-4),
        (Role::SpeedDelay, truth.speed_delay, 3e-3),
        (Role::SlopeBias, truth.slope_bias, 5e-4),
        (Role::SlopeDelay, truth.slope_delay, 0.01),
        (Role::SlopeFollows, truth.slope_sensitivity, 0.01),
        (Role::FrontGain, truth.torque_gains[0], 0.01),
        (Role::StiffnessRatio, truth.stiffness_ratio, 0.03),
    ] {
        let found = outcome.quantity(role).expect("a fit");
        let error = (found.value - value).abs();
        assert!(
            error < f64::max(within, 3.0 * found.std) && error < 3.0 * within,
            "{role:?}: {found:?} {value}"
        );
    }
    let (description, text) = outcome
        .description(&Description::default(), &[])
        .expect("a fit");
    assert_eq!(Description::parse(&text, "t"), Ok(description));
}

/// The faults of a run with changed recordings.
fn faults(change: impl Fn(&mut Sample), stated: f64, weighed: StatedLoad) -> String {
    let mut inputs = inputs(stated);
    for input in &mut inputs {
        input.samples.iter_mut().for_each(&change);
    }
    run(&inputs, weighed).faults.join("\n")
}

#[test]
fn what_cannot_be_trusted_is_reported() {
    let wrong = faults(|_| {}, 5450.0, SCALES);
    assert!(wrong.contains("was stated as 5450 kg"), "{wrong}");
    let [flat, _] = inputs(6200.0);
    let one = run(&[flat], SCALES).faults.join("\n");
    assert!(one.contains("the same load"), "{one}");
    let still = faults(|s| s.speed = Some(0.01), 6200.0, SCALES);
    assert!(still.contains("stands still"), "{still}");
    let coasting = |s: &mut Sample| {
        if s.front_torque.is_some_and(|t| t < 0.0) {
            s.brake = true;
        }
    };
    let one_way = faults(coasting, 6200.0, SCALES);
    assert!(one_way.contains("never brakes"), "{one_way}");
    let gentle = |s: &mut Sample| {
        s.front_torque = s.front_torque.map(|t| 0.02 * t);
        s.rear_torque = s.rear_torque.map(|t| 0.02 * t);
    };
    let rolling = faults(gentle, 6200.0, SCALES);
    assert!(rolling.contains("rolls without pulling"), "{rolling}");
    let slow_wheel = |s: &mut Sample| {
        s.front_wheel_speed = s.front_wheel_speed.map(|w| 0.9 * w);
    };
    let far = faults(slow_wheel, 6200.0, SCALES);
    assert!(far.contains("was expected"), "{far}");
}

#[test]
fn equal_torques_leave_the_gains_undetermined_and_as_described() {
    let mut inputs = inputs(6200.0);
    let empty = guess();
    let loaded = guess::Guess {
        mass: 6200.0,
        ratio: 0.7,
        ..empty
    };
    for (input, g) in inputs.iter_mut().zip([empty, loaded]) {
        input.samples = samples(&g, 0.0, 7);
    }
    let outcome = run(&inputs, SCALES);
    let said = [&outcome.faults[..], &outcome.remarks[..]]
        .concat()
        .join("\n");
    assert!(said.contains("torque on one axle"), "{said}");
    let before = Description::default();
    let (after, _) = outcome.description(&before, &[]).expect("a fit");
    let wide = |role: Role| {
        let i = outcome.drives.index(role).expect("a parameter");
        let std = outcome.quantity(role).expect("a fit").std;
        std > result::NARROWED * outcome.drives.parameters[i].std
    };
    assert_eq!(
        wide(Role::FrontGain),
        after.sensors.front_torque_gain == before.sensors.front_torque_gain
    );
    assert!(!wide(Role::FrontRadius) && after.prior.front_radius_error != 0.0);
}

/// A machine whose accelerometer has a zero of the usual size.
fn askew() -> guess::Guess {
    guess::Guess {
        acceleration_offset: 0.05,
        ..guess()
    }
}

/// Two recordings of the empty machine, the second starting `turned` [m] along the path, and one with a load.
fn there_and_back(g: guess::Guess, turned: Option<f64>) -> [Input; 3] {
    let back = made::turned(&g, 0.0, 8, turned);
    let load = samples(&loaded(g), 0.2, 9);
    [
        input("flat", samples(&g, 0.2, 7), None),
        input("back", back, None),
        input("loaded", load, quantity(6200.0, 30.0)),
    ]
}

fn run_out_and_back(inputs: &[Input]) -> Outcome {
    let description = Description::default();
    let options = Options {
        weighed: SCALES,
        out_and_back: &[[0, 1]],
        ..Options::of(&description)
    };
    calibrate(inputs, &options).expect("keys")
}

/// Zeros of slope sensor and accelerometer and the rolling resistance, each inside its interval; returns their standard deviations.
fn zeros(outcome: &Outcome, g: &guess::Guess) -> [f64; 3] {
    [
        (Role::SlopeBias, g.slope_bias),
        (Role::AccelerationOffset, g.acceleration_offset),
        (Role::Rolling, g.rolling_resistance),
    ]
    .map(|(role, truth)| {
        let found = outcome.quantity(role).expect("a fit");
        let error = (found.value - truth).abs();
        assert!(error < 2.0 * found.std, "{role:?}: {found:?} {truth}");
        found.std
    })
}

#[test]
fn driving_forward_alone_leaves_the_zeros_open_and_reports_it() {
    let g = askew();
    let outcome = run(&there_and_back(g, None), SCALES);
    let [slope, acceleration, rolling] = zeros(&outcome, &g);
    // Standard deviations that the tolerances of 10 mrad, 0.05 m/s^2 and 0.006 leave, as only their sum is determined.
    assert!(slope > 3e-3 && acceleration > 0.03 && rolling > 3e-3);
    let said = outcome.remarks.join("\n");
    assert!(said.contains("the same path out and back"), "{said}");
    assert_eq!(outcome.faults, [""; 0]);
}

#[test]
fn the_same_path_out_and_back_determines_the_zeros() {
    let g = askew();
    let outcome = run_out_and_back(&there_and_back(g, Some(181.0)));
    let [slope, acceleration, rolling] = zeros(&outcome, &g);
    assert!(slope < 3e-4 && acceleration < 3e-3 && rolling < 3e-4);
    let said = outcome.remarks.join("\n");
    assert!(said.contains("mirror each other (correlation"), "{said}");
    assert!(!said.contains("distinguished"), "{said}");
    let (after, _) = outcome
        .description(&Description::default(), &[])
        .expect("a fit");
    let sensors = &after.sensors;
    assert!((sensors.acceleration_offset - 0.05).abs() < 3e-3);
    assert_eq!(sensors.acceleration_offset_std, 0.01);
}

#[test]
fn a_limit_that_is_reached_is_reported() {
    // Tyres whose radius grows with their load.
    let g = guess::Guess {
        load_sensitivity: -0.002,
        ..guess()
    };
    let said = run(&there_and_back(g, None), SCALES).faults.join("\n");
    assert!(
        said.contains("the load sensitivity of the rolling radius is at the limit"),
        "{said}"
    );
}

#[test]
fn driving_in_reverse_determines_the_zeros_too() {
    let g = askew();
    let mut inputs = there_and_back(g, None);
    inputs[1].samples = made::reversed(&g, 0.0, 8);
    let outcome = run_out_and_back(&inputs);
    let [slope, acceleration, rolling] = zeros(&outcome, &g);
    assert!(slope < 3e-4 && acceleration < 3e-3 && rolling < 3e-4);
    let said = outcome.remarks.join("\n");
    assert!(said.contains("drove back in reverse"), "{said}");
    assert!(!said.contains("distinguished"), "{said}");
}

#[test]
fn another_path_stated_as_the_same_is_not_used() {
    let g = askew();
    // The same path in the same direction, another path, and one that is half as long.
    let mut short = there_and_back(g, Some(181.0));
    short[1].samples.truncate(1500);
    for (inputs, why) in [
        (there_and_back(g, None), "do not mirror each other"),
        (there_and_back(g, Some(500.0)), "do not mirror each other"),
        (short, "back 9"),
    ] {
        let outcome = run_out_and_back(&inputs);
        let said = outcome.remarks.join("\n");
        assert!(said.contains(why), "{said}");
        let [slope, ..] = zeros(&outcome, &g);
        assert!(slope > 3e-3, "{slope}");
    }
}

#[test]
fn what_is_held_with_a_tolerance_widens_what_is_found() {
    let free = ["prior.front_radius_error", "prior.rear_radius_error"].map(String::from);
    let description = Description::default();
    let options = Options {
        weighed: SCALES,
        free: Some(&free),
        ..Options::of(&description)
    };
    let few = calibrate(&inputs(6200.0), &options).expect("keys");
    let all = run(&inputs(6200.0), SCALES);
    let std = |o: &Outcome| o.quantity(Role::FrontRadius).expect("a fit").std;
    assert!(std(&few) > 5.0 * std(&all), "{} {}", std(&few), std(&all));
    let error = few.quantity(Role::FrontRadius).expect("a fit").value - guess().radius_errors[0];
    assert!(error.abs() < 3.0 * std(&few), "{error} {}", std(&few));
}

/// Empty and loaded recordings of this machine, the second of a path out and back, and its faults and remarks.
fn driven(g: guess::Guess, load: guess::Guess) -> (Outcome, [String; 2]) {
    let inputs = [
        input("flat", samples(&g, 0.2, 7), None),
        input("back", made::turned(&g, 0.0, 8, Some(181.0)), None),
        input("loaded", samples(&load, 0.2, 9), quantity(6200.0, 30.0)),
    ];
    let outcome = run_out_and_back(&inputs);
    let said = [&outcome.faults, &outcome.remarks].map(|all| all.join("\n"));
    (outcome, said)
}

#[test]
fn a_chassis_that_pitches_on_its_tyres_is_found_with_its_load() {
    // 30 mm of static deflection at a wheelbase of 2.3 m.
    let squat = 0.02;
    let g = guess::Guess { squat, ..guess() };
    let ahead = 6200.0 * (2.0 * 0.7 - 1.0) - 4700.0 * (2.0 * 0.45 - 1.0);
    let pitch = -squat * ahead * g.wheelbase / (2.0 * 4700.0 * g.height);
    let load = guess::Guess {
        squat: squat * 6200.0 / 4700.0,
        slope_bias: g.slope_bias + pitch,
        acceleration_offset: g.acceleration_offset + GRAVITY * pitch,
        ..loaded(g)
    };
    let (outcome, [faults, _]) = driven(g, load);
    assert_eq!(faults, "");
    for (role, truth, within) in [
        (Role::Squat, squat, 4e-3),
        (Role::FrontGain, g.torque_gains[0], 0.015),
        (Role::Rolling, g.rolling_resistance, 2e-3),
        (Role::Lift(1), 0.9, 0.5),
    ] {
        let found = outcome.quantity(role).expect("a fit");
        let error = (found.value - truth).abs();
        let most = f64::min(within, 3.0 * found.std);
        assert!(error < most, "{role:?}: {found:?} {truth}");
    }
}

#[test]
fn what_is_not_written_refuses_nothing() {
    let g = guess::Guess {
        relaxation_length: 1.2,
        ..guess()
    };
    let (outcome, [faults, remarks]) = driven(g, loaded(g));
    assert_eq!(faults, "");
    let said = "the relaxation length of the tyres would be";
    assert!(remarks.contains(said), "{remarks}");
    assert!(remarks.contains("it is not written"), "{remarks}");
    let found = outcome.quantity(Role::Relaxation).expect("a fit");
    assert!((found.value - 1.2).abs() < 3.0 * found.std, "{found:?}");
    let ratio = outcome.quantity(Role::StiffnessRatio).expect("a fit");
    assert!((ratio.value - g.stiffness_ratio).abs() < 3.0 * ratio.std);
}

#[test]
fn an_accelerometer_that_is_far_off_is_named_with_its_key() {
    let g = guess::Guess {
        acceleration_offset: 0.3,
        ..guess()
    };
    let (_, [faults, _]) = driven(g, loaded(g));
    assert!(faults.contains("the zero of the accelerometer"), "{faults}");
    let key = "sensors.acceleration_offset_std";
    assert!(
        faults.contains(key) && !faults.contains("locked"),
        "{faults}"
    );
}
