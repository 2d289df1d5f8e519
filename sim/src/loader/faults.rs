//! The channels of faults, and their application to a row.

use super::row::Row;
use crate::fault::Injector;

/// The channels that a [`Fault`](crate::fault::Fault) can name.
pub const CHANNELS: &[&str] = &[
    "time",
    "speed",
    "front_wheel_speed",
    "rear_wheel_speed",
    "front_torque",
    "rear_torque",
    "slope",
    "acceleration",
    "mass",
    "spade_force_x",
    "spade_force_z",
    "lift_angle",
    "tilt_angle",
    "lift_head_pressure",
    "lift_rod_pressure",
];

/// Applies the faults to a row.
pub(super) fn damage(row: &mut Row, faults: &mut Injector) {
    let time = row.time;
    let required = [
        &mut row.time,
        &mut row.speed,
        &mut row.front_wheel_speed,
        &mut row.rear_wheel_speed,
        &mut row.front_torque,
        &mut row.rear_torque,
        &mut row.slope,
        &mut row.acceleration,
    ];
    let count = required.len();
    for (channel, value) in required.into_iter().enumerate() {
        *value = faults
            .apply(channel, time, Some(*value))
            .unwrap_or(f64::NAN);
    }
    for (channel, value) in [
        &mut row.mass,
        &mut row.spade_force_x,
        &mut row.spade_force_z,
    ]
    .into_iter()
    .enumerate()
    {
        *value = faults.apply(count + channel, time, *value);
    }
    let of_arm = row.arm.iter_mut().flat_map(|arm| {
        [
            &mut arm.lift_angle,
            &mut arm.tilt_angle,
            &mut arm.head_pressure,
            &mut arm.rod_pressure,
        ]
    });
    for (channel, value) in of_arm.enumerate() {
        let seen = faults.apply(count + 3 + channel, time, Some(*value));
        *value = seen.unwrap_or(f64::NAN);
    }
}
