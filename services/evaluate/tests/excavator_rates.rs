//! Rows that come slower than the estimator's ticks: the boom's pressures weigh as they do at 100 Hz.

use config::{Excavator, Tables as _};
use estimation::excavator::keys::Description;
use estimation::excavator::{Columns, Cylinder, Method, Sample, Settings, SwingEstimator};
use evaluate::excavator::honesty_lines::described;
use sim::excavator::{Effects, Row, Size, Work, cylinders};

/// A minute of work [rows of 100 Hz].
const ROWS: usize = 6000;
/// No slower swing is one [rad/s].
const STANDS: f64 = 0.02;

const COLUMNS: Columns = Columns {
    velocity: true,
    angle: false,
    torque: true,
    posture: true,
};

fn sample(row: &Row) -> Sample {
    Sample {
        time: row.time,
        velocity: row.swing_velocity,
        torque: row.swing_torque,
        posture: row.posture,
        boom_head_pressure: row.pressures[0],
        boom_rod_pressure: row.pressures[1],
        ..Sample::default()
    }
}

fn work() -> Work {
    Work::new(Size::t22(), Effects::good(), 1)
}

fn weighing() -> Settings {
    let work = work();
    let [boom, _] = cylinders(&work.size().geometry);
    let mut d = Description::default();
    let c = &mut d.boom_cylinder;
    (c.count, c.head_area, c.rod_area) = (boom.count, boom.head_area, boom.rod_area);
    (c.base_distance, c.rod_distance) = (boom.base_distance, boom.rod_distance);
    (c.angle, c.friction) = (boom.angle, boom.friction);
    Settings {
        boom: Cylinder::of_boom(&d),
        ..described(&work)
    }
}

/// Share of the standing rows that are trusted, of those every so many are read; and whether all of them are right.
fn weighed(every: usize) -> (f64, bool) {
    let mut estimator = SwingEstimator::new(&weighing(), Method::Auto, COLUMNS).expect("settings");
    let (mut stands, mut trusted, mut right) = (0.0, 0.0, true);
    for row in work().take(ROWS).step_by(every) {
        let estimate = estimator.step(&sample(&row));
        if row.truth.velocity.abs() > STANDS {
            continue;
        }
        stands += 1.0;
        if estimate.flags.trusted() {
            trusted += 1.0;
            let away = (estimate.inertia - row.truth.inertia).abs();
            right &= away < 1.96 * estimate.inertia_std;
        }
    }
    (trusted / stands, right)
}

#[test]
fn rows_of_20_and_25_hz_weigh_at_standstill() {
    let (share, _) = weighed(1);
    assert!(share > 0.2, "{share}");
    for every in [4, 5] {
        let (slow, right) = weighed(every);
        assert!(right && slow > 0.8 * share, "{every}: {slow} {share}");
    }
}

#[test]
fn without_torque_and_pressures_the_bucket_may_hold_anything() {
    let mut machine = Excavator::default();
    machine
        .set_all(&["machine.operating_mass=22000"])
        .expect("keys that exist");
    let columns = Columns {
        torque: false,
        ..COLUMNS
    };
    let mut estimator =
        SwingEstimator::new(&Settings::of(&machine), Method::Auto, columns).expect("settings");
    let mut inside = 0;
    for row in work().take(ROWS) {
        let payload = estimator.step(&sample(&row)).payload.expect("a payload");
        inside += usize::from((payload.value - row.truth.payload).abs() < 1.96 * payload.std);
    }
    assert!(inside as f64 > 0.95 * ROWS as f64, "{inside}");
}
