//! Parameters of real machines from independent recordings. If a recording is absent, its test reports that and passes.

mod excavator_common;
#[path = "../../../tests/common/theirs.rs"]
mod theirs;

use estimation::excavator::{
    Columns, Estimate, Method, MotionFilter, Regression, Sample, Settings,
};
use excavator_common::Table;

fn recording(name: &str) -> Option<Table> {
    Table::read(theirs::data(&format!("recorded/{name}"))?.to_str()?)
}

const ENCODER: Columns = Columns {
    velocity: false,
    angle: true,
    torque: true,
    posture: false,
};

/// Runs the filter and the regression over a recording; calls `look` with each estimate.
fn run(
    table: &Table,
    settings: &Settings,
    angle: &str,
    torque: &str,
    mut look: impl FnMut(f64, &Estimate),
) -> Estimate {
    let mut filter = MotionFilter::new(settings, ENCODER).unwrap();
    let mut regression = Regression::new(settings, Method::SvfRls).unwrap();
    let mut last = Estimate::default();
    for k in 0..table.rows.len() {
        let sample = Sample {
            time: table.get(k, "t_s").unwrap(),
            angle: table.get(k, angle),
            torque: table.get(k, torque),
            ..Sample::default()
        };
        last = regression.step(&filter.step(&sample));
        look(sample.time, &last);
    }
    last
}

/// Settings of the axis: only the order of magnitude of its parameters is stated.
fn axis(filter_frequency: f64) -> Settings {
    let mut s = Settings::calibrated();
    s.sensors.rate = 1000.0;
    s.sensors.swing_angle_std = 1e-5;
    s.sensors.swing_torque_std = 5.0;
    s.nominal_damping = 100.0;
    s.coulomb_friction = 10.0;
    s.inertia_min = 1.0;
    s.inertia_max = 1000.0;
    s.prior.inertia = 50.0;
    s.prior.inertia_std = 50.0;
    s.prior.damping_std = 200.0;
    s.prior.friction_std = 50.0;
    s.prior.torque_offset_std = 20.0;
    s.estimator.estimate_damping = true;
    s.estimator.estimate_friction = true;
    s.estimator.estimate_offset = true;
    s.estimator.filter_frequency = filter_frequency;
    s.estimator.svf_friction_width = 0.002;
    s
}

#[test]
fn mass_and_friction_of_a_real_axis_come_out_as_published() {
    let Some(table) = recording("emps_identification.csv") else {
        return;
    };
    // The result must not depend on the one setting that a user has to choose.
    for filter_frequency in [20.0, 40.0, 60.0, 80.0] {
        let settings = axis(filter_frequency);
        let end = run(&table, &settings, "position_m", "motor_force_N", |_, _| ());
        let found = [
            ("mass", end.inertia, end.inertia_std, 95.1089, 0.02),
            (
                "damping",
                end.damping.unwrap().value,
                end.damping.unwrap().std,
                203.5034,
                0.03,
            ),
            (
                "friction",
                end.friction.unwrap().value,
                end.friction.unwrap().std,
                20.3935,
                0.05,
            ),
            (
                "offset",
                end.offset.unwrap().value,
                end.offset.unwrap().std,
                -3.1648,
                0.05,
            ),
        ];
        for (name, value, std, published, share) in found {
            let error = value / published - 1.0;
            println!(
                "{filter_frequency} rad/s {name} {value:.3} +- {std:.3}: {:+.2} %",
                100.0 * error
            );
            assert!(
                error.abs() < share,
                "{name} at {filter_frequency} rad/s: {value}"
            );
            assert!(
                (value - published).abs() < 1.96 * std,
                "{name}: {value} +- {std}"
            );
        }
        assert!(end.flags.identifiable && end.flags.converged);
    }
}

#[test]
fn interval_of_a_servo_stand_covers_its_inertia_from_the_first_second_on() {
    let Some(table) = recording("hsm150_torque_steps.csv") else {
        return;
    };
    let mut s = axis(60.0);
    s.sensors.swing_angle_std = 3e-4;
    s.sensors.swing_torque_std = 0.01;
    s.nominal_damping = 1e-4;
    s.coulomb_friction = 1e-3;
    s.inertia_min = 1e-6;
    s.inertia_max = 1e-2;
    s.prior.inertia = 3e-4;
    s.prior.inertia_std = 3e-4;
    s.prior.damping_std = 2e-4;
    s.prior.friction_std = 0.01;
    s.prior.torque_offset_std = 0.01;
    s.estimator.svf_friction_width = 1.0;
    let end = run(&table, &s, "position_rad", "torque_meas_Nm", |t, e| {
        assert!(
            (e.inertia - 1.2e-4).abs() < 1.96 * e.inertia_std,
            "{t} s: {e:?}"
        );
    });
    println!(
        "inertia {:.2e} +- {:.2e} kg m^2",
        end.inertia, end.inertia_std
    );
    // One direction of motion and slow steps: the record carries little information about it, so it is not trusted.
    assert!(!end.flags.trusted());
}
