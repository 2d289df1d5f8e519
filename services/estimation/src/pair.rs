//! Two numbers at once: the two sigma points of an axis pass through the model together, one in each half of a vector register.
//!
//! The result in each lane is bit for bit that of the single number.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::math;
use crate::scalar::Scalar;

/// Two numbers that undergo the same operations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(16))]
pub struct Pair(pub [f64; 2]);

impl Pair {
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let Self([a, b]) = self;
        Self([f(a), f(b)])
    }

    /// Whether both magnitudes are at most `limit`.
    #[inline(always)]
    fn within(self, limit: f64) -> bool {
        let Self([a, b]) = self;
        a.abs() <= limit && b.abs() <= limit
    }
}

macro_rules! operator {
    ($operator:ident, $name:ident, $symbol:tt) => {
        impl $operator for Pair {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let (Self([a, b]), Self([c, d])) = (self, other);
                Self([a $symbol c, b $symbol d])
            }
        }

        impl $operator<f64> for Pair {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                self.map(|a| a $symbol other)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Pair {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl Scalar for Pair {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; 2])
    }
    #[inline(always)]
    fn above(self, limit: Self, yes: Self, no: Self) -> Self {
        let lane = |i: usize| {
            if self.0[i] > limit.0[i] {
                yes.0[i]
            } else {
                no.0[i]
            }
        };
        Self([lane(0), lane(1)])
    }
    fn sqrt(self) -> Self {
        self.map(Scalar::sqrt)
    }
    fn sin(self) -> Self {
        self.map(Scalar::sin)
    }
    fn cos(self) -> Self {
        self.map(Scalar::cos)
    }
    fn exp(self) -> Self {
        self.map(Scalar::exp)
    }
    fn ln(self) -> Self {
        self.map(Scalar::ln)
    }
    fn tanh(self) -> Self {
        let Self([a, b]) = self;
        // The argument of tanh is equal at both points of most axes.
        if a.to_bits() == b.to_bits() {
            Self::constant(Scalar::tanh(a))
        } else {
            self.map(Scalar::tanh)
        }
    }
    #[inline(always)]
    fn per_atanh(self) -> Self {
        if self.within(math::SHORT_ATANH) {
            math::short_per_atanh(self)
        } else {
            self.map(math::per_atanh)
        }
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        if self.within(math::SHORT_SINE) {
            return math::short_sin_cos(self);
        }
        let [a, b] = self.0.map(math::sin_cos);
        (Self([a.0, b.0]), Self([a.1, b.1]))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(Scalar::abs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lane_has_the_bits_that_it_has_alone() {
        let numbers = [-1.7, -0.4, -0.01, 0.0, 0.02, 0.149, 0.3, 0.499, 0.6, 0.99];
        for a in numbers {
            for b in numbers {
                let pair = Pair([a, b]);
                let (sine, cosine) = pair.sin_cos();
                assert_eq!(sine.0, [a, b].map(|x| math::sin_cos(x).0));
                assert_eq!(cosine.0, [a, b].map(|x| math::sin_cos(x).1));
                let used = pair.abs().min(Pair::constant(0.995));
                assert_eq!(used.per_atanh().0, used.0.map(math::per_atanh));
                assert_eq!(
                    (pair / 3.0 - pair * pair).0,
                    [a, b].map(|x| x / 3.0 - x * x)
                );
                assert_eq!(pair.max(-pair).0, [a.abs(), b.abs()]);
            }
        }
    }
}
