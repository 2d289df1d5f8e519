//! One filter step with all its intermediate matrices, against `tests/golden/loader_step.json`.

mod loader_common;

use estimation::ekf::Ekf;
use estimation::loader::LoadTransfer;
use estimation::loader::cg_model::{CgModel, Loading};
use estimation::loader::wheel_dynamics::{Inputs, WheelDynamics};
use estimation::model::Model;
use estimation::prediction::{Prediction, Update};
use estimation::sigma_points::Spread;
use estimation::srukf::SquareRootUkf;
use loader_common::explicit::ExplicitModel;
use loader_common::{array, assert_matrix, assert_row, dynamics, golden, matrix, number};
use serde_json::Value;

fn model(file: &Value, dynamics: WheelDynamics) -> CgModel {
    let u = &file["inputs"];
    let inputs = Inputs {
        front_torque: number(&u["Tf"]),
        rear_torque: number(&u["Tr"]),
        spade_force_x: number(&u["Fx"]),
        spade_force_z: number(&u["Fz"]),
        slope: number(&u["alpha"]),
    };
    CgModel {
        dynamics,
        inputs,
        dt: 0.01,
        substeps: 1,
        loading: Loading::NONE,
    }
}

fn root<const N: usize>(value: &Value) -> [[f64; N]; N] {
    let rows = matrix(value);
    core::array::from_fn(|i| core::array::from_fn(|j| rows[i][j]))
}

fn rows<const R: usize, const C: usize>(m: &[[f64; C]; R]) -> Vec<[f64; C]> {
    m.to_vec()
}

/// K = K_b S_y^-1, column by column from the last.
fn gain<const N: usize, const M: usize>(update: &Update<N, M>) -> [[f64; M]; N] {
    update.gain_root.map(|row| {
        let mut k = row;
        estimation::root::solve_lower_transposed(&update.innovation_root, &mut k);
        k
    })
}

fn absorb<L: Model<N, M>, const N: usize, const M: usize>(
    p: &mut Prediction<L, N, M>,
    y: &[f64; M],
    r: &[f64; M],
) -> Update<N, M> {
    let innovation = core::array::from_fn(|j| y[j] - p.measurement[j]);
    p.absorb(&innovation, r, &[true; M])
}

#[test]
fn six_states_printed_and_consistent_agree_with_the_reference_step() {
    let file = golden("loader_step.json");
    for case in file["cases"].as_array().unwrap() {
        let sign = match case["load_transfer_sign"].as_str().unwrap() {
            "printed" => LoadTransfer::Printed,
            _ => LoadTransfer::Physical,
        };
        let model = model(&file, dynamics(sign));
        if case["process_model"] == "euler" {
            check_case(&file, case, &ExplicitModel(model));
        } else {
            check_case(&file, case, &model);
        }
    }
}

fn check_case<L: Model<6, 3>>(file: &Value, case: &Value, model: &L) {
    let (x, q, r, y) = (
        array::<6>(&file["x0"]),
        array(&file["Q_sqrt"]),
        array(&file["R_sqrt"]),
        array::<3>(&file["measurement"]),
    );
    // This tolerance is for alpha = 0.01, which loses four digits.
    let tolerance = 1e-9;

    let mut ukf = SquareRootUkf::<6, 3>::with_root(x, root(&file["S0"]), Spread::PAPER);
    let mut prediction = ukf.predict(model, &q);
    assert_row("x^-", &prediction.state, &case["x_pred"], tolerance);
    assert_matrix("S^-", &prediction.root(), &case["S_pred"], tolerance);
    assert_row("y^", &prediction.measurement, &case["y_pred"], tolerance);
    let joint = &case["consistent_joint_qr"];
    let updated = absorb(&mut prediction, &y, &r);
    assert_matrix("S_y", &updated.innovation_root, &joint["S_y"], tolerance);
    assert_matrix("K", &rows(&gain(&updated)), &joint["K"], tolerance);
    assert_row("x", &prediction.state, &joint["x_post"], tolerance);
    assert_matrix("S", &prediction.root(), &joint["S_post"], tolerance);
    // NIS is made of innovations, differences of order 1e-2 (and for Euler of near-singular ones).
    let nis = updated.nis() / number(&joint["NIS"]) - 1.0;
    assert!(nis.abs() < 1e3 * tolerance, "{nis:e}");

    let as_printed = &case["printed"];
    let step = ukf.step_printed(model, &q, &r, |predicted| {
        core::array::from_fn(|j| y[j] - predicted[j])
    });
    assert_matrix(
        "printed S_y",
        &step.innovation_root,
        &as_printed["S_y"],
        tolerance,
    );
    assert_matrix(
        "printed P_xy",
        &step.cross_covariance,
        &as_printed["P_xy"],
        tolerance,
    );
    assert_matrix("printed K", &step.gain, &as_printed["K"], tolerance);
    assert_row("printed x", &ukf.state, &as_printed["x_post"], tolerance);
    assert_matrix(
        "printed (28)",
        &step.updated_root,
        &as_printed["S_post_raw"],
        tolerance,
    );
    assert_matrix("printed S", &ukf.root, &as_printed["S_post"], tolerance);
}

#[test]
fn sigma_points_and_their_images_agree_with_the_reference_step() {
    let file = golden("loader_step.json");
    let case = &file["cases"][0];
    let (points, images) = (matrix(&case["sigma"]), matrix(&case["sigma_prop"]));
    let model = model(&file, dynamics(LoadTransfer::Physical));
    for (point, image) in points.iter().zip(&images) {
        let (ours, _): ([f64; 6], [f64; 3]) =
            Model::<6, 3>::predict(&model, &point[..].try_into().unwrap());
        for (a, b) in ours.iter().zip(image) {
            assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0));
        }
    }
}

#[test]
fn ekf_with_six_states_agrees_with_the_reference_step() {
    let file = golden("loader_step.json");
    let case = &file["ekf_n6"];
    let model = model(&file, dynamics(LoadTransfer::Physical));
    let ekf = Ekf::<6, 3> {
        state: array(&file["x0"]),
        covariance: squared(&root(&file["S0"])),
    };
    check_ekf(
        ekf,
        &model,
        &array(&file["Q_sqrt"]),
        (&array(&file["measurement"]), &array(&file["R_sqrt"])),
        case,
    );
}

fn ten_state_model(file: &Value) -> CgModel {
    let machine = WheelDynamics {
        friction: 0.8,
        radius_load_sensitivity: 0.01,
        ..dynamics(LoadTransfer::Physical)
    };
    model(file, machine)
}

#[test]
fn ten_states_with_specific_force_agree_with_the_reference_step() {
    let file = golden("loader_step.json");
    let case = &file["n10"];
    let (x, q, r, y) = (
        array::<10>(&case["x0"]),
        array(&case["Q_sqrt"]),
        array(&case["R_sqrt"]),
        array(&case["measurement"]),
    );
    let model = ten_state_model(&file);
    for spread in case["ukf"].as_array().unwrap() {
        let alpha = number(&spread["alpha_u"]);
        let tolerance = if alpha < 0.5 { 1e-9 } else { 1e-12 };
        let ukf = SquareRootUkf::<10, 4>::with_root(
            x,
            root(&case["S0"]),
            Spread {
                alpha,
                beta: 2.0,
                kappa: 0.0,
            },
        );
        let mut prediction = ukf.predict(&model, &q);
        assert_row("x^-", &prediction.state, &spread["x_pred"], tolerance);
        let specific_force = number(&spread["a_x_pred"]);
        // a_x is a difference over dt: 1e-12 of the speed is 1e-10 of a_x.
        assert!(
            (prediction.measurement[3] - specific_force).abs()
                <= 100.0 * tolerance * specific_force.abs()
        );
        check_joint(&mut prediction, &y, &r, spread, tolerance);
    }
    let ekf = Ekf::<10, 4> {
        state: x,
        covariance: squared(&root(&case["S0"])),
    };
    check_ekf(ekf, &model, &q, (&y, &r), &case["ekf"]);
}

/// L L'.
fn squared<const N: usize>(root: &[[f64; N]; N]) -> [[f64; N]; N] {
    let product = |i: usize, j: usize| (0..N).map(|c| root[i][c] * root[j][c]).sum();
    core::array::from_fn(|i| core::array::from_fn(|j| product(i, j)))
}

fn check_ekf<const N: usize, const M: usize>(
    mut ekf: Ekf<N, M>,
    model: &CgModel,
    q: &[f64; N],
    (y, r): (&[f64; M], &[f64; M]),
    golden: &Value,
) where
    CgModel: Model<N, M>,
{
    let expected = ekf.predict(model, q);
    assert_row("x^-", &ekf.state, &golden["x_pred"], 1e-12);
    let innovation = core::array::from_fn(|j| y[j] - expected.measurement[j]);
    let nis = ekf.update(&expected, &innovation, r, &[true; M], 0..3);
    assert_row("x", &ekf.state, &golden["x_post"], 1e-10);
    let golden_covariance = squared(&root::<N>(&golden["S_post"]));
    for i in 0..N {
        for j in 0..N {
            let size = (golden_covariance[i][i] * golden_covariance[j][j]).sqrt();
            let error = (ekf.covariance[i][j] - golden_covariance[i][j]).abs() / size;
            assert!(error < 1e-9, "P {i} {j}: {error:e}");
        }
    }
    assert!((nis / number(&golden["NIS"]) - 1.0).abs() < 1e-9);
}

fn check_joint<const N: usize, const M: usize>(
    prediction: &mut Prediction<CgModel, N, M>,
    y: &[f64; M],
    r: &[f64; M],
    golden: &Value,
    tolerance: f64,
) {
    let updated = absorb(prediction, y, r);
    let root = prediction.root();
    let joint: Vec<Vec<f64>> = (0..M + N)
        .map(|i| {
            let mut row = vec![0.0; M + N];
            if i < M {
                row[..M].copy_from_slice(&updated.innovation_root[i]);
            } else {
                row[..M].copy_from_slice(&updated.gain_root[i - M]);
                row[M..].copy_from_slice(&root[i - M]);
            }
            row
        })
        .collect();
    let error = loader_common::deviation(&joint, &matrix(&golden["joint_L"]));
    assert!(error <= tolerance, "joint factor: {error:e}");
    assert_matrix("S_y", &updated.innovation_root, &golden["S_y"], tolerance);
    assert_matrix("S", &root, &golden["S_post"], tolerance);
    // The innovation is a difference of order 1e-2 between numbers of order 1: it and what follows lose two digits.
    assert_matrix("K", &rows(&gain(&updated)), &golden["K"], 10.0 * tolerance);
    assert_row("x", &prediction.state, &golden["x_post"], 100.0 * tolerance);
    assert!((updated.nis() / number(&golden["NIS"]) - 1.0).abs() < 1000.0 * tolerance);
}
