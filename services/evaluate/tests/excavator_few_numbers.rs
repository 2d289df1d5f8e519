//! What a few numbers of the data sheet say of the loads of the reference machine, whose boom stands ahead on a post.

use config::{Excavator, Tables as _};
use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};
use sim::excavator::{Effects, Size, Work};

const COLUMNS: Columns = Columns {
    velocity: true,
    angle: false,
    torque: true,
    posture: true,
};

/// Half of the rated payload [kg]; slowest swing [rad/s].
const LOAD: f64 = 210.0;
const SWINGS: f64 = 0.1;

/// Of 60 s the rows in which the machine swings a load: shares of payload and inertia inside their 95 % intervals.
fn covered(stated: &[&str], seed: u64) -> [f64; 2] {
    let mut described = Excavator::default();
    let stated: Vec<String> = stated.iter().map(|text| (*text).to_owned()).collect();
    described.set_all(&stated).expect("keys that exist");
    let mut estimator =
        SwingEstimator::new(&Settings::of(&described), Method::Auto, COLUMNS).expect("settings");
    let (mut inside, mut rows) = ([0; 2], 0);
    for row in Work::new(Size::reference(), Effects::default(), seed).take(6000) {
        let estimate = estimator.step(&Sample {
            time: row.time,
            velocity: row.swing_velocity,
            torque: row.swing_torque,
            posture: row.posture,
            ..Sample::default()
        });
        if row.truth.payload < LOAD || row.truth.velocity.abs() < SWINGS {
            continue;
        }
        let payload = estimate.payload.expect("a payload");
        let away = [
            (payload.value - row.truth.payload) / payload.std,
            (estimate.inertia - row.truth.inertia) / estimate.inertia_std,
        ];
        rows += 1;
        for (count, away) in inside.iter_mut().zip(away) {
            *count += i32::from(away.abs() < 1.96);
        }
    }
    inside.map(|count| f64::from(count) / f64::from(rows))
}

#[test]
fn loads_lie_inside_their_intervals_where_nobody_states_the_boom_pin() {
    let class = "machine.operating_mass=5500";
    let sheet = [
        class,
        "machine.rated_payload=500",
        "machine.swing_torque=12000",
        "machine.geometry.boom_length=3.0",
        "machine.geometry.arm_length=1.6",
    ];
    for stated in [&sheet[..], &[class]] {
        let of_seeds = [1, 2, 3].map(|seed| covered(stated, seed));
        for (i, what) in ["payload", "inertia"].into_iter().enumerate() {
            let mean = of_seeds.iter().map(|covered| covered[i]).sum::<f64>() / 3.0;
            println!("{} numbers, {what}: {of_seeds:?}", stated.len());
            assert!(mean > 0.93, "{stated:?}, {what}: {mean}");
        }
    }
}
