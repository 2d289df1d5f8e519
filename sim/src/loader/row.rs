//! What the sensors tell, with the truth.

use super::arm::Seen;
use super::payload::Payload;

/// What is true at the time of a row.
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

/// One sample. A measurement that is missing is not a number.
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
    /// Mass with payload \[kg\], where it is not simply the machine's.
    pub mass: Option<f64>,
    /// Horizontal spading force \[N\]; none if it is not measured.
    pub spade_force_x: Option<f64>,
    /// Vertical spading force \[N\].
    pub spade_force_z: Option<f64>,
    /// Whether the boom moves the payload.
    pub boom_moving: Option<bool>,
    /// Angle between front and rear body, positive turning left \[rad\]; none if it is not measured.
    pub articulation: Option<f64>,
    /// Yaw rate of the rear body, positive turning left [rad/s]; none if it is not measured.
    pub yaw_rate: Option<f64>,
    /// Whether friction brakes act; none if nobody says.
    pub brake: Option<bool>,
    /// What the sensors of the lift arm show; none if it has none.
    pub arm: Option<Seen>,
    /// What the weighing system and the boom angles say of the payload.
    pub payload: Payload,
    /// The truth.
    pub truth: Truth,
}
