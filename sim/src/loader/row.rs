//! A sample of the sensors, with the truth.

use super::arm::Seen;
use super::payload::Payload;

/// True values at the time of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Forward speed [m/s].
    pub speed: f64,
    /// Front wheel speed [rad/s].
    pub front_wheel_speed: f64,
    /// Rear wheel speed [rad/s].
    pub rear_wheel_speed: f64,
    /// Height of the centre of gravity, with payload \[m\].
    pub cg_height: f64,
    /// Share of the static weight on the front axle, with payload.
    pub cg_ratio: f64,
    /// Slip stiffness.
    pub slip_stiffness: f64,
    /// Horizontal spading force \[N\].
    pub spade_force_x: f64,
    /// Road slope \[rad\].
    pub slope: f64,
    /// Mass in the bucket \[kg\].
    pub payload: f64,
    /// Rate of the speed along the road [m/s^2].
    pub acceleration: f64,
}

/// One sample. A missing measurement is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Time \[s\].
    pub time: f64,
    /// Forward speed [m/s].
    pub speed: f64,
    /// Front wheel speed [rad/s].
    pub front_wheel_speed: f64,
    /// Rear wheel speed [rad/s].
    pub rear_wheel_speed: f64,
    /// Front axle torque at the wheel [N m].
    pub front_torque: f64,
    /// Rear axle torque at the wheel [N m].
    pub rear_torque: f64,
    /// Road slope \[rad\].
    pub slope: f64,
    /// Specific force along the body axis, dv/dt + g sin(slope) [m/s^2].
    pub acceleration: f64,
    /// Mass with payload \[kg\]; `None` if it is the machine's.
    pub mass: Option<f64>,
    /// Horizontal spading force \[N\]; `None` if it is not measured.
    pub spade_force_x: Option<f64>,
    /// Vertical spading force \[N\].
    pub spade_force_z: Option<f64>,
    /// Whether the boom moves the payload.
    pub boom_moving: Option<bool>,
    /// Angle between front and rear body, positive turning left \[rad\]; `None` if it is not measured.
    pub articulation: Option<f64>,
    /// Yaw rate of the rear body, positive turning left [rad/s]; `None` if it is not measured.
    pub yaw_rate: Option<f64>,
    /// Whether friction brakes act; `None` if it is not reported.
    pub brake: Option<bool>,
    /// Readings of the lift arm's sensors; `None` without a lift arm.
    pub arm: Option<Seen>,
    /// The payload by the weighing system and the boom angles.
    pub payload: Payload,
    /// The truth.
    pub truth: Truth,
}
