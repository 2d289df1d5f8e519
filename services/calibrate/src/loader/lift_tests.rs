//! Lifts of a simulated arm: statics, Coulomb friction, zeros of the sensors, noise.

use config::Loader as Description;
use estimation::Quantity;
use estimation::loader::{CgEstimator, Columns, Method, Sample, Settings};

use super::lift::{CylinderFit, learn, write};
use super::made::noise;
use super::{GRAVITY, Input, Options, StatedLoad, calibrate};
use crate::output::Pen;

/// A 12 t loader as drawn.
fn described() -> Description {
    let mut d = Description::default();
    (d.machine.mass, d.machine.wheelbase) = (12_500.0, 3.0);
    d.sensors.angle_offset_std = 0.009;
    let a = &mut d.lift_arm;
    (a.length, a.pivot_x, a.pivot_z) = (2.68, -1.05, 1.32);
    (a.mass, a.mass_distance) = (690.0, 1.47);
    (a.bucket_mass, a.payload_distance) = (560.0, 0.59);
    a.bucket_turn = Some(TURN);
    let c = &mut d.lift_cylinder;
    (c.head_area, c.rod_area) = (4.33e-3, 2.38e-3);
    (c.base_distance, c.rod_distance, c.angle) = (0.91, 1.39, 1.31);
    (c.friction, c.friction_std) = (0.03, 0.01);
    d
}

/// Turn of its bucket per turn of its arm: a Z-bar.
const TURN: f64 = 0.15;

/// A machine that differs from its drawing.
#[derive(Debug, Clone, Copy)]
struct Truth {
    /// Relative error of the areas, excess force of the pressures \[N\], friction \[N\].
    span: f64,
    zero: f64,
    friction: f64,
    /// Mass of arm and bucket \[kg\], angle of the arm's centre beside its line of pins \[rad\].
    arm: f64,
    bucket: f64,
    beside: f64,
}

impl Truth {
    /// A machine within the tolerances of the drawing.
    fn of(seed: u64) -> Self {
        let mut state = 977 * seed + 5;
        let mut draw = |value: f64, std: f64| value + std * noise(&mut state);
        let full = 2.0 * 4.33e-3 * 20e6;
        Self {
            span: draw(0.0, 0.012),
            zero: draw(0.0, 900.0),
            friction: draw(0.03 * full, 0.007 * full),
            arm: draw(690.0, 30.0),
            bucket: draw(560.0, 90.0),
            beside: draw(0.0, 0.07),
        }
    }

    /// Samples at 50 Hz of a machine that stands and moves its arm by `lift`, with this load \[kg\].
    fn record(&self, load: f64, seed: u64, lift: impl Fn(f64) -> f64) -> Vec<Sample> {
        let d = described();
        let (a, c) = (&d.lift_arm, &d.lift_cylinder);
        let mut state = seed;
        let row = |k: i32| {
            let time = 0.02 * f64::from(k);
            let (th, rises) = (lift(time), (lift(time + 0.01) - lift(time - 0.01)).signum());
            let tilt = 0.3 - (1.0 - TURN) * th;
            let reach = a.length * th.cos() + TURN * a.payload_distance * (th + tilt).cos();
            let moment = GRAVITY
                * (self.arm * a.mass_distance * (th + self.beside).cos()
                    + (self.bucket + load) * reach);
            let angle = th + c.angle;
            let (base, eye) = (c.base_distance, c.rod_distance);
            let length = (base * base + eye * eye - 2.0 * base * eye * angle.cos()).sqrt();
            let lever = base * eye * angle.sin() / length;
            let force = (1.0 + self.span) * moment / lever + self.friction * rises + self.zero;
            let rod = 0.8e6;
            let head = (force / c.count + c.rod_area * rod) / c.head_area;
            Sample {
                time,
                lift_angle: Some(th + 0.001 * noise(&mut state)),
                tilt_angle: Some(tilt + 0.001 * noise(&mut state)),
                lift_head_pressure: Some(head + 5e4 * noise(&mut state)),
                lift_rod_pressure: Some(rod + 5e4 * noise(&mut state)),
                slope: Some(0.0),
                speed: Some(0.0),
                ..Sample::default()
            }
        };
        (0..3000).map(row).collect()
    }

    fn input(&self, load: f64, std: f64, seed: u64) -> Input {
        Input {
            name: format!("{load:.0} kg"),
            samples: self.record(load, seed, up_and_down),
            stated: StatedLoad::default(),
            payload: Some(Quantity { value: load, std }),
        }
    }
}

fn up_and_down(time: f64) -> f64 {
    -0.1 - 0.6 * (0.42 * time).cos()
}

fn learnt(truth: &Truth, seed: u64) -> CylinderFit {
    let inputs = [
        truth.input(0.0, 1.0, seed),
        truth.input(3200.0, 15.0, seed + 1),
    ];
    learn(&described(), &inputs)
        .expect("pressures")
        .expect("a value")
}

fn calibrated(learnt: &CylinderFit) -> Description {
    let mut pen = Pen::new(described());
    write(learnt, &mut pen);
    pen.description
}

/// Load under a description at the end of a slow lift, after 22.4 s.
fn weighed(d: &Description, samples: &[Sample]) -> Quantity {
    let settings = Settings::of(d, Method::Full);
    let mut estimator =
        CgEstimator::new(&settings, Method::Full, Columns::default()).expect("settings");
    let payloads = samples[..1120].iter().map(|s| estimator.step(s).payload);
    payloads.last().flatten().expect("an arm")
}

/// Root of the mean of squares.
fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn machines_unlike_their_drawing_are_found_within_the_written_deviations() {
    let names = ["span", "zero", "friction", "load before", "load after"];
    let mut errors = [const { Vec::new() }; 5];
    let mut loads = [const { Vec::new() }; 2];
    for seed in 1..=12 {
        let truth = Truth::of(seed);
        let found = learnt(&truth, 10 * seed);
        let z = |q: Quantity, truth: f64| (q.value - truth) / q.std;
        // Another load, which was not stated.
        let other = truth.record(2000.0, 10 * seed + 2, up_and_down);
        let [before, after] = [described(), calibrated(&found)].map(|d| weighed(&d, &other));
        for (errors, z) in errors.iter_mut().zip([
            z(found.span, truth.span),
            z(found.zero, truth.zero),
            z(found.friction, truth.friction),
            z(before, 2000.0),
            z(after, 2000.0),
        ]) {
            errors.push(z);
        }
        for (errors, load) in loads.iter_mut().zip([before, after]) {
            errors.push(load.value - 2000.0);
        }
    }
    for (name, errors) in names.iter().zip(&errors) {
        assert!(rms(errors) < 1.4, "{name}: {errors:.1?}");
        assert!(errors.iter().all(|z| z.abs() < 3.0), "{name}: {errors:.1?}");
    }
    // Errors for a load of 2000 kg.
    let [before, after] = loads.map(|errors| rms(&errors));
    assert!(after < 0.35 * before && after < 20.0, "{before} {after}");
}

#[test]
fn a_recording_whose_rows_miss_cells_determines_as_much() {
    let truth = Truth::of(3);
    let whole = [truth.input(0.0, 1.0, 4), truth.input(3200.0, 15.0, 5)];
    let span = |lost: fn(usize, &mut Sample)| {
        let mut inputs = whole.clone();
        for input in &mut inputs {
            for (row, sample) in input.samples.iter_mut().enumerate() {
                lost(row, sample);
            }
        }
        let found = learn(&described(), &inputs);
        found.expect("pressures").expect("a value").span
    };
    let all = span(|_, _| {});
    let tilt = span(|row, sample| sample.tilt_angle = sample.tilt_angle.filter(|_| row % 10 != 3));
    // Angles and pressures in separate rows.
    let in_turn = span(|row, sample| {
        if row % 2 == 0 {
            (sample.lift_head_pressure, sample.lift_rod_pressure) = (None, None);
        } else {
            (sample.lift_angle, sample.tilt_angle) = (None, None);
        }
    });
    for found in [tilt, in_turn] {
        let away = (found.value - all.value).abs();
        assert!(
            away < all.std && found.std < 1.2 * all.std,
            "{found:?} {all:?}"
        );
    }
}

#[test]
fn a_calibrated_description_claims_less_doubt_and_is_read_back() {
    let truth = Truth::of(3);
    let after = calibrated(&learnt(&truth, 4));
    let other = truth.record(2000.0, 9, up_and_down);
    let [drawn, known] = [described(), after.clone()].map(|d| weighed(&d, &other).std);
    assert!(known < 0.75 * drawn, "{known} {drawn}");
    use config::Tables;
    let read = Description::parse(&after.to_toml(), "t").expect("a description");
    // Printed is stated.
    let stated = read.stated;
    assert_eq!(read, Description { stated, ..after });
}

#[test]
fn what_is_indistinguishable_is_refused_with_a_reason() {
    let truth = Truth::of(1);
    let said = |inputs: &[Input]| match learn(&described(), inputs) {
        Some(Err(words)) => words,
        other => panic!("{other:?}"),
    };
    let empty = truth.input(0.0, 1.0, 1);
    let twice = [empty.clone(), truth.input(0.0, 1.0, 2)];
    assert!(said(&twice).contains("too much alike"), "{}", said(&twice));
    let unknown = [empty.clone(), truth.input(3200.0, 800.0, 2)];
    assert!(
        said(&unknown).contains("3200 ± 800 kg"),
        "{}",
        said(&unknown)
    );
    let rising = Input {
        samples: truth.record(0.0, 1, |t| -0.6 + 0.015 * t),
        ..empty.clone()
    };
    assert!(said(&[rising]).contains("lift and lower"));
    let unstated = Input {
        payload: None,
        ..empty.clone()
    };
    assert!(said(&[unstated]).contains("--payload"));
    // The loads are swapped.
    let mut mixed = [empty.clone(), truth.input(3200.0, 15.0, 2)];
    let [a, b] = &mut mixed;
    std::mem::swap(&mut a.payload, &mut b.payload);
    assert!(
        said(&mixed).contains("which recording is which"),
        "{}",
        said(&mixed)
    );
    let mut silent = empty;
    for sample in &mut silent.samples {
        sample.lift_head_pressure = None;
    }
    assert_eq!(learn(&described(), &[silent]), None);
    let nothing = learn(&Description::default(), &[truth.input(0.0, 1.0, 1)]);
    assert!(nothing.is_some_and(|said| {
        said.is_err_and(|why| why.contains("the machine file has no lift arm"))
    }));
}

#[test]
fn a_machine_that_only_lifts_needs_no_wheels() {
    let truth = Truth::of(5);
    let inputs = [truth.input(0.0, 1.0, 1), truth.input(3200.0, 15.0, 2)];
    let d = described();
    let options = Options::of(&d);
    let outcome = calibrate(&inputs, &options).expect("keys");
    assert_eq!(outcome.faults, Vec::<String>::new());
    let (found, text) = outcome.description(&d, &[]).expect("a description");
    assert!(found.lift_cylinder.span_std > 0.0 && text.contains("only its lift cylinders"));
    assert_eq!(found.lift_arm.bucket_turn, Some(TURN));
    // Where the turn of the bucket is not stated, the angles determine it.
    let mut unstated = d.clone();
    unstated.lift_arm.bucket_turn = None;
    let outcome = calibrate(&inputs, &Options::of(&unstated)).expect("keys");
    let (found, _) = outcome.description(&unstated, &[]).expect("a description");
    let turn = found.lift_arm.bucket_turn.expect("it was learnt");
    assert!((turn - TURN).abs() < 0.05, "{turn}");
    let other = weighed(&found, &truth.record(2000.0, 9, up_and_down));
    assert!((other.value - 2000.0).abs() < 40.0, "{other:?}");
    // One load alone is no result.
    let outcome = calibrate(&inputs[..1], &options).expect("keys");
    assert!(
        outcome.faults[0].contains("too much alike"),
        "{:?}",
        outcome.faults
    );
    assert!(outcome.description(&d, &[]).is_none());
}
