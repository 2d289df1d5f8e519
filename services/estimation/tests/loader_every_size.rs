//! One finite sample of any size in any signal makes no number infinite and stops no method of the loader.

use estimation::loader::keys::Description;
use estimation::loader::{CgEstimator, Columns, Estimate, Machine, Method, Sample, Settings};

const COLUMNS: Columns = Columns { acceleration: true };
const ROWS: usize = 4000;
const WRONG: usize = 1500;
const AFTER: usize = WRONG + 1000;
const SIZES: [f64; 6] = [1e-308, 10.0, 1e4, 1e20, 1e160, 1e308];

/// Accelerates and stops on a level road, with a little slip.
fn sample(k: usize) -> Sample {
    let time = k as f64 / 100.0;
    let machine = Machine::default();
    let pulse = core::f64::consts::TAU / 10.0;
    let (speed, acceleration) = (2.5 + (pulse * time).sin(), pulse * (pulse * time).cos());
    let force = machine.mass * (acceleration + machine.rolling_resistance * 9.81);
    let slip = |share: f64| 0.5 * force / (19.0 * share * machine.mass * 9.81);
    Sample {
        time,
        speed: Some(speed),
        front_wheel_speed: Some(speed * (1.0 + slip(0.45)) / machine.wheel_radius),
        rear_wheel_speed: Some(speed * (1.0 + slip(0.55)) / machine.wheel_radius),
        front_torque: Some(0.5 * force * machine.wheel_radius),
        rear_torque: Some(0.5 * force * machine.wheel_radius),
        slope: Some(0.0),
        acceleration: Some(acceleration),
        ..Sample::default()
    }
}

fn put(sample: &mut Sample, signal: usize, value: f64) {
    let place = match signal {
        0 => &mut sample.speed,
        1 => &mut sample.front_wheel_speed,
        2 => &mut sample.rear_wheel_speed,
        3 => &mut sample.front_torque,
        4 => &mut sample.rear_torque,
        5 => &mut sample.slope,
        6 => &mut sample.acceleration,
        7 => &mut sample.articulation,
        _ => &mut sample.yaw_rate,
    };
    *place = Some(value);
}

fn run(method: Method, wrong: Option<(usize, f64)>) -> Vec<[f64; 5]> {
    let settings = Settings::of(&Description::default(), method);
    let mut estimator = CgEstimator::new(&settings, method, COLUMNS).unwrap();
    let mut answers = Vec::new();
    for k in 0..ROWS {
        let mut row = sample(k);
        if let (true, Some((signal, value))) = (k == WRONG, wrong) {
            put(&mut row, signal, value);
        }
        estimator.step(&row);
        let e: &Estimate = estimator.last();
        let all = [
            e.speed,
            e.front_wheel_speed,
            e.rear_wheel_speed,
            e.cg_distance,
            e.nis,
        ];
        let learnt = [e.slip_stiffness, e.cg_height, e.cg_ratio].map(|q| [q.value, q.std]);
        let is_finite = all
            .iter()
            .chain(learnt.iter().flatten())
            .all(|x| x.is_finite());
        assert!(is_finite, "{} {wrong:?}, row {k}: {e:?}", method.name());
        if k >= AFTER {
            let stiffness = [e.slip_stiffness.value, e.slip_stiffness.std];
            answers.push([
                e.cg_ratio.value,
                e.cg_ratio.std,
                e.speed,
                stiffness[0],
                stiffness[1],
            ]);
        }
    }
    answers
}

#[test]
fn a_sample_of_any_size_is_forgotten_within_ten_seconds() {
    for method in Method::ALL {
        let clean = run(method, None);
        for (signal, size) in (0..9).flat_map(|i| SIZES.map(|size| (i, size))) {
            for value in [size, -size] {
                let found = run(method, Some((signal, value)));
                let what = format!("{}, signal {signal} = {value:e}", method.name());
                let last = clean.len() - 1;
                for (c, f) in clean.iter().zip(&found).step_by(50) {
                    assert!(
                        (c[2] - f[2]).abs() < 0.1,
                        "{what}: speed {} became {}",
                        c[2],
                        f[2]
                    );
                }
                let off = (clean[last][0] - found[last][0]).abs();
                let room = 3.0 * clean[last][1].hypot(found[last][1]) + 0.01;
                assert!(
                    off < room,
                    "{what}: {:?} became {:?}",
                    clean[last],
                    found[last]
                );
            }
        }
    }
}

/// The filters of the paper weight every sample by its usual noise (docs/reliability.md), so a wrong one acts longer in them.
#[test]
fn the_slip_stiffness_of_a_protected_filter_outlives_one_wrong_wheel_speed() {
    for method in [Method::Full, Method::FullEkf] {
        let clean = run(method, None);
        for (signal, value) in [
            (1, 0.0),
            (2, 0.0),
            (1, 4.0),
            (2, 4.0),
            (1, -50.0),
            (2, 20.0),
        ] {
            let found = run(method, Some((signal, value)));
            for (c, f) in clean.iter().zip(&found) {
                assert!(
                    (c[3] - f[3]).abs() < c[4].hypot(f[4]),
                    "{}, signal {signal} = {value}: slip stiffness {} +- {} became {} +- {}",
                    method.name(),
                    c[3],
                    c[4],
                    f[3],
                    f[4]
                );
            }
        }
    }
}
