//! The plant against the golden runs.

use super::driver::Driver;
use super::plant::{Machine, Plant};
use super::road::{Phases, Road, SPACING};
use super::scenario::Scenario;
use crate::noise::Noise;
use serde_json::Value;

fn read(file: &str) -> String {
    let path = format!("{}/../tests/golden/{file}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .collect()
}

fn golden(scenario: &str) -> (Value, Road) {
    let all: Value = serde_json::from_str(&read("loader_plant.json")).unwrap();
    let one = all["scenarios"][scenario].clone();
    let phases = Phases {
        slope: numbers(&one["slope_phases"]).try_into().unwrap(),
        roughness: numbers(&one["roughness_phases"]).try_into().unwrap(),
    };
    let road = Road::new(&Scenario::parse(scenario).unwrap().surface(), &phases);
    (one, road)
}

#[test]
fn roads_are_rebuilt_from_their_phases_to_1e_12() {
    for scenario in ["S1", "S3", "S4"] {
        let (golden, road) = golden(scenario);
        for sample in golden["road_samples"]["rows"].as_array().unwrap() {
            let sample = numbers(sample);
            let x = -10.0 + SPACING * sample[0];
            let [mut height, mut derivative] = road.profile(x);
            if sample[0] == 13_499.0 {
                // The stored road ends here, with a one-sided difference; ours continues.
                height = road.profile(x)[0];
                derivative = (height - road.profile(x - SPACING)[0]) / SPACING;
            }
            for (value, expected) in [road.slope(x), height, derivative].iter().zip(&sample[2..]) {
                assert!(
                    (value - expected).abs() < 1e-12,
                    "{scenario} {sample:?}: {value}"
                );
            }
        }
    }
}

/// Integration step of the reference [s]. Against a tenth of it the speed changes by 5e-9 m/s.
const REFERENCE_STEP: f64 = 1e-4;

/// Absolute tolerances of the columns after T_f, T_r, in the order of the files.
const TOLERANCES: [f64; 16] = [
    1e-9, 1e-9, 1e-9, 1e-10, 1e-10, 1e-9, 1e-9, 1e-10, 1e-9, 1e-9, 1e-9, 1e-12, 1e-5, 1e-5, 1e-5,
    1e-5,
];

#[test]
fn the_plant_follows_the_golden_runs() {
    for scenario in ["S1", "S3", "S4"] {
        let (_, road) = golden(scenario);
        let kind = Scenario::parse(scenario).unwrap();
        let machine = Machine::NOMINAL;
        let mut driver = Driver::new(kind, None, &machine, Noise::new(0));
        let mut inputs = |t: f64, x: &[f64; 10]| driver.inputs(t, x[0]);
        let plant = Plant::new(machine, road, kind.start_speed(), &mut inputs);
        let mut plant = plant.with_longest_step(REFERENCE_STEP);
        let text = read(&format!("loader_plant_{scenario}.csv"));
        for (k, line) in text.lines().skip(1).enumerate() {
            let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            for centisecond in (10 * k).saturating_sub(9)..=10 * k {
                if centisecond > 0 {
                    plant.advance(centisecond as f64 / 100.0, &mut inputs);
                }
            }
            let (motion, state) = (plant.motion(), *plant.state());
            let torque = plant.inputs();
            assert!(
                (torque.front_torque - row[1]).abs() < 1e-9
                    && (torque.rear_torque - row[2]).abs() < 1e-9
            );
            let ours = [
                &state[..],
                &[motion.rate[0], motion.slope],
                &motion.loads,
                &motion.forces,
            ]
            .concat();
            for ((value, expected), tolerance) in ours.iter().zip(&row[3..]).zip(TOLERANCES) {
                assert!(
                    (value - expected).abs() <= tolerance,
                    "{scenario} t = {}: {value} {expected}",
                    row[0]
                );
            }
        }
    }
}
