//! Elementary functions with the same bits on every platform (nalgebra's `libm-force`).
//!
//! Called by name, not as methods: once a test links `std`, `x.tanh()` would silently mean the
//! platform's own function.

use nalgebra::ComplexField;

/// Exponential.
#[inline]
pub fn exp(x: f64) -> f64 {
    ComplexField::exp(x)
}

/// Natural logarithm.
#[inline]
pub fn ln(x: f64) -> f64 {
    ComplexField::ln(x)
}

/// Hyperbolic tangent.
#[inline]
pub fn tanh(x: f64) -> f64 {
    ComplexField::tanh(x)
}

/// Square root.
#[inline]
pub fn sqrt(x: f64) -> f64 {
    ComplexField::sqrt(x)
}

/// Sine and cosine.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    ComplexField::sin_cos(x)
}

/// Nearest integer, halves away from zero.
#[inline]
pub fn round(x: f64) -> f64 {
    ComplexField::round(x)
}
