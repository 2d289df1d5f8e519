//! A swing velocity in another unit.

use estimation::excavator::{Geometry, Mismatch, Plausible, Sample};

use crate::machines::units::TURNING;

/// Units of a swing velocity. The first that explains the torque counts.
const UNITS: [(&str, f64); 2] = [TURNING[0], TURNING[1]];
/// Swinging from this velocity on; makers' sheets allow 15 revolutions per minute: none swings faster than the second [rad/s].
const SWINGS: f64 = 0.1;
const FASTEST: f64 = 2.0;
/// Rows that tell, and the share of the swinging ones that is too fast: single ones are disturbances.
const FEWEST: u32 = 100;
const OFTEN: f64 = 0.05;
/// Mean of what is too fast, above which it is in degrees per second where the torque does not tell \[rpm\].
const BETWEEN: f64 = 13.0;

/// Looks at the speeds, and at what torque and posture make of them in each unit.
pub(super) struct Speed {
    swinging: u32,
    fast: u32,
    /// Sum of the fast ones.
    sum: f64,
    units: [Plausible; UNITS.len()],
}

impl Speed {
    pub(super) fn new(geometry: Geometry) -> Self {
        Self {
            swinging: 0,
            fast: 0,
            sum: 0.0,
            units: UNITS.map(|_| Plausible::new(geometry)),
        }
    }

    pub(super) fn see(&mut self, sample: &Sample) {
        if let Some(speed) = sample.velocity.map(f64::abs).filter(|v| v.is_finite()) {
            self.swinging += u32::from(speed > SWINGS);
            // What is too fast in every unit is none of them: it stands for a missing sample.
            let is_fast = (FASTEST..=FASTEST * UNITS[1].1).contains(&speed);
            self.fast += u32::from(is_fast);
            self.sum += if is_fast { speed } else { 0.0 };
        }
        for (plausible, (_, unit)) in self.units.iter_mut().zip(UNITS) {
            let velocity = sample.velocity.map(|velocity| velocity / unit);
            plausible.push(&Sample {
                velocity,
                ..*sample
            });
        }
    }

    /// The unit of the velocity, where it is none that is meant.
    pub(super) fn fault(&self) -> Option<String> {
        if self.fast < FEWEST || f64::from(self.fast) < OFTEN * f64::from(self.swinging) {
            return None;
        }
        // Another fault of the torque is said when this one is mended.
        let explains = |plausible: &Plausible| {
            !matches!(
                plausible.mismatch(),
                Some(Mismatch::Size(_) | Mismatch::Degrees | Mismatch::Revolutions)
            )
        };
        let mean = self.sum / f64::from(self.fast);
        let unit = match [explains(&self.units[0]), explains(&self.units[1])] {
            [true, false] => 0,
            [false, true] => 1,
            _ => usize::from(mean > BETWEEN),
        };
        let (unit, factor) = UNITS[unit];
        Some(format!(
            "swing_velocity seems to be in {unit}: no excavator swings at {mean:.0} rad/s, and {:.2} would be usual\n  \
             what to do: write `unit = \"{unit}\"` for swing_velocity in a signal map",
            mean / factor
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_for_missing_samples_is_no_unit() {
        let mut speed = Speed::new(Geometry::default());
        for k in 0..9000_u32 {
            let velocity = (0.01 * f64::from(k)).sin();
            speed.see(&Sample {
                time: 0.01 * f64::from(k),
                velocity: Some(if k.is_multiple_of(10) {
                    -9999.0
                } else {
                    velocity
                }),
                ..Sample::default()
            });
        }
        assert_eq!(speed.fault(), None);
    }

    #[test]
    fn the_unit_that_the_torque_explains_is_named_and_else_the_usual_one() {
        let said = |unit: f64, torque: Option<f64>, fastest: f64| {
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
            let said = speed.fault()?;
            let unit = said.split("unit = \"").nth(1)?;
            Some(unit.split('"').next()?.to_owned())
        };
        let [(rpm, per_rpm), (degrees, per_degree)] = UNITS;
        for torque in [Some(1.0), Some(1e-3), None] {
            assert_eq!(said(1.0, torque, 1.2), None);
            assert_eq!(said(per_rpm, torque, 0.9).as_deref(), Some(rpm));
            assert_eq!(said(per_degree, torque, 0.9).as_deref(), Some(degrees));
        }
        // Slowly: 15 degrees a second at most.
        assert_eq!(said(per_degree, Some(1.0), 0.26).as_deref(), Some(degrees));
    }
}
