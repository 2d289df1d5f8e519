//! Kinematics and force of a hydraulic cylinder about a pin: length, lever, force.
//!
//! ```text
//! l^2 = a^2 + c^2 - 2 a c cos(q + delta)        r = dl/dq = a c sin(q + delta)/l        F = n (A_h p_h - A_r p_r) - F_0
//! ```

use crate::FULL_PRESSURE;
use crate::excavator::keys::Description;
use crate::math::{sin_cos, sqrt};

/// Relative standard deviations of areas and lengths, where none is stated.
const AREA: f64 = 0.005;
const LENGTH: f64 = 0.004;
/// Relative standard deviation of the span of pressure transmitters on mobile machines.
const TRANSMITTER: f64 = 0.01;

/// A group of parallel cylinders.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cylinder {
    /// Areas of head and rod side, of all cylinders together (n A) [m^2].
    pub areas: [f64; 2],
    /// Distances from base to pin (a) and from pin to rod eye (c) \[m\].
    pub distances: [f64; 2],
    /// Sine and cosine of the angle between these two lines at joint angle 0 (delta).
    pub angle: (f64, f64),
    /// Friction of the seals, and its standard deviation \[N\].
    pub friction: [f64; 2],
    /// Share of the friction that remains when the cylinder stops.
    pub kept: f64,
    /// Standard deviation of this share.
    pub kept_std: f64,
    /// Relative standard deviation of the moment, by areas, lengths, angle and pressures.
    pub span_std: f64,
    /// Force by the zero offsets of the two pressures \[N\].
    pub zero: f64,
    /// Standard deviation of this force \[N\].
    pub zero_std: f64,
    /// Correlation of the errors of span and zero.
    pub correlation: f64,
    /// Moment about the pin that the drawing misses: coefficients of cosine and sine of the angles of boom, arm and bucket to the
    /// horizontal [N m].
    pub missed: [[f64; 2]; 3],
}

impl Cylinder {
    /// The boom's cylinders; `None` where their areas or lengths are not described.
    #[must_use]
    pub fn of_boom(d: &Description) -> Option<Self> {
        let c = &d.boom_cylinder;
        let needed = [c.head_area, c.base_distance, c.rod_distance];
        if needed.iter().any(|value| *value <= 0.0) {
            return None;
        }
        let areas = [c.count * c.head_area, c.count * c.rod_area];
        let full = areas[0] * FULL_PRESSURE;
        let share = |std: Option<f64>, value: f64, of: f64| std.map_or(of, |std| std / value);
        let doubts = [
            share(c.head_area_std, c.head_area, AREA),
            share(c.base_distance_std, c.base_distance, LENGTH),
            share(c.rod_distance_std, c.rod_distance, LENGTH),
            // The relative change of the lever with the angle is a cotangent; its mean over the boom's travel is a half.
            0.5 * (c.angle_std + d.sensors.angle_offset_std),
            TRANSMITTER,
        ];
        Some(Self {
            areas,
            distances: [c.base_distance, c.rod_distance],
            angle: sin_cos(c.angle),
            friction: [c.friction * full, c.friction_std * full],
            kept: c.friction_kept,
            kept_std: c.friction_kept_std,
            span_std: c
                .span_std
                .unwrap_or(sqrt(doubts.iter().map(|doubt| doubt * doubt).sum())),
            zero: c.force_offset,
            zero_std: c.force_offset_std.unwrap_or(
                d.sensors.pressure_offset_std * sqrt(areas.iter().map(|area| area * area).sum()),
            ),
            correlation: c.span_offset_correlation.clamp(-0.999, 0.999),
            missed: [
                [c.boom_cos, c.boom_sin],
                [c.arm_cos, c.arm_sin],
                [c.bucket_cos, c.bucket_sin],
            ],
        })
    }

    /// Length and lever at a joint angle, both \[m\].
    #[must_use]
    pub fn lever(&self, angle: f64) -> (f64, f64) {
        self.lever_turned(sin_cos(angle))
    }

    /// The same from sine and cosine of the joint angle.
    pub(in crate::excavator) fn lever_turned(&self, (sin, cos): (f64, f64)) -> (f64, f64) {
        let [a, c] = self.distances;
        let (s, k) = self.angle;
        let (sin, cos) = (sin * k + cos * s, cos * k - sin * s);
        let square = a * a + c * c - 2.0 * a * c * cos;
        let length = sqrt(square.max(1e-6 * (a * a + c * c)));
        (length, a * c * sin / length)
    }

    /// Variance of the seals' friction that remains after a stop [N^2].
    #[must_use]
    pub fn held_variance(&self) -> f64 {
        let [friction, std] = self.friction;
        let (share, moving) = (self.kept_std * friction, self.kept * std);
        share * share + moving * moving
    }

    /// Force of the pressures of head and rod side, without the force by their zero offsets \[N\].
    #[must_use]
    pub fn force(&self, [head, rod]: [f64; 2]) -> f64 {
        self.areas[0] * head - self.areas[1] * rod - self.zero
    }
}
