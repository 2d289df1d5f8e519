//! Information of the velocity alone about the content of the bucket.

use config::{Excavator, Tables as _};
use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};
use sim::excavator::{Effects, Row, Size, Work};

/// A minute of work [rows of 100 Hz].
const ROWS: usize = 6000;

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
        ..Sample::default()
    }
}

fn work() -> Work {
    Work::new(Size::t22(), Effects::good(), 1)
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
