//! Loads of the reference machine, whose boom stands ahead on a post, with only a few stated numbers of the data sheet.

use config::{Excavator, Tables as _};
use estimation::excavator::{Columns, Method, Sample, Settings, Smoother, SwingEstimator, Trail};
use sim::excavator::{Effects, Size, Truth, Work};

const COLUMNS: Columns = Columns {
    velocity: true,
    angle: false,
    torque: true,
    posture: true,
};

/// Least payload that counts as a load [kg], half of the rated one; least velocity of a swing [rad/s].
const LOAD: f64 = 210.0;
const SWINGS: f64 = 0.1;

/// Rows of the reference machine for this number of seconds.
fn work(effects: Effects, seed: u64, seconds: usize) -> impl Iterator<Item = (Sample, Truth)> {
    let rows = Work::new(Size::reference(), effects, seed).take(100 * seconds);
    rows.map(|row| {
        let sample = Sample {
            time: row.time,
            velocity: row.swing_velocity,
            torque: row.swing_torque,
            posture: row.posture,
            ..Sample::default()
        };
        (sample, row.truth)
    })
}

fn described(stated: &[&str]) -> Excavator {
    let mut described = Excavator::default();
    described.set_all(stated).expect("keys that exist");
    described
}

fn estimator(described: &Excavator) -> SwingEstimator {
    SwingEstimator::new(&Settings::of(described), Method::Auto, COLUMNS).expect("settings")
}

/// Shares of the rows with a swinging load in which the 95 % intervals of payload and inertia cover the truth.
fn covered(stated: &[&str], rows_of: impl Iterator<Item = (Sample, Truth)>) -> [f64; 2] {
    let mut estimator = estimator(&described(stated));
    let (mut inside, mut rows) = ([0; 2], 0);
    for (sample, truth) in rows_of {
        let estimate = estimator.step(&sample);
        if truth.payload < LOAD || truth.velocity.abs() < SWINGS {
            continue;
        }
        let payload = estimate.payload.expect("a payload");
        let away = [
            (payload.value - truth.payload) / payload.std,
            (estimate.inertia - truth.inertia) / estimate.inertia_std,
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
        let of_seeds = [1, 2, 3].map(|seed| covered(stated, work(Effects::default(), seed, 60)));
        for (i, what) in ["payload", "inertia"].into_iter().enumerate() {
            let mean = of_seeds.iter().map(|covered| covered[i]).sum::<f64>() / 3.0;
            println!("{} numbers, {what}: {of_seeds:?}", stated.len());
            assert!(mean > 0.93, "{stated:?}, {what}: {mean}");
        }
    }
}

#[test]
fn soil_that_stays_in_every_emptied_bucket_is_no_heavier_bucket() {
    for seed in [1, 2, 3] {
        let effects = Effects {
            sticks: Some(0.1),
            ..Effects::default()
        };
        let [payload, _] = covered(&["machine.mass_tolerance=0.02"], work(effects, seed, 480));
        assert!(payload > 0.98, "{seed}: {payload}");
    }
}

#[test]
fn what_later_rows_say_of_a_load_does_not_tell_its_scale() {
    let described = described(&["machine.operating_mass=5500"]);
    let scale = described.loads_common().scale_std;
    assert!(scale > 0.1, "{scale}");
    let mut estimator = estimator(&described);
    assert!(estimator.keep_trail());
    let mut trails: Vec<Trail> = Vec::new();
    for (sample, _) in work(Effects::default(), 1, 60) {
        estimator.step_with(&sample, &mut |trail| trails.push(*trail));
    }
    let mut smoother = Smoother::default();
    for payload in trails
        .iter()
        .rev()
        .map(|trail| smoother.back(trail).payload)
    {
        assert!(payload.std >= scale * payload.value, "{payload:?}");
    }
}
