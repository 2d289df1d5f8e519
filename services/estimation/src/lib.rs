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
pub mod prediction;
pub mod rls;
pub mod root;
pub mod scalar;
pub mod sigma_points;
pub mod srukf;
mod time_base;

/// A value with its standard deviation, in the unit of the value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quantity {
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}
