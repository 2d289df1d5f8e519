//! Machines of other sizes than the reference machine: every constant scales with the machine.

mod excavator_common;

use estimation::excavator::{Method, Sample, Settings, SwingEstimator, Variant};
use excavator_common::{Table, columns_for, golden_settings, samples};

/// The reference machine with all masses, torques and their uncertainties multiplied by `size`:
/// its motion is exactly the same.
fn machine(size: f64) -> Settings {
    let mut s = golden_settings();
    s.estimator.variant = Variant::Known;
    s.geometry.upper_inertia *= size;
    s.geometry.masses = s.geometry.masses.map(|x| x * size);
    s.geometry.inertias = s.geometry.inertias.map(|x| x * size);
    s.geometry.axial_inertias = s.geometry.axial_inertias.map(|x| x * size);
    s.sensors.swing_torque_std *= size;
    for value in [
        &mut s.nominal_damping,
        &mut s.coulomb_friction,
        &mut s.inertia_min,
        &mut s.inertia_max,
        &mut s.prior.inertia,
        &mut s.prior.inertia_std,
        &mut s.prior.payload,
        &mut s.prior.payload_std,
        &mut s.prior.damping_std,
        &mut s.prior.torque_offset_std,
        &mut s.prior.known_torque_offset_std,
    ] {
        *value *= size;
    }
    s
}

fn rows(input: &str, size: f64) -> Vec<Sample> {
    let mut rows = samples(&Table::golden(input));
    for row in &mut rows {
        row.torque = row.torque.map(|torque| torque * size);
    }
    rows
}

#[test]
fn a_machine_of_another_size_is_estimated_as_the_reference_machine_is() {
    let auto = |mut s: Settings| {
        s.estimator.variant = Variant::Auto;
        s
    };
    for input in [
        "input_base_case1.csv",
        "input_base_case3.csv",
        "input_drop.csv",
    ] {
        for size in [0.1, 0.3, 3.0, 30.0] {
            for method in [Method::PostureTorque, Method::Torque, Method::Posture] {
                let settings = |size| {
                    if method == Method::PostureTorque {
                        auto(machine(size))
                    } else {
                        machine(size)
                    }
                };
                let columns = columns_for(method);
                let mut one = SwingEstimator::new(&settings(1.0), method, columns).unwrap();
                let mut other = SwingEstimator::new(&settings(size), method, columns).unwrap();
                for (a, b) in rows(input, 1.0).iter().zip(&rows(input, size)) {
                    let (expected, found) = (one.step(a), other.step(b));
                    if a.time < 6.0 {
                        continue;
                    }
                    // The limits of the payload and the variance of the momentum at rest do not
                    // scale with the machine.
                    let share = found.inertia / size / expected.inertia - 1.0;
                    assert!(
                        share.abs() < 0.05,
                        "{input} {method:?} x {size} at {:.2} s: {share}",
                        a.time
                    );
                }
            }
        }
    }
}
