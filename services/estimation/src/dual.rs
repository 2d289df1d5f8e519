//! Forward dual numbers: a value and its derivatives along `D` directions, exact to rounding.
//!
//! A selection takes the derivative of the selected branch.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::scalar::Scalar;

/// A value with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const D: usize> {
    /// The value.
    pub value: f64,
    /// Its derivative along each direction.
    pub derivative: [f64; D],
}

impl<const D: usize> Dual<D> {
    /// A value with given derivatives.
    pub const fn new(value: f64, derivative: [f64; D]) -> Self {
        Self { value, derivative }
    }

    /// f(self) for a function with this value and this slope here.
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self::new(value, self.derivative.map(|d| slope * d))
    }

    #[inline(always)]
    fn combine(self, other: Self, value: f64, mine: f64, theirs: f64) -> Self {
        Self::new(
            value,
            core::array::from_fn(|i| mine * self.derivative[i] + theirs * other.derivative[i]),
        )
    }
}

impl<const D: usize> Add for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(
            self.value + other.value,
            core::array::from_fn(|i| self.derivative[i] + other.derivative[i]),
        )
    }
}

impl<const D: usize> Sub for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(
            self.value - other.value,
            core::array::from_fn(|i| self.derivative[i] - other.derivative[i]),
        )
    }
}

impl<const D: usize> Mul for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.combine(other, self.value * other.value, other.value, self.value)
    }
}

impl<const D: usize> Div for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let reciprocal = 1.0 / other.value;
        self.combine(other, value, reciprocal, -value * reciprocal)
    }
}

impl<const D: usize> Neg for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const D: usize> Add<f64> for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self::new(self.value + other, self.derivative)
    }
}

impl<const D: usize> Sub<f64> for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Self::new(self.value - other, self.derivative)
    }
}

impl<const D: usize> Mul<f64> for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}

impl<const D: usize> Div<f64> for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: f64) -> Self {
        self.chain(self.value / other, 1.0 / other)
    }
}

impl<const D: usize> Scalar for Dual<D> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::new(value, [0.0; D])
    }
    #[inline(always)]
    fn above(self, limit: Self, yes: Self, no: Self) -> Self {
        if self.value > limit.value { yes } else { no }
    }
    fn sqrt(self) -> Self {
        let root = Scalar::sqrt(self.value);
        self.chain(root, 0.5 / root)
    }
    fn sin(self) -> Self {
        self.chain(Scalar::sin(self.value), Scalar::cos(self.value))
    }
    fn cos(self) -> Self {
        self.chain(Scalar::cos(self.value), -Scalar::sin(self.value))
    }
    fn exp(self) -> Self {
        let value = Scalar::exp(self.value);
        self.chain(value, value)
    }
    fn ln(self) -> Self {
        self.chain(Scalar::ln(self.value), 1.0 / self.value)
    }
    fn tanh(self) -> Self {
        let value = Scalar::tanh(self.value);
        self.chain(value, 1.0 - value * value)
    }
    fn per_atanh(self) -> Self {
        let u = self.value;
        let value = Scalar::per_atanh(u);
        // Below, the difference cancels; -2u/3 is exact to rounding there.
        let slope = if u.abs() < 1e-6 {
            -2.0 / 3.0 * u
        } else {
            value / u * (1.0 - value / (1.0 - u * u))
        };
        self.chain(value, slope)
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = Scalar::sin_cos(self.value);
        (self.chain(sine, cosine), self.chain(cosine, -sine))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x^2 tanh(x)/(1 + x) against its derivative on paper.
    #[test]
    fn derivative_is_exact() {
        let x = Dual::new(0.7, [1.0]);
        let y = x * x * x.tanh() / (x + 1.0);
        let (v, t) = (0.7_f64, 0.7_f64.tanh());
        let slope = ((2.0 * v * t + v * v * (1.0 - t * t)) * (1.0 + v) - v * v * t)
            / ((1.0 + v) * (1.0 + v));
        assert!(
            (y.derivative[0] - slope).abs() < 1e-15,
            "{} {slope}",
            y.derivative[0]
        );
    }

    /// A function on dual numbers and the same on real ones.
    type Pair = (fn(Dual<1>) -> Dual<1>, fn(f64) -> f64);

    #[test]
    fn elementary_functions_have_their_slopes() {
        let at = |x: f64| Dual::new(x, [1.0]);
        let central = |f: fn(f64) -> f64, x: f64| (f(x + 1e-6) - f(x - 1e-6)) / 2e-6;
        let pairs: [Pair; 7] = [
            (Scalar::sin, Scalar::sin),
            (Scalar::cos, Scalar::cos),
            (Scalar::exp, Scalar::exp),
            (Scalar::ln, Scalar::ln),
            (Scalar::sqrt, Scalar::sqrt),
            (Scalar::tanh, Scalar::tanh),
            (Scalar::per_atanh, Scalar::per_atanh),
        ];
        for (dual, real) in pairs {
            // Central differences of step 1e-6 are good to some 1e-9.
            assert!((dual(at(0.4)).derivative[0] - central(real, 0.4)).abs() < 1e-8);
        }
    }

    #[test]
    fn magnitude_has_slope_one_at_zero() {
        assert_eq!(Dual::new(0.0, [1.0]).abs().derivative, [1.0]);
        assert_eq!(Dual::new(-0.5, [1.0]).abs().derivative, [-1.0]);
    }
}
