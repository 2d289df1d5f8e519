//! One finite sample of any size in any signal makes no number infinite and stops no method. Ten seconds later the
//! answers are the same as without it.

use estimation::excavator::{
    Columns, Estimate, Method, Motion, MotionFilter, Regression, Sample, Settings, SwingEstimator,
};

const RATE: f64 = 100.0;
const ROWS: usize = 4000;
/// The row of the sample, and the row from which it may have no effect: 10 s later.
const WRONG: usize = 1500;
const AFTER: usize = WRONG + 1000;

const SIZES: [f64; 10] = [
    1e-308, -1.0, 30.0, -1e3, 1e5, -1e7, 1e11, -1e20, 1e160, -1e308,
];

fn columns(angle: bool) -> Columns {
    Columns {
        velocity: !angle,
        angle,
        torque: true,
        posture: true,
    }
}

/// Swings to and fro with damping and friction and small motions of the joints.
fn rows(settings: &Settings, angle: bool) -> Vec<Sample> {
    let inertia = settings.prior.inertia;
    let mut noise = 1_u32;
    let mut drawn = || {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(noise) / f64::from(u32::MAX) - 0.5
    };
    let make = |k: usize| {
        let time = k as f64 / RATE;
        let pulse = core::f64::consts::TAU / 8.0;
        let velocity = 0.6 * (pulse * time).sin();
        let acceleration = 0.6 * pulse * (pulse * time).cos();
        let torque = inertia * acceleration + 0.05 * inertia * velocity;
        Sample {
            time,
            velocity: (!angle).then_some(velocity + 0.004 * drawn()),
            angle: angle.then_some(0.6 / pulse * (1.0 - (pulse * time).cos()) + 1e-4 * drawn()),
            torque: Some(torque * (1.0 + 0.02 * drawn())),
            posture: [0.6, -1.2, -0.8]
                .map(|q| Some(q + 0.02 * (0.7 * time).sin() + 1e-3 * drawn())),
            ..Sample::default()
        }
    };
    (0..ROWS).map(make).collect()
}

fn put(sample: &mut Sample, signal: usize, value: f64) {
    match signal {
        0 => sample.velocity = sample.velocity.map(|_| value),
        1 => sample.angle = sample.angle.map(|_| value),
        2 => sample.torque = Some(value),
        3..=5 => sample.posture[signal - 3] = Some(value),
        _ => sample.inclination = [Some(value), Some(0.0)],
    }
}

fn numbers(e: &Estimate) -> Vec<f64> {
    let mut all = vec![e.inertia, e.inertia_std, e.velocity, e.acceleration, e.nis];
    for q in [e.damping, e.torque, e.payload, e.friction, e.offset]
        .into_iter()
        .flatten()
    {
        all.extend([q.value, q.std]);
    }
    all
}

fn motion_numbers(m: &Motion) -> [f64; 11] {
    [
        m.velocity,
        m.velocity_std,
        m.acceleration,
        m.acceleration_std,
        m.innovation,
        m.innovation_std,
        m.filtered_velocity,
        m.filtered_acceleration,
        m.filtered_torque,
        m.filtered_direction,
        m.filtered_one,
    ]
}

/// Inertia, its standard deviation and velocity of the rows from [`AFTER`] on. Asserts that every number of all rows is finite.
fn run(
    method: Method,
    settings: &Settings,
    rows: &[Sample],
    angle: bool,
    what: &str,
) -> Vec<[f64; 3]> {
    let mut answers = Vec::new();
    let mut keep = |k: usize, e: &Estimate, velocity: f64| {
        assert!(
            numbers(e).iter().all(|x| x.is_finite()),
            "{what}, row {k}: {e:?}"
        );
        if k >= AFTER {
            answers.push([e.inertia, e.inertia_std, velocity]);
        }
    };
    if method.is_regression() {
        let mut filter = MotionFilter::new(settings, columns(angle)).unwrap();
        let mut regression = Regression::new(settings, method).unwrap();
        for (k, row) in rows.iter().enumerate() {
            let motion = filter.step(row);
            assert!(
                motion_numbers(&motion).iter().all(|x| x.is_finite()),
                "{what}, row {k}: {motion:?}"
            );
            keep(k, &regression.step(&motion), motion.velocity);
        }
    } else {
        let mut estimator = SwingEstimator::new(settings, method, columns(angle)).unwrap();
        for (k, row) in rows.iter().enumerate() {
            let e = estimator.step(row);
            keep(k, &e, e.velocity);
        }
    }
    answers
}

#[test]
fn a_sample_of_any_size_is_forgotten_within_ten_seconds() {
    for angle in [false, true] {
        let settings = Settings::calibrated();
        let clean_rows = rows(&settings, angle);
        for method in Method::ALL {
            let clean = run(method, &settings, &clean_rows, angle, "clean");
            for (signal, value) in (0..7).flat_map(|i| SIZES.map(|size| (i, size))) {
                // The source does not have this signal.
                if signal == usize::from(!angle) {
                    continue;
                }
                let mut spoiled = clean_rows.clone();
                put(&mut spoiled[WRONG], signal, value);
                let what = format!(
                    "{}, angle {angle}, signal {signal} = {value:e}",
                    method.name()
                );
                let found = run(method, &settings, &spoiled, angle, &what);
                let last = clean.len() - 1;
                // The velocity of the other methods follows their model of the motion, which is tested by the inertia.
                for (c, f) in clean
                    .iter()
                    .zip(&found)
                    .step_by(50)
                    .filter(|_| method.is_regression())
                {
                    assert!(
                        (c[2] - f[2]).abs() < 0.02,
                        "{what}: velocity {} became {}",
                        c[2],
                        f[2]
                    );
                }
                let off = (clean[last][0] - found[last][0]).abs();
                let room = 3.0 * clean[last][1].hypot(found[last][1]) + 0.02 * clean[last][0];
                let reported = found[last][1] < 30.0 * clean[last][1] + 0.1 * clean[last][0];
                assert!(
                    off < room && reported,
                    "{what}: {:?} became {:?}",
                    clean[last],
                    found[last]
                );
            }
        }
    }
}
