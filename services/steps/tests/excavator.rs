//! The excavator's messages: no value is lost between the filter stage and the regression.

use estimation::excavator::{Columns, Method, Motion, MotionFilter, Sample, Settings};
use messages::EXCAVATOR_METHODS;
use steps::excavator::{motion, motion_message};

/// Signal bits of a source with velocity and torque.
const ALL: u32 = messages::excavator_bits::SWING_VELOCITY | messages::excavator_bits::SWING_TORQUE;

fn valid(sample: &Sample) -> u32 {
    use messages::excavator_bits as bits;
    let bit = |bit, value: Option<f64>| if value.is_some() { bit } else { 0 };
    bit(bits::SWING_VELOCITY, sample.velocity)
        | bit(bits::SWING_ANGLE, sample.angle)
        | bit(bits::SWING_TORQUE, sample.torque)
}

/// A swing with a lost velocity, a lost torque, and a row with a time out of order.
fn motions(encoder: bool) -> Vec<(Motion, u32)> {
    let columns = Columns {
        velocity: !encoder,
        angle: encoder,
        torque: true,
        posture: false,
    };
    let settings = Settings::calibrated();
    let mut filter = MotionFilter::new(&settings, columns).expect("default settings");
    let row = |k: u32| {
        let time = 0.01 * f64::from(if k == 300 { 100 } else { k });
        let present = k % 7 != 3;
        Sample {
            time,
            velocity: (!encoder && present).then_some((0.8 * time).sin()),
            angle: (encoder && present).then_some(-(0.8 * time).cos()),
            torque: (k % 5 != 2).then_some(4_000.0 * (0.8 * time).cos()),
            ..Sample::default()
        }
    };
    (0..500)
        .map(row)
        .map(|sample| (filter.step(&sample), valid(&sample)))
        .collect()
}

#[test]
fn a_motion_survives_its_message() {
    for encoder in [false, true] {
        let motions = motions(encoder);
        assert!(motions.iter().any(|(m, _)| m.refused));
        assert!(motions.iter().any(|(m, _)| !m.measured));
        assert!(motions.iter().any(|(m, _)| !m.torque_measured));
        for (m, valid) in motions.iter().filter(|(m, _)| !m.refused) {
            assert_eq!(motion(&motion_message(m, *valid)), *m);
        }
    }
}

#[test]
fn every_field_of_a_motion_has_a_place_in_the_message() {
    // All values differ, so that exchanged fields are detected.
    let m = Motion {
        time: 1.0,
        period: 2.0,
        velocity: 3.0,
        velocity_std: 4.0,
        acceleration: 5.0,
        acceleration_std: 6.0,
        innovation: 7.0,
        innovation_std: 8.0,
        filtered_velocity: 9.0,
        filtered_acceleration: 10.0,
        filtered_torque: 11.0,
        filtered_direction: 12.0,
        filtered_one: 13.0,
        convergence_delay: 14.0,
        age: 15.0,
        measured: true,
        torque_measured: true,
        manoeuvre: true,
        standstill: true,
        refused: true,
    };
    assert_eq!(motion(&motion_message(&m, ALL)), m);
    let nothing = Motion::default();
    assert_eq!(motion(&motion_message(&nothing, 0)), nothing);
}

#[test]
fn the_numbers_of_the_methods_are_those_of_the_messages() {
    let names = Method::ALL.map(Method::name);
    assert_eq!(names.as_slice(), EXCAVATOR_METHODS);
    for (index, method) in Method::ALL.into_iter().enumerate() {
        assert_eq!(method.index() as usize, index);
    }
}

#[test]
fn the_names_and_words_of_the_reasons_are_those_of_the_messages() {
    let said = estimation::excavator::Reason::ALL.map(|reason| (reason.name(), reason.words()));
    assert_eq!(said.as_slice(), messages::EXCAVATOR_REASONS);
    for (code, reason) in (0..).zip(estimation::excavator::Reason::ALL) {
        assert_eq!(reason.code(), code);
        assert_eq!(estimation::excavator::Reason::of(code), reason);
    }
}
