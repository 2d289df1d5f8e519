//! Detects a swing velocity in another unit than rad/s, by its size and by the torque.

use estimation::excavator::{Geometry, Mismatch, Plausible, Sample};
use recording::Finding;

use crate::advice::write_unit;
use crate::units::TURNING;

/// Candidate units of a swing velocity, and their number per rad/s.
const UNITS: [(&str, f64); 3] = [TURNING[0], TURNING[1], TURNING[3]];
/// Indices of deg/s and mrad/s in `UNITS`.
const DEGREES: usize = 1;
const THOUSANDTHS: usize = 2;
/// Least velocity of a swing, and a velocity that no excavator exceeds [rad/s]: makers' sheets allow 15 rpm, which is 1.57 rad/s.
const SWINGS: f64 = 0.1;
const FASTEST: f64 = 2.0;
/// Least number of too fast rows, and their least share of the swinging rows: single ones are disturbances.
const FEWEST: u32 = 100;
const OFTEN: f64 = 0.05;
/// Mean of the too fast values above which they are taken for deg/s and below for rpm, if the torque does not identify the unit.
const BETWEEN: f64 = 13.0;
/// Usual mean velocity of swings [rad/s]. A unit that gives a mean outside of it is no candidate.
const USUAL: std::ops::Range<f64> = 0.05..1.8;

/// Collects the velocities, and compares them in each unit with torque and posture.
pub(super) struct Speed {
    swinging: u32,
    fast: u32,
    /// Sum of the too fast velocities.
    sum: f64,
    /// Number of rows that are too fast even in deg/s, their sum, and the last of them. A repeated value marks missing samples.
    faster: u32,
    sum_of_faster: f64,
    last: f64,
    units: [Plausible; UNITS.len()],
}

impl Speed {
    pub(super) fn new(geometry: Geometry) -> Self {
        Self {
            swinging: 0,
            fast: 0,
            sum: 0.0,
            faster: 0,
            sum_of_faster: 0.0,
            last: 0.0,
            units: UNITS.map(|_| Plausible::new(geometry)),
        }
    }

    pub(super) fn see(&mut self, sample: &Sample) {
        if let Some(speed) = sample.velocity.map(f64::abs).filter(|v| v.is_finite()) {
            self.swinging += u32::from(speed > SWINGS);
            // A value that is too fast in every unit marks a missing sample.
            let [degrees, thousandths] = [DEGREES, THOUSANDTHS].map(|at| FASTEST * UNITS[at].1);
            let is_fast = (FASTEST..=degrees).contains(&speed);
            self.fast += u32::from(is_fast);
            self.sum += if is_fast { speed } else { 0.0 };
            if (degrees..=thousandths).contains(&speed) {
                let is_new = std::mem::replace(&mut self.last, speed) != speed;
                self.faster += u32::from(is_new);
                self.sum_of_faster += if is_new { speed } else { 0.0 };
            }
        }
        for (plausible, (_, unit)) in self.units.iter_mut().zip(UNITS) {
            let velocity = sample.velocity.map(|velocity| velocity / unit);
            plausible.push(&Sample {
                velocity,
                ..*sample
            });
        }
    }

    /// Whether this number of rows determines the unit.
    fn are_enough(&self, rows: u32) -> bool {
        rows >= FEWEST && f64::from(rows) >= OFTEN * f64::from(self.swinging)
    }

    /// The fault of a velocity that is not in rad/s.
    pub(super) fn fault(&self) -> Option<Finding> {
        let is_faster = self.are_enough(self.faster);
        if !is_faster && !self.are_enough(self.fast) {
            return None;
        }
        let (mut fast, mut sum) = (self.fast, self.sum);
        if is_faster {
            (fast, sum) = (fast + self.faster, sum + self.sum_of_faster);
        }
        let mean = sum / f64::from(fast);
        // Other mismatches of the torque are reported once the unit is corrected.
        let explains = |plausible: &Plausible| {
            !matches!(
                plausible.mismatch(),
                Some(Mismatch::Size(_) | Mismatch::Degrees | Mismatch::Revolutions)
            )
        };
        let explaining = self.units.each_ref().map(explains);
        let unit = match explaining {
            _ if is_faster => THOUSANDTHS,
            [true, false, false] => 0,
            [false, true, false] => DEGREES,
            [false, false, true] => THOUSANDTHS,
            [true, false, true] => 0,
            [false, true, true] => DEGREES,
            _ => usize::from(mean > BETWEEN),
        };
        let is_sure = is_faster || explaining.iter().filter(|explains| **explains).count() == 1;
        let may_be = |at: &usize| {
            let explains = explaining[*at] || !explaining.contains(&true);
            !is_sure && *at != unit && explains && USUAL.contains(&(mean / UNITS[*at].1))
        };
        let others: Vec<_> = (0..UNITS.len())
            .filter(may_be)
            .map(|at| {
                format!(
                    "; or `unit = \"{}\"`, where {:.2} rad/s would be usual",
                    UNITS[at].0,
                    mean / UNITS[at].1
                )
            })
            .collect();
        let (unit, factor) = UNITS[unit];
        Some(Finding::new(
            format!(
                "swing_velocity seems to be in {unit}: no excavator swings at {mean:.0} rad/s, and {:.2} would be usual",
                mean / factor
            ),
            format!("{}{}", write_unit(unit, "swing_velocity"), others.concat()),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_for_missing_samples_is_no_unit() {
        for mark in [-9999.0, 999.0, -999.0] {
            let mut speed = Speed::new(Geometry::default());
            for k in 0..9000_u32 {
                let velocity = (0.01 * f64::from(k)).sin();
                speed.see(&Sample {
                    time: 0.01 * f64::from(k),
                    velocity: Some(if k.is_multiple_of(10) { mark } else { velocity }),
                    ..Sample::default()
                });
            }
            assert_eq!(speed.fault(), None, "{mark}");
        }
    }

    #[test]
    fn the_unit_that_the_torque_explains_is_named_and_else_the_usual_one() {
        let named = |unit: f64, torque: Option<f64>, fastest: f64| {
            let geometry = Geometry::default();
            let mut speed = Speed::new(geometry);
            for k in 0..9000 {
                let time = f64::from(k) / 100.0;
                let (sin, cos) = time.sin_cos();
                let posture = [0.6, -1.6, -1.0];
                let inertia = geometry.inertia(posture).empty;
                let whole = fastest * (inertia * cos + 1500.0 * sin + 250.0 * sin.signum());
                speed.see(&Sample {
                    time,
                    velocity: Some(unit * fastest * sin),
                    torque: torque.map(|gain| gain * whole),
                    posture: posture.map(Some),
                    ..Sample::default()
                });
            }
            let text = speed.fault()?.to_string();
            let unit = text.split("unit = \"").nth(1)?;
            Some(unit.split('"').next()?.to_owned())
        };
        let [
            (rpm, per_rpm),
            (degrees, per_degree),
            (thousandths, per_thousandth),
        ] = UNITS;
        for torque in [Some(1.0), Some(1e-3), None] {
            assert_eq!(named(1.0, torque, 1.2), None);
            assert_eq!(named(per_rpm, torque, 0.9).as_deref(), Some(rpm));
            assert_eq!(named(per_degree, torque, 0.9).as_deref(), Some(degrees));
            assert_eq!(
                named(per_thousandth, torque, 0.9).as_deref(),
                Some(thousandths)
            );
        }
        // Slow swings: below the largest value in deg/s, the torque identifies the unit.
        assert_eq!(
            named(per_thousandth, Some(1.0), 0.1).as_deref(),
            Some(thousandths)
        );
        // Slow swings: at most 15 deg/s.
        assert_eq!(named(per_degree, Some(1.0), 0.26).as_deref(), Some(degrees));
    }
}
