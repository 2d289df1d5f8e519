//! Message of the swing motion, between the filter stage and the regression.

use estimation::excavator::Motion;
use messages::{Stamp, SwingMotion, excavator_bits as bits};

use crate::bits::set_bits;

/// The message of a motion. `valid`: signal bits of its sample.
pub fn message(m: &Motion, valid: u32) -> SwingMotion {
    // A signal that the gate rejected is no longer valid.
    let signals = bits::SWING_VELOCITY | bits::SWING_ANGLE;
    let accepted = if m.measured { valid } else { valid & !signals };
    let flags = [
        (bits::MANOEUVRE, m.manoeuvre),
        (bits::STANDSTILL, m.standstill),
        (bits::REFUSED, m.refused),
    ];
    SwingMotion {
        stamp: Stamp {
            time: m.time,
            ..Stamp::default()
        },
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
        valid: accepted,
        flags: set_bits(&flags),
        ..SwingMotion::default()
    }
}

/// The motion in a message.
pub fn motion(m: &SwingMotion) -> Motion {
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
        measured: m.innovation_std > 0.0,
        torque_measured: m.valid & bits::SWING_TORQUE != 0,
        manoeuvre: m.flags & bits::MANOEUVRE != 0,
        standstill: m.flags & bits::STANDSTILL != 0,
        refused: m.flags & bits::REFUSED != 0,
    }
}
