//! The loader's methods as steps on messages.

use messages::{LOADER_METHODS, LoaderEstimate, LoaderSensors, loader_bits as bits};
use runtime::Step;
use steps::loader::EstimatorStep;

const COLUMNS: u32 = bits::SPEED
    | bits::FRONT_WHEEL_SPEED
    | bits::REAR_WHEEL_SPEED
    | bits::FRONT_TORQUE
    | bits::REAR_TORQUE
    | bits::SLOPE
    | bits::ACCELERATION;

/// Driving at 2 m/s with small torques.
fn row(k: u32, columns: u32) -> LoaderSensors {
    let mut m = LoaderSensors {
        speed: 2.0,
        front_wheel_speed: 3.64,
        rear_wheel_speed: 3.64,
        front_torque: 250.0,
        rear_torque: 250.0,
        valid: columns,
        columns,
        ..LoaderSensors::default()
    };
    m.stamp.time = f64::from(k) * 0.01;
    m
}

fn run(method: &str, columns: u32) -> LoaderEstimate {
    let mut step = EstimatorStep::new(&config::Loader::default(), method).unwrap();
    (0..200).fold(LoaderEstimate::default(), |_, k| {
        step.step(&row(k, columns))
    })
}

#[test]
fn every_method_says_its_name_and_what_it_estimates() {
    for (index, method) in LOADER_METHODS.iter().enumerate() {
        let answer = run(method, COLUMNS);
        assert_eq!(answer.method as usize, index);
        assert!(answer.estimated & bits::STATE != 0);
        let ten = method.starts_with("full");
        assert_eq!(answer.estimated & bits::SLOPE_BIAS != 0, ten, "{method}");
        assert_eq!(answer.estimated & bits::RADIUS_SCALES != 0, ten, "{method}");
    }
}

#[test]
fn full_runs_without_an_accelerometer_on_two_states_less() {
    for method in ["full", "full-ekf"] {
        let answer = run(method, COLUMNS & !bits::ACCELERATION);
        let all = bits::STATE | bits::RADIUS_SCALES | bits::SPEED_DELAY;
        assert_eq!(answer.estimated, all);
        assert!(answer.flags & bits::FRESH != 0);
    }
}

#[test]
fn a_row_out_of_time_is_refused_and_said_so() {
    let mut step = EstimatorStep::new(&config::Loader::default(), "full").unwrap();
    assert_eq!(step.step(&row(5, COLUMNS)).flags & bits::REFUSED, 0);
    let answer = step.step(&row(5, COLUMNS));
    assert!(answer.flags & bits::REFUSED != 0);
    assert_eq!(answer.refused, 1);
}

#[test]
fn an_unknown_method_is_named_with_the_known_ones() {
    let error = EstimatorStep::new(&config::Loader::default(), "ufk")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("`ufk`") && error.contains("isr-ukf-printed"),
        "{error}"
    );
}

#[test]
fn the_default_description_gives_the_default_settings() {
    use estimation::loader::{Method, Settings};
    let settings = Settings::of(&config::Loader::default(), Method::Full);
    assert_eq!(settings, Settings::DEFAULT);
    let settings = Settings::of(&config::Loader::default(), Method::Ekf);
    assert_eq!(settings, Settings::PAPER);
}
