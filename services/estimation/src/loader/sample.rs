//! One row of loader signals, and which of them the source provides.

use super::keys::Description;

/// One row of signals. `None` is a missing value; a value that is not finite counts as missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Time of the measurement \[s\]; rows must increase.
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
    /// Measured road slope, uphill in the driving direction positive \[rad\].
    pub slope: Option<f64>,
    /// Specific force along the body axis, dv/dt + g sin(slope) [m/s^2].
    pub acceleration: Option<f64>,
    /// Mass of the machine with its load \[kg\]; held while missing.
    pub mass: Option<f64>,
    /// Force on the bucket tip, positive when it pushes the machine backward \[N\].
    pub spade_force_x: Option<f64>,
    /// Force on the bucket tip, positive when it pushes the machine down \[N\].
    pub spade_force_z: Option<f64>,
    /// The boom moves: a payload may be taken up or set down.
    pub boom_moving: bool,
    /// Angle between front and rear body, positive when the machine turns left \[rad\].
    pub articulation: Option<f64>,
    /// Yaw rate of the rear body, positive anticlockwise from above [rad/s].
    pub yaw_rate: Option<f64>,
    /// Friction brakes act.
    pub brake: bool,
    /// Angle of the lift arm to the machine's frame, 0 where it is level on level ground, up positive \[rad\].
    pub lift_angle: Option<f64>,
    /// Angle of the bucket relative to the lift arm, tip up positive \[rad\].
    pub tilt_angle: Option<f64>,
    /// Pressure at the head side of the lift cylinders, their mean \[Pa\].
    pub lift_head_pressure: Option<f64>,
    /// Pressure at the rod side of the lift cylinders, their mean \[Pa\].
    pub lift_rod_pressure: Option<f64>,
    /// Number of the truck that is loaded; a change begins the next truck.
    pub truck: Option<f64>,
}

/// Signals of the source that determine the states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Columns {
    /// An accelerometer along the body axis; without it `full` runs on 9 states instead of 12.
    pub acceleration: bool,
}

/// Largest plausible speed [m/s].
const SPEED_LIMIT: f64 = 200.0;
/// Largest plausible wheel speed [rad/s].
const WHEEL_SPEED_LIMIT: f64 = 1000.0;
/// Largest plausible specific force [m/s^2].
const ACCELERATION_LIMIT: f64 = 1000.0;
/// Largest plausible yaw rate [rad/s].
const YAW_LIMIT: f64 = 10.0;
/// Largest plausible slope [rad].
pub(super) const SLOPE_LIMIT: f64 = 0.8;
/// Largest plausible angle between front and rear body [rad].
const ARTICULATION_LIMIT: f64 = 1.5;
/// Largest plausible angle of a joint [rad]: a full turn.
const ANGLE_LIMIT: f64 = core::f64::consts::TAU;
/// Largest plausible pressure [Pa]: five times that of mobile hydraulics (40 MPa).
const PRESSURE_LIMIT: f64 = 2e8;
/// Largest plausible force on the bucket, over the weight.
const FORCE_LIMIT: f64 = 10.0;
/// Largest plausible pull of an axle, over the weight: tyres hold once the weight.
const PULL_LIMIT: f64 = 3.0;
/// Largest plausible factor between a mass and that of the machine.
const MASS_LIMIT: f64 = 20.0;

/// Largest plausible value of a signal of the described machine: a larger one is missing. `None` for a signal without such a limit.
#[must_use]
pub fn largest(signal: &str, described: &Description) -> Option<f64> {
    let weight = described.machine.mass * crate::GRAVITY;
    match signal {
        "speed" => Some(SPEED_LIMIT),
        "front_wheel_speed" | "rear_wheel_speed" => Some(WHEEL_SPEED_LIMIT),
        "front_torque" | "rear_torque" => {
            Some(PULL_LIMIT * weight * described.machine.wheel_radius)
        }
        "slope" => Some(SLOPE_LIMIT),
        "acceleration" => Some(ACCELERATION_LIMIT),
        "mass" => Some(described.machine.mass * MASS_LIMIT),
        "spade_force_x" | "spade_force_z" => Some(FORCE_LIMIT * weight),
        "articulation" => Some(ARTICULATION_LIMIT),
        "yaw_rate" => Some(YAW_LIMIT),
        "lift_angle" | "tilt_angle" => Some(ANGLE_LIMIT),
        pressure if pressure.ends_with("_pressure") => Some(PRESSURE_LIMIT),
        _ => None,
    }
}

impl Sample {
    /// The sample without values that no machine of this mass [kg] and wheel radius [m] can have.
    ///
    /// Gates test a measurement against its prediction. This test is for what has no prediction (inputs, first rows, restarts), and
    /// keeps every later number finite: a value that is not finite is not plausible either.
    pub(super) fn plausible(&self, mass: f64, radius: f64) -> Self {
        let within = |value: Option<f64>, limit: f64| value.filter(|v| v.abs() <= limit);
        let weight = mass * crate::GRAVITY;
        let (force, pull) = (FORCE_LIMIT * weight, PULL_LIMIT * weight);
        let mass_range = mass / MASS_LIMIT..=mass * MASS_LIMIT;
        Self {
            time: self.time,
            speed: within(self.speed, SPEED_LIMIT),
            front_wheel_speed: within(self.front_wheel_speed, WHEEL_SPEED_LIMIT),
            rear_wheel_speed: within(self.rear_wheel_speed, WHEEL_SPEED_LIMIT),
            front_torque: within(self.front_torque, pull * radius),
            rear_torque: within(self.rear_torque, pull * radius),
            slope: within(self.slope, SLOPE_LIMIT),
            acceleration: within(self.acceleration, ACCELERATION_LIMIT),
            mass: self.mass.filter(|m| mass_range.contains(m)),
            spade_force_x: within(self.spade_force_x, force),
            spade_force_z: within(self.spade_force_z, force),
            boom_moving: self.boom_moving,
            articulation: within(self.articulation, ARTICULATION_LIMIT),
            yaw_rate: within(self.yaw_rate, YAW_LIMIT),
            brake: self.brake,
            lift_angle: within(self.lift_angle, ANGLE_LIMIT),
            tilt_angle: within(self.tilt_angle, ANGLE_LIMIT),
            lift_head_pressure: within(self.lift_head_pressure, PRESSURE_LIMIT),
            lift_rod_pressure: within(self.lift_rod_pressure, PRESSURE_LIMIT),
            truck: within(self.truck, f64::MAX),
        }
    }
}
