//! The machine, its sensors and the prior: what is known before the first row. SI units.

use super::{SettingsError, not_negative, positive, require};

/// The machine, from its data sheet and its calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Machine {
    /// Mass with its load [kg]; a measured mass overrides it.
    pub mass: f64,
    /// Nominal rolling radius r of the wheels [m].
    pub wheel_radius: f64,
    /// Moment of inertia I of one axle with its wheels [kg m^2].
    pub axle_inertia: f64,
    /// Distance l between the axles [m].
    pub wheelbase: f64,
    /// Distance l_c from the front axle to the bucket tip [m].
    pub bucket_reach: f64,
    /// Rolling resistance f per axle load.
    pub rolling_resistance: f64,
    /// Wheel torque over motor torque. The samples carry wheel torques, so the estimator does not use it.
    pub gear_ratio: f64,
    /// Friction limit mu of tyre on ground; infinite for the paper's linear tyre.
    pub friction: f64,
    /// Relative decrease rho of the rolling radius when an axle load grows by half the weight.
    pub radius_load_sensitivity: f64,
    /// Standard deviation of rho: it cannot be learnt on line and widens the reported interval.
    pub radius_load_sensitivity_std: f64,
    /// Slip stiffness of the front axle over that of the rear under equal loads.
    pub stiffness_ratio: f64,
    /// Standard deviation of the ratio of the axles' slip stiffnesses, front over rear: tyres differ by wear, pressure, make,
    /// which cannot be learnt on line and widens the reported interval.
    pub stiffness_ratio_std: f64,
    /// p, where the slip stiffness falls with the axle load as F_z^-p.
    pub stiffness_load_exponent: f64,
    /// Standard deviation of p, where the slip stiffness falls with the axle load as F_z^-p: the load transfer, and with it the
    /// height, then seems (1 - p) times as large. It cannot be learnt on line and widens the reported interval.
    pub stiffness_load_exponent_std: f64,
    /// Relaxation length of the tyres [m].
    pub relaxation_length: f64,
}

impl Default for Machine {
    fn default() -> Self {
        Self {
            mass: 4700.0,
            wheel_radius: 0.55,
            axle_inertia: 3.33,
            wheelbase: 2.3,
            bucket_reach: 1.7,
            rolling_resistance: 0.02,
            gear_ratio: 20.0,
            friction: 0.8,
            radius_load_sensitivity: 0.01,
            radius_load_sensitivity_std: 0.001,
            stiffness_ratio: 1.0,
            stiffness_ratio_std: 0.05,
            stiffness_load_exponent: 0.0,
            stiffness_load_exponent_std: 0.1,
            relaxation_length: 0.10,
        }
    }
}

impl Machine {
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        positive("machine.mass", self.mass)?;
        positive("machine.wheel_radius", self.wheel_radius)?;
        positive("machine.axle_inertia", self.axle_inertia)?;
        positive("machine.wheelbase", self.wheelbase)?;
        not_negative("machine.bucket_reach", self.bucket_reach)?;
        not_negative("machine.rolling_resistance", self.rolling_resistance)?;
        positive("machine.gear_ratio", self.gear_ratio)?;
        require(
            "machine.friction",
            "positive",
            self.friction,
            self.friction > 0.0,
        )?;
        let rho = self.radius_load_sensitivity;
        require(
            "machine.radius_load_sensitivity",
            "within -0.2 .. 0.2",
            rho,
            rho.abs() <= 0.2,
        )?;
        not_negative(
            "machine.radius_load_sensitivity_std",
            self.radius_load_sensitivity_std,
        )?;
        positive("machine.stiffness_ratio", self.stiffness_ratio)?;
        let p = self.stiffness_load_exponent;
        require(
            "machine.stiffness_load_exponent",
            "within -1 .. 1",
            p,
            p.abs() <= 1.0,
        )?;
        not_negative("machine.stiffness_ratio_std", self.stiffness_ratio_std)?;
        not_negative(
            "machine.stiffness_load_exponent_std",
            self.stiffness_load_exponent_std,
        )?;
        not_negative("machine.relaxation_length", self.relaxation_length)
    }
}

/// Standard deviations of the sensors, per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sensors {
    /// Speed [m/s].
    pub speed_std: f64,
    /// Wheel speeds [rad/s].
    pub wheel_speed_std: f64,
    /// Slope [rad]. It acts on the speed: the process noise of the speed is at least what it makes of a step.
    pub slope_std: f64,
    /// Specific force [m/s^2].
    pub acceleration_std: f64,
    /// Measured over true torque, front and rear.
    pub torque_gains: [f64; 2],
    /// Relative error of each axle's torque; their ratio cannot be learnt on line and widens the interval.
    pub torque_gain_std: f64,
    /// Delay of the speed against the other signals [s].
    pub speed_delay: f64,
    /// Standard deviation of that delay before the first row [s]; `full` learns it.
    pub speed_delay_std: f64,
}

impl Default for Sensors {
    fn default() -> Self {
        Self {
            speed_std: 0.02,
            wheel_speed_std: 0.002,
            slope_std: 0.002,
            acceleration_std: 0.05,
            torque_gains: [1.0; 2],
            torque_gain_std: 0.005,
            speed_delay: 0.0,
            speed_delay_std: 0.08,
        }
    }
}

impl Sensors {
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        positive("sensors.speed_std", self.speed_std)?;
        positive("sensors.wheel_speed_std", self.wheel_speed_std)?;
        not_negative("sensors.slope_std", self.slope_std)?;
        positive("sensors.acceleration_std", self.acceleration_std)?;
        positive("sensors.front_torque_gain", self.torque_gains[0])?;
        positive("sensors.rear_torque_gain", self.torque_gains[1])?;
        not_negative("sensors.torque_gain_std", self.torque_gain_std)?;
        not_negative("sensors.speed_delay", self.speed_delay)?;
        positive("sensors.speed_delay_std", self.speed_delay_std)
    }
}

/// What is believed before the first row.
///
/// The standard deviations are those of a machine off the line: the error of the initial guess (K 2, h 0.10 m, lam 0.05) and,
/// on top of it, the spread from machine to machine (1.5, 0.08 m, 0.03). With the guess alone the interval of the height
/// holds the truth in 89 % of the drives in which it cannot be learnt.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Prior {
    /// Slip stiffness K.
    pub slip_stiffness: f64,
    /// Its standard deviation.
    pub slip_stiffness_std: f64,
    /// Height of the centre of gravity [m].
    pub cg_height: f64,
    /// Its standard deviation [m].
    pub cg_height_std: f64,
    /// Share of the static weight on the front axle.
    pub cg_ratio: f64,
    /// Its standard deviation.
    pub cg_ratio_std: f64,
    /// Standard deviation of the speed at the start [m/s].
    pub speed_std: f64,
    /// Standard deviation of the wheel speeds at the start [rad/s].
    pub wheel_speed_std: f64,
    /// Relative errors of the rolling radii, front and rear.
    pub radius_errors: [f64; 2],
    /// Standard deviation of the relative error of each rolling radius; 5e-4 when the radii are calibrated.
    pub radius_std: f64,
    /// Unknown part of the spade force [N].
    pub spade_force_x_std: f64,
    /// Bias of the slope sensor, true slope = measured - bias [rad].
    pub slope_bias: f64,
    /// Its standard deviation [rad].
    pub slope_bias_std: f64,
}

impl Prior {
    /// A machine off the line.
    pub const TYPICAL: Self = Self {
        slip_stiffness: 19.0,
        slip_stiffness_std: 2.5,
        cg_height: 0.9,
        cg_height_std: 0.13,
        cg_ratio: 0.45,
        cg_ratio_std: 0.06,
        speed_std: 0.05,
        wheel_speed_std: 0.05,
        radius_errors: [0.0; 2],
        radius_std: 0.005,
        spade_force_x_std: 300.0,
        slope_bias: 0.0,
        slope_bias_std: 0.01,
    };
}

impl Default for Prior {
    fn default() -> Self {
        Self::TYPICAL
    }
}

impl Prior {
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        positive("prior.slip_stiffness", self.slip_stiffness)?;
        positive("prior.slip_stiffness_std", self.slip_stiffness_std)?;
        positive("prior.cg_height", self.cg_height)?;
        positive("prior.cg_height_std", self.cg_height_std)?;
        let ratio = self.cg_ratio;
        require(
            "prior.cg_ratio",
            "between 0 and 1",
            ratio,
            ratio > 0.0 && ratio < 1.0,
        )?;
        positive("prior.cg_ratio_std", self.cg_ratio_std)?;
        positive("prior.speed_std", self.speed_std)?;
        positive("prior.wheel_speed_std", self.wheel_speed_std)?;
        for (key, error) in ["prior.front_radius_error", "prior.rear_radius_error"]
            .into_iter()
            .zip(self.radius_errors)
        {
            require(key, "within -0.2 .. 0.2", error, error.abs() <= 0.2)?;
        }
        positive("prior.radius_std", self.radius_std)?;
        positive("prior.spade_force_std", self.spade_force_x_std)?;
        let bias = self.slope_bias;
        require(
            "prior.slope_bias",
            "within -0.5 .. 0.5",
            bias,
            bias.abs() <= 0.5,
        )?;
        positive("prior.slope_bias_std", self.slope_bias_std)
    }
}
