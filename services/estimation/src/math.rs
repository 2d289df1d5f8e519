//! Elementary functions with the same bits on every platform (nalgebra's `libm-force`).
//!
//! Called by name, not as methods: once a test links `std`, `x.tanh()` would silently mean the
//! platform's own function.

use nalgebra::{ComplexField, RealField};

use crate::scalar::Scalar;

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

/// Cube root of a positive number.
#[inline]
pub fn cbrt(x: f64) -> f64 {
    exp(ln(x) / 3.0)
}

/// Euclidean norm; the standard deviation of a sum of independent parts.
#[inline]
pub fn norm(parts: &[f64]) -> f64 {
    sqrt(parts.iter().map(|x| x * x).sum::<f64>())
}

/// Up to this angle [rad], a steep road, the Taylor series of sine and cosine are exact to rounding.
pub(crate) const SHORT_SINE: f64 = 0.15;

/// Sine and cosine of an angle up to [`SHORT_SINE`].
#[inline(always)]
pub(crate) fn short_sin_cos<T: Scalar>(x: T) -> (T, T) {
    let s = x * x;
    let sine = horner(
        s,
        [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0],
    );
    let cosine = horner(
        s,
        [
            1.0,
            -0.5,
            1.0 / 24.0,
            -1.0 / 720.0,
            1.0 / 40_320.0,
            -1.0 / 3_628_800.0,
        ],
    );
    (x * sine, cosine)
}

/// Sine and cosine, to 2e-16.
#[inline(always)]
pub fn sin_cos(x: f64) -> (f64, f64) {
    if x.abs() <= SHORT_SINE {
        short_sin_cos(x)
    } else if x.abs() <= FEW_TURNS {
        folded_sin_cos(x)
    } else {
        ComplexField::sin_cos(x)
    }
}

/// Up to this angle [rad] the first part of pi/2 times the number of quarter turns is exact.
const FEW_TURNS: f64 = 1e5;
/// pi/2 in two parts, the first with 33 bits (fdlibm, `e_rem_pio2.c`).
const QUARTER_TURN: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
/// Added to a number, it leaves the nearest integer in the last bits.
const INTEGER: f64 = 1.5 * (1_u64 << 52) as f64;

/// The same, folded to an eighth of a turn, by the polynomials of fdlibm (`k_sin.c`, `k_cos.c`).
#[inline(never)]
fn folded_sin_cos(x: f64) -> (f64, f64) {
    let turns = x * core::f64::consts::FRAC_2_PI + INTEGER;
    let whole = turns - INTEGER;
    let r = (x - whole * QUARTER_TURN[0]) - whole * QUARTER_TURN[1];
    let s = r * r;
    let sine = horner(
        s,
        [
            -0.166_666_666_666_666_32,
            8.333_333_333_322_49e-3,
            -1.984_126_982_985_795e-4,
            2.755_731_370_707_006_8e-6,
            -2.505_076_025_340_686_3e-8,
            1.589_690_995_211_55e-10,
        ],
    );
    let cosine = horner(
        s,
        [
            4.166_666_666_666_66e-2,
            -1.388_888_888_887_411e-3,
            2.480_158_728_947_673e-5,
            -2.755_731_435_139_066_3e-7,
            2.087_572_321_298_175e-9,
            -1.135_964_755_778_819_5e-11,
        ],
    );
    let (sine, cosine) = (r + r * s * sine, 1.0 - (0.5 * s - s * s * cosine));
    match turns.to_bits() % 4 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Up to this argument [`per_atanh`] is a convergent of Gauss's continued fraction, good to 4e-15.
pub(crate) const SHORT_ATANH: f64 = 0.5;

/// u/atanh(u) for u up to [`SHORT_ATANH`].
#[inline(always)]
pub(crate) fn short_per_atanh<T: Scalar>(u: T) -> T {
    let s = u * u;
    let numerator = horner(
        s,
        [
            1.0,
            -3.12,
            3.7304347826086954,
            -2.1316770186335403,
            0.5890160183066362,
            -0.0692960021537219,
            0.0023098667384573966,
        ],
    );
    let denominator = horner(
        s,
        [
            1.0,
            -2.7866666666666666,
            2.8904347826086956,
            -1.3693416149068323,
            0.28994079401402056,
            -0.02213105421074192,
            0.0002685815488923002,
        ],
    );
    numerator / denominator
}

/// u/atanh(u) for 0 <= u < 1: how far a tyre that saturates is bent.
#[inline]
pub fn per_atanh(u: f64) -> f64 {
    if u.abs() <= SHORT_ATANH {
        short_per_atanh(u)
    } else {
        u / ComplexField::atanh(u)
    }
}

/// A polynomial by its coefficients, the constant first.
#[inline(always)]
fn horner<T: Scalar, const K: usize>(x: T, coefficients: [f64; K]) -> T {
    let mut sum = T::constant(coefficients[K - 1]);
    for k in (0..K - 1).rev() {
        sum = sum * x + coefficients[k];
    }
    sum
}

/// Nearest integer, halves away from zero.
#[inline]
pub fn round(x: f64) -> f64 {
    ComplexField::round(x)
}

impl Scalar for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn above(self, limit: Self, yes: Self, no: Self) -> Self {
        if self > limit { yes } else { no }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        ComplexField::sqrt(self)
    }
    fn sin(self) -> Self {
        ComplexField::sin(self)
    }
    fn cos(self) -> Self {
        ComplexField::cos(self)
    }
    fn exp(self) -> Self {
        ComplexField::exp(self)
    }
    fn ln(self) -> Self {
        ComplexField::ln(self)
    }
    fn tanh(self) -> Self {
        ComplexField::tanh(self)
    }
    #[inline(always)]
    fn per_atanh(self) -> Self {
        per_atanh(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        sin_cos(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        RealField::copysign(self, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_the_functions_through_many_turns() {
        for k in -200_000..200_000 {
            let near = f64::from(k) * 1e-4 + 1e-5;
            let far = f64::from(k) * 0.49 + 1e-5;
            let quarter = f64::from(k / 10) * core::f64::consts::FRAC_PI_2;
            for x in [near, far, quarter] {
                let (sine, cosine) = sin_cos(x);
                assert!((sine - x.sin()).abs() < 2e-16, "{x} {sine}");
                assert!((cosine - x.cos()).abs() < 2e-16, "{x} {cosine}");
            }
        }
        let (sine, cosine) = sin_cos(f64::NAN);
        assert!(sine.is_nan() && cosine.is_nan());
    }

    #[test]
    fn the_short_forms_are_the_functions() {
        for k in -3000..3000 {
            let x = f64::from(k) * 1e-4 + 1e-5;
            let (sine, cosine) = sin_cos(x);
            assert!((sine - x.sin()).abs() <= 4e-16 * x.abs() && (cosine - x.cos()).abs() <= 4e-16);
        }
        assert_eq!(per_atanh(0.0), 1.0);
        for k in 1..9999 {
            let u = f64::from(k) * 1e-4;
            assert!((per_atanh(u) * u.atanh() / u - 1.0).abs() < 4e-15, "{u}");
        }
    }
}
