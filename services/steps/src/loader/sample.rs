//! What the loader's sensors measured, as a sample.

use estimation::loader::Sample;
use messages::{LoaderSensors, loader_bits as bits};

/// The sample in a message; a signal without its bit is missing.
#[must_use]
pub fn sample(m: &LoaderSensors) -> Sample {
    let valid = |bit: u32, value: f64| (m.valid & bit != 0).then_some(value);
    Sample {
        time: m.stamp.time,
        speed: valid(bits::SPEED, m.speed),
        front_wheel_speed: valid(bits::FRONT_WHEEL_SPEED, m.front_wheel_speed),
        rear_wheel_speed: valid(bits::REAR_WHEEL_SPEED, m.rear_wheel_speed),
        front_torque: valid(bits::FRONT_TORQUE, m.front_torque),
        rear_torque: valid(bits::REAR_TORQUE, m.rear_torque),
        slope: valid(bits::SLOPE, m.slope),
        acceleration: valid(bits::ACCELERATION, m.acceleration),
        mass: valid(bits::MASS, m.mass),
        spade_force_x: valid(bits::SPADE_FORCE_X, m.spade_force_x),
        spade_force_z: valid(bits::SPADE_FORCE_Z, m.spade_force_z),
        boom_moving: m.valid & bits::BOOM_MOVING != 0,
        articulation: valid(bits::ARTICULATION, m.articulation),
        yaw_rate: valid(bits::YAW_RATE, m.yaw_rate),
        brake: m.valid & bits::BRAKE != 0,
        lift_angle: valid(bits::LIFT_ANGLE, m.lift_angle),
        tilt_angle: valid(bits::TILT_ANGLE, m.tilt_angle),
        lift_head_pressure: valid(bits::LIFT_HEAD_PRESSURE, m.lift_head_pressure),
        lift_rod_pressure: valid(bits::LIFT_ROD_PRESSURE, m.lift_rod_pressure),
        truck: valid(bits::TRUCK, m.truck),
    }
}
