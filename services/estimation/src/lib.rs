//! The algorithms: no I/O, no clock, no allocator, no unsafe code.
//!
//! Every estimator is a value with a `step`: one sample in, one answer out, always. Constructors
//! check their settings; after that, bad samples are refused or treated as missing and never reach
//! the state. Transcendental functions come from one software library ([`math`]), so that the same
//! data give the same bits on every platform.
#![no_std]

pub mod batch;
pub mod consistency;
pub mod dual;
pub mod ekf;
pub mod excavator;
pub mod kalman;
pub mod keys;
pub mod loader;
pub mod math;
pub mod model;
pub mod pair;
pub mod prediction;
pub mod rls;
pub mod root;
pub mod scalar;
pub mod sigma_points;
pub mod srukf;
mod time_base;
#[cfg(feature = "serde")]
mod written;

/// Half the width of a 95 % interval, in standard deviations.
pub const HALF_WIDTH_95: f64 = 1.96;

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
