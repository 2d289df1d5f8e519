//! Values of all quantities that the residuals depend on.

use super::GRAVITY;
use super::drive::Drive;

/// Machine, sensors and load at one place of the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess {
    /// Mass with load [kg].
    pub mass: f64,
    /// Mass of the empty machine, for which the tyres are described [kg].
    pub empty_mass: f64,
    /// Front share of the static weight.
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
    /// Front over rear stiffness.
    pub stiffness_ratio: f64,
    /// Exponent by which the stiffness falls with the load.
    pub load_exponent: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Share w of a brush's curve of the slip (Pacejka, ch. 3); the rest is that of the estimator.
    pub brush: f64,
    /// Variance V of an axle's load on bumps, over the square of its load F_0 = m_0 g/2.
    pub load_variance: f64,
    /// Measured over true torque, per axle.
    pub torque_gains: [f64; 2],
    /// Rolling resistance.
    pub rolling_resistance: f64,
    /// Measured slope on level ground [rad].
    pub slope_bias: f64,
    /// Measured specific force at rest on level ground [m/s^2].
    pub acceleration_offset: f64,
    /// Delay of the slope [s].
    pub slope_delay: f64,
    /// Sensitivity of the slope sensor to acceleration.
    pub slope_sensitivity: f64,
    /// Pitch of the chassis on its tyres by the specific force, with this load [rad per g].
    pub squat: f64,
    /// Delay of the speed [s].
    pub speed_delay: f64,
    /// Delay of the torques [s].
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
    /// Specific force from the accelerometer in row `k` [m/s^2]; not finite where it is missing. It pitches with the chassis, and so
    /// shows a part of gravity.
    pub fn force(&self, drive: &Drive, k: usize) -> f64 {
        (drive.acceleration[k] - self.acceleration_offset) / self.reading(1.0)
    }

    /// Difference of readings of the accelerometer for one of specific forces [m/s^2].
    pub fn reading(&self, force: f64) -> f64 {
        force * (1.0 + self.squat)
    }

    /// Slope of the road from the reading of an inclinometer without delay, and the specific force.
    pub fn prompt_slope(&self, shown: f64, force: f64) -> f64 {
        let level = shown - self.slope_bias;
        if force.is_finite() {
            let pulled = (self.slope_sensitivity + self.squat) * force / GRAVITY;
            (level - pulled) / (1.0 - self.slope_sensitivity)
        } else {
            level
        }
    }

    /// Effect of the slope's delay on the integral of gravity along the road, per radian of change [m/s].
    pub fn delayed(&self) -> f64 {
        GRAVITY * self.slope_delay / (1.0 - self.slope_sensitivity)
    }
}

/// Standard deviations of the residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Between the speeds from the two axles' wheels [m/s].
    pub wheels: f64,
    /// Between these and the measured speed [m/s].
    pub speed: f64,
    /// Between accelerometer and torques [m/s^2].
    pub force: f64,
    /// Between the change of the wheels' speed from window to window and the specific force along the slope [m/s].
    pub motion: f64,
    /// Between the slopes of a section out and back [rad].
    pub path: f64,
}
