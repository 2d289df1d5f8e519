//! The algorithms: no I/O, no clock, no allocator, no unsafe code.
//!
//! Every estimator is a value with a `step`: one sample in, one answer out, always. Constructors
//! check their settings; after that, bad samples are refused or treated as missing and never reach
//! the state. Transcendental functions come from one software library ([`math`]), so that the same
//! data give the same bits on every platform.
//!
//! | module | what |
//! |---|---|
//! | [`excavator`], [`loader`] | the machines: samples in, estimates with a verdict out; their settings and keys |
//! | [`kalman`], [`ekf`], [`srukf`], [`rls`] | the filters, of any size |
//! | [`model`], [`images`], [`prediction`], [`sigma_points`], [`root`], [`scalar`] | what they are made of |
//! | [`consistency`] | whether innovations have their predicted size |
//! | [`dual`] | derivatives beside values |
//! | [`loads`] | estimates in; loads, trucks and days out |
//! | [`keys`] | tables of the keys of a description |
//! | [`math`] | roots, sines, exponentials: the same bits everywhere |
//!
//! ```
//! use estimation::excavator::keys::Description;
//! use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};
//!
//! let settings = Settings::of(&Description::default());
//! let columns = Columns { velocity: true, torque: true, posture: true, ..Columns::default() };
//! let mut estimator = SwingEstimator::new(&settings, Method::Auto, columns)?;
//! let sample = Sample {
//!     time: 0.0,
//!     velocity: Some(0.0),                             // rad/s
//!     torque: Some(0.0),                               // N m
//!     posture: [Some(0.9), Some(-2.1), Some(-1.0)],    // boom, arm, bucket, rad
//!     ..Sample::default()
//! };
//! let answer = estimator.step(&sample);
//! assert!(answer.inertia_std > 0.0 && !answer.flags.trusted(), "nothing has moved yet");
//! # Ok::<(), estimation::excavator::SettingsError>(())
//! ```
//!
//! ```
//! use estimation::loader::keys::Description;
//! use estimation::loader::{CgEstimator, Columns, Method, Sample, Settings};
//!
//! let settings = Settings::of(&Description::default(), Method::Full);
//! let mut estimator = CgEstimator::new(&settings, Method::Full, Columns::default())?;
//! let answer = estimator.step(&Sample {
//!     time: 0.0,
//!     speed: Some(1.0),                // m/s
//!     front_wheel_speed: Some(1.4),    // rad/s
//!     rear_wheel_speed: Some(1.4),
//!     front_torque: Some(3000.0),      // N m
//!     rear_torque: Some(3000.0),
//!     slope: Some(0.0),                // rad
//!     ..Sample::default()
//! });
//! assert!(answer.cg_ratio.std > 0.0 && !answer.trusted_ratio, "it has hardly driven");
//! # Ok::<(), estimation::loader::SettingsError>(())
//! ```
#![no_std]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod cadence;
mod common_error;
pub mod consistency;
pub mod dual;
pub mod ekf;
pub mod excavator;
pub mod images;
pub mod kalman;
pub mod keys;
mod leap;
mod linear;
pub mod loader;
pub mod loads;
pub mod math;
mod methods;
mod mixture;
pub mod model;
pub mod pair;
mod positive;
pub mod prediction;
mod quantum;
mod reasons;
mod repeats;
pub mod rls;
pub mod root;
mod rotations;
pub mod scalar;
pub mod sigma_points;
pub mod srukf;
mod time_base;
#[cfg(feature = "serde")]
mod written;

pub use common_error::CommonError;

/// Half the width of a 95 % interval, in standard deviations.
pub const HALF_WIDTH_95: f64 = 1.96;

/// Standard gravity (CGPM 1901) [m/s^2].
pub const GRAVITY: f64 = 9.806_65;

/// Pressure of a cylinder at which its largest force, and so the friction of its seals, is stated \[Pa\].
pub const FULL_PRESSURE: f64 = 20e6;

/// A value with its standard deviation, in the unit of the value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Quantity {
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

impl Quantity {
    /// Half the width of the 95 % interval, in the unit of the value.
    #[must_use]
    pub fn half_width(&self) -> f64 {
        HALF_WIDTH_95 * self.std
    }

    /// Whether the 95 % interval holds `truth`.
    #[must_use]
    pub fn holds(&self, truth: f64) -> bool {
        (self.value - truth).abs() <= self.half_width()
    }
}
