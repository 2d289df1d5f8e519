//! Messages of the excavator into the terms of the estimators, and back.

use estimation::Quantity;
use estimation::excavator::{Columns, Estimate, Flags, Motion, Sample};
use messages::{ExcavatorEstimate, ExcavatorSensors, SwingMotion, excavator_bits as bits};

/// The columns that a sample says its source has.
#[must_use]
pub fn columns(columns: u32) -> Columns {
    let posture = bits::BOOM_ANGLE | bits::ARM_ANGLE | bits::BUCKET_ANGLE;
    Columns {
        velocity: columns & bits::SWING_VELOCITY != 0,
        angle: columns & bits::SWING_ANGLE != 0,
        torque: columns & bits::SWING_TORQUE != 0,
        posture: columns & posture == posture,
    }
}

/// The sample in a message; a signal without its bit is missing.
#[must_use]
pub fn sample(m: &ExcavatorSensors) -> Sample {
    let valid = |bit: u32, value: f64| (m.valid & bit != 0).then_some(value);
    Sample {
        time: m.stamp.time,
        velocity: valid(bits::SWING_VELOCITY, m.swing_velocity),
        angle: valid(bits::SWING_ANGLE, m.swing_angle),
        torque: valid(bits::SWING_TORQUE, m.swing_torque),
        posture: [
            valid(bits::BOOM_ANGLE, m.boom_angle),
            valid(bits::ARM_ANGLE, m.arm_angle),
            valid(bits::BUCKET_ANGLE, m.bucket_angle),
        ],
    }
}

/// The message of a motion made from a sample with the signals `valid`.
#[must_use]
pub fn swing_motion(m: &Motion, valid: u32) -> SwingMotion {
    SwingMotion {
        velocity: m.velocity,
        velocity_std: m.velocity_std,
        acceleration: m.acceleration,
        acceleration_std: m.acceleration_std,
        innovation: m.innovation,
        innovation_std: m.innovation_std,
        filtered_velocity: m.filtered_velocity,
        filtered_acceleration: m.filtered_acceleration,
        filtered_torque: m.filtered_torque,
        filtered_direction: m.filtered_direction,
        filtered_one: m.filtered_one,
        convergence_delay: m.convergence_delay,
        period: m.period,
        age: m.age,
        torque_age: m.torque_age,
        valid,
        flags: set_bits(&[
            (bits::MANOEUVRE, m.manoeuvre),
            (bits::STANDSTILL, m.standstill),
            (bits::MEASURED, m.measured),
            (bits::HAS_TORQUE, m.has_torque),
            (bits::MOTION_REFUSED, m.refused),
        ]),
        ..SwingMotion::default()
    }
}

/// The motion in a message.
#[must_use]
pub fn motion(m: &SwingMotion) -> Motion {
    let flag = |bit: u32| m.flags & bit != 0;
    Motion {
        time: m.stamp.time,
        period: m.period,
        velocity: m.velocity,
        velocity_std: m.velocity_std,
        acceleration: m.acceleration,
        acceleration_std: m.acceleration_std,
        innovation: m.innovation,
        innovation_std: m.innovation_std,
        filtered_velocity: m.filtered_velocity,
        filtered_acceleration: m.filtered_acceleration,
        filtered_torque: m.filtered_torque,
        filtered_direction: m.filtered_direction,
        filtered_one: m.filtered_one,
        convergence_delay: m.convergence_delay,
        age: m.age,
        torque_age: m.torque_age,
        measured: flag(bits::MEASURED),
        has_torque: flag(bits::HAS_TORQUE),
        manoeuvre: flag(bits::MANOEUVRE),
        standstill: flag(bits::STANDSTILL),
        refused: flag(bits::MOTION_REFUSED),
    }
}

/// The message of an estimate; what the method does not estimate stays 0 without its bit.
#[must_use]
pub fn message(e: &Estimate) -> ExcavatorEstimate {
    let of = |quantity: Option<Quantity>| quantity.unwrap_or_default();
    let (damping, torque, payload) = (of(e.damping), of(e.torque), of(e.payload));
    let (friction, offset) = (of(e.friction), of(e.offset));
    ExcavatorEstimate {
        inertia: e.inertia,
        inertia_std: e.inertia_std,
        damping: damping.value,
        damping_std: damping.std,
        torque: torque.value,
        torque_std: torque.std,
        payload: payload.value,
        payload_std: payload.std,
        velocity: e.velocity,
        acceleration: e.acceleration,
        friction: friction.value,
        friction_std: friction.std,
        offset: offset.value,
        offset_std: offset.std,
        nis: e.nis,
        forgetting_inertia: e.forgetting[0],
        forgetting_damping: e.forgetting[1],
        forgetting_torque: e.forgetting[2],
        flags: flags(&e.flags),
        estimated: estimated(e),
        method: e.method.index(),
        refused: e.refused,
        ..ExcavatorEstimate::default()
    }
}

fn flags(f: &Flags) -> u32 {
    set_bits(&[
        (bits::EXCITED, f.excited),
        (bits::CONSISTENT, f.consistent),
        (bits::FRESH, f.fresh),
        (bits::CONVERGED, f.converged),
        (bits::IDENTIFIABLE, f.identifiable),
        (bits::HELD, f.held),
        (bits::CHANGING, f.changing),
        (bits::RESET, f.reset),
        (bits::TRUSTED, f.trusted()),
        (bits::NOMINAL, f.nominal),
        (bits::WINDOW, f.window),
        (bits::REFUSED, f.refused),
    ])
}

fn estimated(e: &Estimate) -> u32 {
    set_bits(&[
        (bits::INERTIA, true),
        (bits::ACCELERATION, true),
        (bits::DAMPING, e.damping.is_some()),
        (bits::TORQUE, e.torque.is_some()),
        (bits::PAYLOAD, e.payload.is_some()),
        (bits::FRICTION, e.friction.is_some()),
        (bits::OFFSET, e.offset.is_some()),
    ])
}

fn set_bits(all: &[(u32, bool)]) -> u32 {
    all.iter()
        .filter(|(_, set)| *set)
        .fold(0, |bits, (bit, _)| bits | bit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_survives_its_message() {
        let original = Motion {
            time: 1.5,
            period: 0.01,
            velocity: 0.1,
            filtered_torque: 300.0,
            torque_age: 0.02,
            measured: true,
            refused: true,
            ..Motion::default()
        };
        let mut message = swing_motion(&original, 3);
        message.stamp.time = original.time;
        assert_eq!(motion(&message), original);
    }

    #[test]
    fn methods_have_the_same_index_in_messages_and_estimators() {
        use estimation::excavator::Method;
        for method in Method::ALL {
            assert_eq!(
                messages::EXCAVATOR_METHODS[method.index() as usize],
                method.name()
            );
        }
    }
}
