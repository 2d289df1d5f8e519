//! A sample of all sensors, with the truth.

/// True values at the time of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Total inertia about the swing axis [kg m^2].
    pub inertia: f64,
    /// Viscous damping [N m s/rad].
    pub damping: f64,
    /// Coulomb friction [N m].
    pub friction: f64,
    /// Swing torque [N m].
    pub torque: f64,
    /// Swing velocity [rad/s].
    pub velocity: f64,
    /// Swing acceleration [rad/s^2].
    pub acceleration: f64,
    /// Mass in the bucket \[kg\].
    pub payload: f64,
    /// Whether the bucket is in the ground.
    pub digs: bool,
}

/// One sample of all sensors. `None` is a missing value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Time of the sample \[s\].
    pub time: f64,
    /// Swing velocity [rad/s].
    pub swing_velocity: Option<f64>,
    /// Swing angle since the beginning of the record \[rad\].
    pub swing_angle: Option<f64>,
    /// Swing torque [N m].
    pub swing_torque: Option<f64>,
    /// Angles of boom, arm and bucket \[rad\].
    pub posture: [Option<f64>; 3],
    /// Pitch (nose up) and roll (left side low) of the upper body \[rad\].
    pub inclination: [Option<f64>; 2],
    /// Pressures of the boom cylinder's head and rod side, and of the arm's \[Pa\].
    pub pressures: [Option<f64>; 4],
    /// True values.
    pub truth: Truth,
}
