//! One row of loader signals, and which of them the source has at all.

/// One row of signals; `None` is a missing sample, a value that is not finite counts as missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Time of the measurement [s]; rows must increase.
    pub time: f64,
    /// Forward speed of the body [m/s].
    pub speed: Option<f64>,
    /// Speed of the front wheels [rad/s].
    pub front_wheel_speed: Option<f64>,
    /// Speed of the rear wheels [rad/s].
    pub rear_wheel_speed: Option<f64>,
    /// Torque on the front axle at the wheels, total, driving positive [N m].
    pub front_torque: Option<f64>,
    /// Torque on the rear axle at the wheels, total, driving positive [N m].
    pub rear_torque: Option<f64>,
    /// Measured road slope, uphill in the driving direction positive [rad].
    pub slope: Option<f64>,
    /// Specific force along the body axis, dv/dt + g sin(slope) [m/s^2].
    pub acceleration: Option<f64>,
    /// Mass of the machine with its load [kg]; held while missing.
    pub mass: Option<f64>,
    /// Force on the bucket tip, positive when it pushes the machine backward [N].
    pub spade_force_x: Option<f64>,
    /// Force on the bucket tip, positive when it pushes the machine down [N].
    pub spade_force_z: Option<f64>,
    /// The boom moves: a payload may be taken up or set down.
    pub boom_moving: bool,
}

/// The optional signals that the source has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Columns {
    /// An accelerometer along the body axis; without it `full` runs on 8 states instead of 10.
    pub acceleration: bool,
    /// Weighing.
    pub mass: bool,
    /// Measured forces on the bucket tip.
    pub spade_force: bool,
    /// A signal that says when the boom moves.
    pub boom_moving: bool,
}

/// A present and finite value, or nothing.
pub(super) fn finite(value: Option<f64>) -> Option<f64> {
    value.filter(|v| v.is_finite())
}
