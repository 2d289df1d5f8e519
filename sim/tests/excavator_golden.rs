//! The plant against reference vectors (tests/golden/excavator_plant_*, excavator_input_*).

use sim::excavator::{
    Attachment, Dynamics, Geometry, Plant, Run, Scenario, Sensors, Simulation, Swing,
};
use std::collections::HashMap;
use std::fs;

type Table = Vec<HashMap<String, String>>;

fn read(name: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/golden");
    fs::read_to_string(format!("{folder}/excavator_{name}")).expect("a golden file")
}

fn table(name: &str) -> Table {
    let text = read(name);
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<String> = lines
        .next()
        .expect("a header")
        .split(',')
        .map(String::from)
        .collect();
    lines
        .map(|line| {
            header
                .iter()
                .cloned()
                .zip(line.split(',').map(String::from))
                .collect()
        })
        .collect()
}

fn value(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or(f64::NAN)
}

#[track_caller]
fn relative(actual: f64, expected: f64, tolerance: f64) {
    let error = (actual - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{actual} instead of {expected}"
    );
}

#[track_caller]
fn absolute(actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{actual} instead of {expected}"
    );
}

const PAYLOADS: [f64; 3] = [0.0, 288.0, 423.0];

fn plant_of(path: &str, model: &str, case: usize) -> Plant {
    let scenario = if path == "base" {
        Scenario::Base
    } else {
        Scenario::Gentle
    };
    let mut plant = scenario.plant(Some(PAYLOADS[case - 1]));
    if model == "P" {
        plant.machine.dynamics = Dynamics::Paper;
    }
    plant
}

#[test]
fn inertia_at_twelve_postures_with_two_attachments() {
    for row in table("plant_inertia_points.csv") {
        let attachment = match row["attachment"].as_str() {
            "bucket" => Attachment::bucket(),
            _ => Attachment::crusher(),
        };
        let posture = ["boom_deg", "arm_deg", "bucket_deg"].map(|c| value(&row, c).to_radians());
        let inertia = Geometry::with(attachment).inertia(posture, [0.0; 3]);
        relative(inertia.base, value(&row, "base_inertia"), 1e-12);
        relative(inertia.factor, value(&row, "payload_factor"), 1e-12);
        relative(
            inertia.total(value(&row, "payload")),
            value(&row, "inertia"),
            1e-12,
        );
    }
}

#[test]
fn joint_paths_payload_inertia_and_its_rate() {
    for path in ["base", "gentle"] {
        let plants = PAYLOADS.map(|m| {
            let scenario = if path == "base" {
                Scenario::Base
            } else {
                Scenario::Gentle
            };
            (m as u32, scenario.plant(Some(m)))
        });
        for row in table(&format!("plant_path_{path}.csv")) {
            let t = value(&row, "t");
            let posture = plants[0].1.posture(t);
            for (angle, column) in posture
                .iter()
                .zip(["boom_angle", "arm_angle", "bucket_angle"])
            {
                relative(*angle, value(&row, column), 1e-12);
            }
            for (mass, plant) in &plants {
                let payload = plant.payload(t);
                absolute(
                    payload,
                    f64::from(*mass) * value(&row, "payload_fraction"),
                    1e-9,
                );
                let inertia = plant.inertia(t);
                relative(
                    inertia.total(payload),
                    value(&row, &format!("J_{mass}")),
                    1e-12,
                );
                absolute(
                    inertia.posture_rate(payload),
                    value(&row, &format!("Jdot_{mass}")),
                    1e-3,
                );
            }
        }
    }
}

#[test]
fn the_extremes_of_the_base_cycle_are_those_of_the_paper() {
    let over_the_cycle = |mass: f64| {
        let plant = Scenario::Base.plant(Some(mass));
        (0..=13_000).map(move |i| plant.point(f64::from(i) * 1e-3).inertia)
    };
    let smallest = over_the_cycle(0.0).fold(f64::INFINITY, f64::min);
    let largest = over_the_cycle(423.0).fold(0.0, f64::max);
    // Half of the last digit that the paper prints.
    absolute(smallest, 4380.0, 0.5);
    absolute(largest, 9761.0, 0.5);
}

/// `(Ta, Tb, swing angle [deg])` of a solved swing.
fn plateaus(key: &str) -> (f64, f64, f64) {
    let text = read("plant_plateaus.json");
    let entry = &text[text.find(&format!("\"{key}\"")).expect("the key")..];
    let field = |name: &str| -> f64 {
        let rest =
            &entry[entry.find(&format!("\"{name}\"")).expect("the field") + name.len() + 3..];
        let end = rest.find([',', '\n', '}']).expect("an end");
        rest[..end].trim().parse().expect("a number")
    };
    (field("Ta"), field("Tb"), field("swing_deg"))
}

#[test]
fn the_solved_plateaus_and_the_angle_of_the_swing() {
    for (path, model, scenario) in [
        ("base", "M", Scenario::Base),
        ("gentle", "M", Scenario::Gentle),
        ("gentle", "P", Scenario::Paper),
    ] {
        for case in 1..=3 {
            let (accelerate, brake, degrees) = plateaus(&format!("{path}_{model}_case{case}"));
            let plant = scenario.plant(Some(PAYLOADS[case - 1]));
            relative(plant.swings[0].accelerate, accelerate, 1e-6);
            relative(plant.swings[0].brake, brake, 1e-6);
            let run = Run {
                duration: 5.0,
                noise: Sensors::EXACT,
                ..Run::new(scenario)
            };
            let last = Simulation::of(plant, 5.0, &run)
                .expect("a run")
                .last()
                .expect("a row");
            relative(
                last.swing_angle.expect("an angle").to_degrees(),
                degrees,
                1e-6,
            );
        }
    }
}

#[test]
fn trajectories_of_both_dynamics() {
    let rows = table("plant_trajectories.csv");
    for (path, model) in [("base", "M"), ("base", "P"), ("gentle", "P")] {
        for case in 1..=3 {
            let mut plant = plant_of(path, model, case);
            let (accelerate, brake, _) = plateaus(&format!("{path}_{model}_case{case}"));
            plant.swings = vec![Swing {
                accelerate,
                brake,
                ..plant.swings[0]
            }];
            let run = Run {
                duration: 5.0,
                noise: Sensors::EXACT,
                rate: 20.0,
                ..Run::new(Scenario::Base)
            };
            let simulated: Vec<_> = Simulation::of(plant.clone(), 5.0, &run)
                .expect("a run")
                .collect();
            let expected = rows.iter().filter(|r| {
                r["path"] == path && r["model"] == model && r["case"] == case.to_string()
            });
            let mut count = 0;
            for (row, truth) in expected.zip(simulated.iter().map(|r| r.truth)) {
                absolute(truth.velocity, value(row, "w"), 1e-9);
                absolute(truth.acceleration, value(row, "a"), 1e-7);
                absolute(
                    truth.torque,
                    value(row, "torque"),
                    1e-10 * value(row, "torque").abs() + 1e-9,
                );
                relative(truth.inertia, value(row, "inertia"), 1e-10);
                let rate = plant.point(value(row, "t")).inertia_rate;
                absolute(rate, value(row, "inertia_rate"), 1e-3);
                count += 1;
            }
            assert_eq!(count, 101);
        }
    }
}

/// The noise-free columns of the recorded inputs; they carry nine digits.
#[test]
fn truth_columns_of_the_recorded_inputs() {
    for (file, scenario) in [
        ("gentle_case2", Scenario::Gentle),
        ("paper_case2", Scenario::Paper),
        ("constant", Scenario::Constant),
        ("two_swings", Scenario::TwoSwings),
        ("drop", Scenario::Drop),
        ("soft_brake", Scenario::SoftBrake),
        ("bad", Scenario::Base),
    ] {
        let simulation = Simulation::new(&Run::new(scenario)).expect("a run");
        let simulated: HashMap<String, _> =
            simulation.map(|r| (format!("{:.2}", r.time), r)).collect();
        for row in table(&format!("input_{file}.csv")) {
            let t = value(&row, "t");
            let sample = &simulated[&format!("{t:.2}")];
            // The soft-brake input uses plateaus rounded to six digits: 1e-7 relative of the velocity.
            absolute(sample.truth.velocity, value(&row, "true_velocity"), 1e-7);
            // Where friction holds the machine the soft-brake input reports torque over inertia, the
            // others zero; the specification says zero.
            if sample.truth.velocity != 0.0 {
                absolute(
                    sample.truth.acceleration,
                    value(&row, "true_acceleration"),
                    1e-6,
                );
            }
            relative(sample.truth.inertia, value(&row, "true_inertia"), 1e-8);
            absolute(sample.truth.torque, value(&row, "true_torque"), 1e-3);
            absolute(sample.truth.payload, value(&row, "true_payload"), 1e-5);
            for (angle, column) in
                sample
                    .posture
                    .iter()
                    .zip(["boom_angle", "arm_angle", "bucket_angle"])
            {
                absolute(angle.expect("an angle"), value(&row, column), 1e-8);
            }
        }
    }
}
