//! The machine in the process model, and the road under it.

use crate::loader::settings::{LoadTransfer, Settings};
use crate::scalar::Scalar;

/// The machine in the process model.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WheelDynamics {
    /// Gravity [m/s^2].
    pub gravity: f64,
    /// Mass \[kg\].
    pub mass: f64,
    /// Mass of the empty machine, to which the tyre parameters refer \[kg\].
    pub empty_mass: f64,
    /// Nominal rolling radius \[m\].
    pub wheel_radius: f64,
    /// Axle inertia [kg m^2].
    pub axle_inertia: f64,
    /// Axle distance \[m\].
    pub wheelbase: f64,
    /// Front axle to bucket tip \[m\].
    pub bucket_reach: f64,
    /// Rolling resistance per load.
    pub rolling_resistance: f64,
    /// Friction limit; infinite for the linear tyre.
    pub friction: f64,
    /// Load sensitivity of the rolling radius.
    pub radius_load_sensitivity: f64,
    /// Smallest speed in a slip denominator, v_min [m/s].
    pub minimum_speed: f64,
    /// Sign of the load transfer.
    pub load_transfer: LoadTransfer,
    /// Differences between the tyres of the axles.
    pub tyres: Tyres,
}

impl WheelDynamics {
    /// The empty machine of the settings, which must have been checked.
    pub(in crate::loader) fn of(settings: &Settings) -> Self {
        let (machine, keys) = (&settings.machine, &settings.estimator);
        Self {
            gravity: settings.gravity(),
            mass: machine.mass,
            empty_mass: machine.mass,
            wheel_radius: machine.wheel_radius,
            axle_inertia: machine.axle_inertia,
            wheelbase: machine.wheelbase,
            bucket_reach: machine.bucket_reach,
            rolling_resistance: machine.rolling_resistance,
            friction: settings.friction(),
            radius_load_sensitivity: if settings.real_tyre() {
                machine.radius_load_sensitivity
            } else {
                0.0
            },
            minimum_speed: keys.v_min,
            load_transfer: keys.load_transfer,
            tyres: Tyres::new(machine.stiffness_ratio, machine.stiffness_load_exponent),
        }
    }
}

/// Difference of an axle's slip stiffness from K, as identified by a calibration (`heft calibrate`): K_i = K q_i (F_zi/F_0)^-p with
/// half the weight F_0 of the empty machine.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tyres {
    /// q_f and q_r = 1/q_f; their ratio is that of the stiffnesses.
    pub gains: [f64; 2],
    /// p.
    pub load_exponent: f64,
}

impl Tyres {
    /// Equal on both axles, under every load.
    pub const ALIKE: Self = Self {
        gains: [1.0; 2],
        load_exponent: 0.0,
    };

    /// From the ratio of the stiffnesses, front over rear, and p.
    #[must_use]
    pub fn new(ratio: f64, load_exponent: f64) -> Self {
        let gain = crate::math::sqrt(ratio);
        Self {
            gains: [gain, 1.0 / gain],
            load_exponent,
        }
    }
}

/// Sine and cosine of the true slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Road<T> {
    /// sin th.
    pub sine: T,
    /// cos th.
    pub cosine: T,
}

impl<T: Scalar> Road<T> {
    /// The road under a slope.
    pub fn of(slope: T) -> Self {
        let (sine, cosine) = slope.sin_cos();
        Self { sine, cosine }
    }
}
