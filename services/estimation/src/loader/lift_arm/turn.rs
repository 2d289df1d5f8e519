//! Angle as sine and cosine, computed once a row. Adding an angle of known sine and cosine needs no further series.

use crate::math::sin_cos;

/// Sine and cosine of an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Turn {
    pub sine: f64,
    pub cosine: f64,
}

impl Turn {
    /// Of an angle [rad].
    pub fn of(angle: f64) -> Self {
        let (sine, cosine) = sin_cos(angle);
        Self { sine, cosine }
    }

    /// Sum with an angle [rad].
    pub fn by(self, angle: f64) -> Self {
        if angle == 0.0 {
            self
        } else {
            self.and(Self::of(angle))
        }
    }

    /// Sum of both angles.
    pub fn and(self, other: Self) -> Self {
        Self {
            sine: self.sine * other.cosine + self.cosine * other.sine,
            cosine: self.cosine * other.cosine - self.sine * other.sine,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_add_up() {
        for (angle, more) in [(0.3, 0.0), (-0.6, 0.009), (1.2, -2.0)] {
            let (turned, sum) = (Turn::of(angle).by(more), Turn::of(angle + more));
            assert!((turned.sine - sum.sine).abs() < 1e-15);
            assert!((turned.cosine - sum.cosine).abs() < 1e-15);
        }
    }
}
