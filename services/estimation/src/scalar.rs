//! Number type of a model, so that one model serves every filter: `f64` for sigma points, [`crate::dual::Dual`]
//! for exact derivatives.
//!
//! The elementary functions come from nalgebra's `libm`, so they give the same bits on every platform. On a plain `f64`
//! call them as `Scalar::tanh(x)`: where `std` is linked, `x.tanh()` is the platform's own.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// Arithmetic, elementary functions, and selection instead of branches.
pub trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// A constant.
    fn constant(value: f64) -> Self;
    /// `yes` where `self > limit`, else `no`; both are evaluated.
    fn above(self, limit: Self, yes: Self, no: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine.
    fn sin(self) -> Self;
    /// Cosine.
    fn cos(self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// u/atanh(u), from 1 at u = 0 falling to 0 at 1.
    fn per_atanh(self) -> Self;

    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }

    /// The larger of two; of equal ones the second.
    fn max(self, other: Self) -> Self {
        self.above(other, self, other)
    }

    /// The smaller of two; of equal ones the first.
    fn min(self, other: Self) -> Self {
        self.above(other, other, self)
    }

    /// Magnitude; the derivative at zero is +1.
    fn abs(self) -> Self {
        let zero = Self::constant(0.0);
        zero.above(self, -self, self)
    }
}
