//! Deviations of a machine from its description.

/// Deviations from the described machine; the default has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effects {
    /// Slope of the ground \[rad\], in a direction from the seed.
    pub slope: f64,
    /// Share of the drive torque that is effective while driving; braking torque is divided by it.
    pub efficiency: f64,
    /// Coulomb friction, relative to the described one.
    pub friction: f64,
    /// Friction at rest, relative to that in motion (Stribeck).
    pub stribeck: f64,
    /// Growth of the friction with the overturning moment: share at the moment of the full bucket.
    pub overturning: f64,
    /// Viscous damping, relative to the described one.
    pub damping: f64,
    /// Measured over true torque.
    pub torque_gain: f64,
    /// Offset of the measured torque, as a share of the largest one.
    pub torque_offset: f64,
    /// Time constant of the torque sensor \[s\].
    pub torque_lag: f64,
    /// Pure delay of the torque sensor \[s\].
    pub torque_delay: f64,
    /// Period of new torque values \[s\]; 0 for every sample.
    pub torque_period: f64,
    /// Delay of the gyro \[s\].
    pub gyro_delay: f64,
    /// Time constant of the gyro \[s\].
    pub gyro_lag: f64,
    /// Step of the gyro [rad/s].
    pub gyro_quantum: f64,
    /// Bias of the gyro [rad/s].
    pub gyro_bias: f64,
    /// Its change over a minute [rad/s].
    pub gyro_drift: f64,
    /// Frequency of the boom's lateral mode with the upper body fixed \[Hz\]; 0 for a rigid boom.
    pub boom_mode: f64,
    /// Share of the load that swings.
    pub pendulum: f64,
    /// Length of its pendulum \[m\].
    pub pendulum_length: f64,
    /// Share of the load that is spilled in every loaded swing, without a motion of the bucket.
    pub spill: f64,
    /// Mass that sticks in an emptied bucket, in full buckets; `None` draws 1 to 4 %.
    pub sticks: Option<f64>,
    /// Whether the bucket is emptied before the end of the swing.
    pub dumps_swinging: bool,
    /// Relative error of the described masses and inertias (of this size each, with random signs).
    pub mass_error: f64,
    /// Relative error of the described lengths, likewise.
    pub length_error: f64,
    /// Error of each joint angle \[rad\].
    pub angle_error: f64,
    /// Standard deviation of the time stamps \[s\].
    pub jitter: f64,
    /// Share of the largest torque that a relief valve cuts off.
    pub relief: f64,
    /// Whether there are an inclinometer and an encoder of the swing angle.
    pub inclinometer: bool,
    /// Friction of the cylinders' seals, relative to the described one.
    pub seals: f64,
    /// Zeros of the pressure sensors, relative to the usual ones.
    pub pressure_zero: f64,
    /// Quantisation step of the pressures \[Pa\].
    pub pressure_quantum: f64,
}

impl Default for Effects {
    fn default() -> Self {
        Self {
            slope: 0.0,
            efficiency: 1.0,
            friction: 1.0,
            stribeck: 1.0,
            overturning: 0.0,
            damping: 1.0,
            torque_gain: 1.0,
            torque_offset: 0.0,
            torque_lag: 0.0,
            torque_delay: 0.0,
            torque_period: 0.0,
            gyro_delay: 0.0,
            gyro_lag: 0.0,
            gyro_quantum: 0.0,
            gyro_bias: 0.0,
            gyro_drift: 0.0,
            boom_mode: 0.0,
            pendulum: 0.0,
            pendulum_length: 0.8,
            spill: 0.0,
            sticks: None,
            dumps_swinging: false,
            mass_error: 0.0,
            length_error: 0.0,
            angle_error: 0.0,
            jitter: 0.0,
            relief: 0.0,
            inclinometer: false,
            seals: 1.0,
            pressure_zero: 1.0,
            pressure_quantum: 0.0,
        }
    }
}

impl Effects {
    /// All effects small, as on a good machine.
    pub fn good() -> Self {
        Self {
            slope: 1f64.to_radians(),
            efficiency: 0.98,
            friction: 1.1,
            stribeck: 1.2,
            damping: 1.1,
            torque_gain: 1.015,
            torque_lag: 0.01,
            gyro_delay: 0.005,
            gyro_bias: 0.003,
            boom_mode: 5.0,
            pendulum: 0.05,
            mass_error: 0.01,
            length_error: 0.005,
            angle_error: 0.3f64.to_radians(),
            jitter: 0.001,
            ..Self::default()
        }
    }

    /// All effects as on most machines.
    pub fn usual() -> Self {
        Self {
            slope: 2.5f64.to_radians(),
            efficiency: 0.95,
            friction: 1.3,
            stribeck: 1.4,
            overturning: 0.1,
            damping: 1.2,
            torque_gain: 1.04,
            torque_lag: 0.02,
            gyro_delay: 0.01,
            gyro_bias: 0.006,
            boom_mode: 3.0,
            pendulum: 0.15,
            spill: 0.03,
            mass_error: 0.03,
            length_error: 0.01,
            angle_error: 0.8f64.to_radians(),
            jitter: 0.002,
            seals: 1.5,
            ..Self::default()
        }
    }

    /// All effects as on a machine in need of repair.
    pub fn worn() -> Self {
        Self {
            slope: 4f64.to_radians(),
            efficiency: 0.92,
            friction: 1.8,
            stribeck: 1.6,
            overturning: 0.2,
            damping: 1.4,
            torque_gain: 0.92,
            torque_lag: 0.04,
            gyro_delay: 0.02,
            gyro_bias: 0.01,
            boom_mode: 2.5,
            pendulum: 0.25,
            spill: 0.05,
            mass_error: 0.03,
            length_error: 0.01,
            angle_error: 1.5f64.to_radians(),
            jitter: 0.004,
            seals: 2.5,
            pressure_zero: 2.0,
            pressure_quantum: 200e3,
            ..Self::default()
        }
    }
}
