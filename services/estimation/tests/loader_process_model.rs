//! The process model against `tests/golden/loader_process_model.json`.

mod loader_common;

use estimation::dual::Dual;
use estimation::loader::LoadTransfer;
use estimation::loader::cg_model::{CgModel, Loading};
use estimation::loader::wheel_dynamics::{Inputs, Motion, Parameters, Road, WheelDynamics};
use estimation::model::Model;
use loader_common::explicit::Explicit;
use loader_common::{array, dynamics, golden, matrix, number, numbers};
use serde_json::Value;

fn inputs(value: &Value) -> Inputs {
    Inputs::of(array(value))
}

#[track_caller]
fn assert_close(what: &str, ours: &[f64], golden: &[f64], relative: f64) {
    for (a, b) in ours.iter().zip(golden) {
        // The tolerance of a result near zero is relative to the size of the others.
        let size = golden.iter().fold(b.abs(), |m, x| m.max(1e-3 * x.abs()));
        assert!((a - b).abs() <= relative * size, "{what}: {a} {b}");
    }
}

fn values(motion: Motion<f64>) -> [f64; 3] {
    [
        motion.speed,
        motion.front_wheel_speed,
        motion.rear_wheel_speed,
    ]
}

#[test]
fn one_step_agrees_with_every_reference_case() {
    let file = golden("loader_process_model.json");
    for case in file["cases"].as_array().unwrap() {
        let x: [f64; 6] = array(&case["x"]);
        let (u, dt) = (inputs(&case["u"]), number(&case["dt"]));
        let (motion, parameters, road) = (Motion::of(&x), Parameters::of(&x), Road::of(u.slope));
        let physical = dynamics(LoadTransfer::Physical);
        let printed = dynamics(LoadTransfer::Printed);
        let saturating = WheelDynamics {
            friction: 0.8,
            ..physical
        };
        let implicit =
            |m: &WheelDynamics, n| values(m.substeps(&motion, &parameters, &u, &road, dt, n));
        let euler = |m: &WheelDynamics, n| {
            values(Explicit(*m).euler(&motion, &parameters, &u, &road, dt, n))
        };
        let rate =
            |m: &WheelDynamics| values(Explicit(*m).derivative(&motion, &parameters, &u, &road));
        for (name, ours, tolerance) in [
            ("rhs_physical", rate(&physical), 1e-12),
            ("rhs_printed", rate(&printed), 1e-12),
            ("linimp_physical", implicit(&physical, 1), 1e-12),
            ("linimp_printed", implicit(&printed, 1), 1e-12),
            ("linimp_physical_4sub", implicit(&physical, 4), 1e-12),
            ("linimp_mu08", implicit(&saturating, 1), 1e-12),
            ("euler_physical", euler(&physical, 1), 1e-11),
            ("euler_physical_4sub", euler(&physical, 4), 1e-11),
            ("euler_printed", euler(&printed, 1), 1e-11),
        ] {
            assert_close(name, &ours, &numbers(&case[name]), tolerance);
        }
    }
}

fn ten_states(case: &Value) -> ([f64; 10], CgModel) {
    let (x, extra): ([f64; 6], [f64; 4]) = (array(&case["x"]), array(&case["extra"]));
    let state = core::array::from_fn(|i| if i < 6 { x[i] } else { extra[i - 6] });
    let dynamics = WheelDynamics {
        friction: 0.8,
        radius_load_sensitivity: 0.01,
        ..dynamics(LoadTransfer::Physical)
    };
    let model = CgModel {
        dynamics,
        inputs: inputs(&case["u"]),
        dt: number(&case["dt"]),
        substeps: 1,
        loading: Loading::NONE,
    };
    (state, model)
}

#[test]
fn ten_states_and_specific_force_agree_with_every_reference_case() {
    let file = golden("loader_process_model.json");
    for case in file["cases"].as_array().unwrap() {
        let (state, model) = ten_states(case);
        let (_, y): (_, [f64; 4]) = Model::<10, 4>::predict(&model, &state);
        let golden = numbers(&case["n10_mu08_rho001"]);
        assert_close("n10", &y[..3], &golden[..3], 1e-12);
        // a_x is a difference of speeds over dt, so its rounding error is theirs over dt.
        let rounding = 1e-12 * golden[0].abs().max(0.1) / model.dt;
        assert!(
            (y[3] - golden[3]).abs() <= 1e-12 * golden[3].abs() + rounding,
            "{} {}",
            y[3],
            golden[3]
        );
    }
}

#[test]
fn dual_numbers_give_the_reference_jacobians() {
    let file = golden("loader_process_model.json");
    let mut checked = 0;
    for case in file["cases"].as_array().unwrap() {
        if case.get("jacobian_n10_rows_v_wf_wr").is_none() {
            continue;
        }
        let (state, model) = ten_states(case);
        let seeded: [Dual<10>; 10] = core::array::from_fn(|i| {
            Dual::new(
                state[i],
                core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }),
            )
        });
        let (_, y): (_, [Dual<10>; 4]) = Model::<10, 4>::predict(&model, &seeded);
        let mut golden = matrix(&case["jacobian_n10_rows_v_wf_wr"]);
        golden.push(numbers(&case["jacobian_n10_row_ax"]));
        for (ours, golden) in y.iter().zip(&golden) {
            let largest = golden.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            for (a, b) in ours.derivative.iter().zip(golden) {
                assert!((a - b).abs() <= 1e-10 * largest, "{a} {b}");
            }
        }
        checked += 1;
    }
    assert_eq!(checked, 4);
}

#[test]
fn six_state_jacobian_agrees_with_the_reference() {
    let file = golden("loader_process_model.json");
    for case in file["cases"].as_array().unwrap() {
        let Some(golden) = case.get("jacobian_n6_rows_v_wf_wr") else {
            continue;
        };
        let x: [f64; 6] = array(&case["x"]);
        let (_, mut model) = ten_states(case);
        model.dynamics = dynamics(LoadTransfer::Physical);
        let seeded: [Dual<6>; 6] =
            core::array::from_fn(|i| Dual::new(x[i], core::array::from_fn(|j| f64::from(i == j))));
        let (next, _): ([Dual<6>; 6], [Dual<6>; 3]) = model.predict(&seeded);
        for (ours, golden) in next.iter().zip(matrix(golden)) {
            let largest = golden.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            for (a, b) in ours.derivative.iter().zip(golden) {
                assert!((a - b).abs() <= 1e-10 * largest, "{a} {b}");
            }
        }
    }
}

#[test]
fn five_seconds_from_standstill_in_reverse_and_through_zero_stay_on_the_reference() {
    let file = golden("loader_process_model.json");
    let machine = dynamics(LoadTransfer::Physical);
    for run in file["stability"].as_array().unwrap() {
        let torque = number(&run["torque_per_axle"]);
        let slope = number(&run["slope"]);
        let u = Inputs {
            front_torque: torque,
            rear_torque: torque,
            slope,
            ..Inputs::default()
        };
        let v = number(&run["v0"]);
        let x = [v, v / 0.55, v / 0.55, 19.0, 0.9, 0.45];
        let (mut motion, parameters, road) = (Motion::of(&x), Parameters::of(&x), Road::of(slope));
        let mut rows = matrix(&run["rows"]).into_iter().peekable();
        for step in 1..=500 {
            motion = machine.step(&motion, &parameters, &u, &road, 0.01);
            if rows.peek().is_some_and(|r| r[0] as usize == step) {
                for (a, b) in values(motion).iter().zip(&rows.next().unwrap()[1..]) {
                    assert!(
                        (a - b).abs() <= 1e-9,
                        "{}: step {step}: {a} {b}",
                        run["name"]
                    );
                }
            }
        }
        assert!(rows.next().is_none());
    }
}
