//! A guess of everything that the residuals depend on.

use super::GRAVITY;
use super::drive::Drive;

/// The machine, its sensors and the load, as one guess.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess {
    /// Mass with load [kg].
    pub mass: f64,
    /// Mass of the empty machine, for which the tyres are described [kg].
    pub empty_mass: f64,
    /// Share of the static weight in front.
    pub ratio: f64,
    /// Height of the centre of gravity [m].
    pub height: f64,
    /// Nominal rolling radius [m].
    pub radius: f64,
    /// Relative errors of the radii.
    pub radius_errors: [f64; 2],
    /// Load sensitivity of the radii.
    pub load_sensitivity: f64,
    /// Slip stiffness.
    pub stiffness: f64,
    /// Stiffness in front over that behind.
    pub stiffness_ratio: f64,
    /// How the stiffness falls with the load.
    pub load_exponent: f64,
    /// Limit of friction.
    pub friction: f64,
    /// Measured over true torque, per axle.
    pub torque_gains: [f64; 2],
    /// Rolling resistance.
    pub rolling_resistance: f64,
    /// Slope measured where there is none [rad].
    pub slope_bias: f64,
    /// Specific force measured where there is none [m/s^2].
    pub acceleration_offset: f64,
    /// How late the slope comes [s].
    pub slope_delay: f64,
    /// Share of the acceleration that the slope sensor follows.
    pub slope_sensitivity: f64,
    /// How late the speed comes [s].
    pub speed_delay: f64,
    /// How late the torques come [s].
    pub torque_delay: f64,
    /// Relaxation length of the tyres [m].
    pub relaxation_length: f64,
    /// Moment of inertia of an axle [kg m^2].
    pub axle_inertia: f64,
    /// Distance of the axles [m].
    pub wheelbase: f64,
    /// Scatter of the residuals.
    pub scatter: Scatter,
}

impl Guess {
    /// Specific force by the accelerometer in row `k` [m/s^2]; not finite where it is missing.
    pub fn force(&self, drive: &Drive, k: usize) -> f64 {
        drive.acceleration[k] - self.acceleration_offset
    }

    /// Slope of the road by what an inclinometer without delay shows, and the specific force.
    pub fn prompt_slope(&self, shown: f64, force: f64) -> f64 {
        let level = shown - self.slope_bias;
        if force.is_finite() {
            (level - self.slope_sensitivity * force / GRAVITY) / (1.0 - self.slope_sensitivity)
        } else {
            level
        }
    }

    /// What the delay of the slope adds to the integral of gravity along the road, per radian of change [m/s].
    pub fn delayed(&self) -> f64 {
        GRAVITY * self.slope_delay / (1.0 - self.slope_sensitivity)
    }
}

/// Standard deviations of the residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Between the speeds that the wheels show [m/s].
    pub wheels: f64,
    /// Between them and the measured speed [m/s].
    pub speed: f64,
    /// Between accelerometer and torques [m/s^2].
    pub force: f64,
    /// Between the change of the wheels' speed from window to window and the specific force along the slope [m/s].
    pub motion: f64,
    /// Between the slopes of a section there and back [rad].
    pub way: f64,
}
