//! Computes the moments of a whole recording, from which `calibrate` identifies the boom's cylinders.

use super::boom_moment::{BoomMoment, Front, Moment};
use crate::excavator::angle::Angle;
use crate::excavator::cylinder::Cylinder;
use crate::excavator::estimate::Sample;
use crate::excavator::geometry::{Geometry, turns};
use crate::excavator::joints::joint;
use crate::math::sin_cos;

/// Longest gap between rows of one block \[s\].
const GAP: f64 = 0.25;

/// Swing velocity below which the upper body stands [rad/s].
const STANDS: f64 = 0.05;

/// Computes the moments from the rows of a recording.
#[derive(Debug, Clone)]
pub struct Lifts {
    geometry: Geometry,
    cylinder: Cylinder,
    moments: BoomMoment,
    boom: Angle,
    time: Option<f64>,
    turn: f64,
    /// Time and swing angle of an encoder at least `GAP` ago, and whether the upper body turns.
    angle: Option<(f64, f64)>,
    turns: bool,
    /// The rod pressure has been measured.
    rod: bool,
}

impl Lifts {
    /// For a machine with this geometry and these cylinders.
    #[must_use]
    pub fn new(geometry: Geometry, cylinder: Cylinder) -> Self {
        Self {
            geometry,
            cylinder,
            moments: BoomMoment::new(),
            boom: Angle::default(),
            time: None,
            turn: 0.0,
            angle: None,
            turns: false,
            rod: false,
        }
    }

    /// Whether the encoder shows a swing.
    fn turns(&mut self, sample: &Sample) -> bool {
        if let Some(angle) = sample.angle.filter(|angle| angle.is_finite()) {
            let (time, before) = *self.angle.get_or_insert((sample.time, angle));
            let elapsed = sample.time - time;
            if elapsed >= GAP {
                self.turns = (angle - before).abs() > STANDS * elapsed;
                self.angle = Some((sample.time, angle));
            }
        }
        self.turns
    }

    /// Takes a row, of a bucket in the air. Returns the moment of a block of 0.2 s. A row without the three joint angles is ignored.
    pub fn step(&mut self, sample: &Sample) -> Option<Moment> {
        let [boom, arm, bucket] = sample.posture;
        let posture = [boom?, arm?, bucket?].map(joint);
        if !posture.into_iter().chain([sample.time]).all(f64::is_finite) {
            return None;
        }
        let before = self.time.replace(sample.time)?;
        let period = sample.time - before;
        if !(period > 0.0 && period < GAP) {
            self.moments = BoomMoment::new();
            return None;
        }
        // Blocks of a swing are not used: the velocity may be biased, or differenced from an encoder.
        let velocity = sample.velocity.filter(|v| v.is_finite()).unwrap_or(0.0);
        let stands = velocity.abs() < STANDS && !self.turns(sample);
        self.turn += velocity * period;
        let finite = |v: Option<f64>| v.filter(|v| v.is_finite());
        let head = finite(sample.boom_head_pressure);
        self.rod |= sample.boom_rod_pressure.is_some();
        let rod = if self.rod {
            finite(sample.boom_rod_pressure)
        } else {
            Some(0.0)
        };
        self.boom.pass(Some(posture[0]), period);
        let front = Front {
            period,
            posture,
            turns: turns(posture),
            posture_variance: self.boom.variance(),
            pressures: head.zip(rod).map(|(head, rod)| [head, rod]),
            velocity,
            turn: sin_cos(self.turn),
        };
        self.moments
            .step(&self.geometry, &self.cylinder, &front, (stands, false))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::keys::Description;
    use core::f64::consts::TAU;

    /// Moments of a bucket that curls across the half turn, its angle continuous or within a turn from 0.
    fn moments(is_whole: bool) -> impl Iterator<Item = f64> {
        let mut d = Description::default();
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (1.0, 0.01, 0.007);
        (c.base_distance, c.rod_distance) = (0.6, 1.3);
        let cylinder = Cylinder::of_boom(&d).expect("a described cylinder");
        let mut lifts = Lifts::new(Geometry::of(&d), cylinder);
        (0..300).filter_map(move |k| {
            let time = 0.01 * f64::from(k);
            let bucket = 0.5 - 0.7 * time;
            let bucket = if is_whole {
                bucket.rem_euclid(TAU)
            } else {
                bucket
            };
            let moment = lifts.step(&Sample {
                time,
                velocity: Some(0.0),
                posture: [Some(0.4), Some(-1.2), Some(bucket)],
                boom_head_pressure: Some(12e6),
                boom_rod_pressure: Some(1e6),
                ..Sample::default()
            })?;
            Some(moment.empty)
        })
    }

    #[test]
    fn a_sensor_that_counts_another_turn_shows_the_same_moments() {
        let (whole, as_it_is) = (moments(true), moments(false));
        let mut count = 0;
        for (found, expected) in whole.zip(as_it_is) {
            assert!(
                (found - expected).abs() < 1e-6 * expected.abs(),
                "{found} {expected}"
            );
            count += 1;
        }
        assert!(count > 5, "{count}");
    }

    #[test]
    fn a_cylinder_that_stands_keeps_the_direction_in_which_it_stopped() {
        let mut d = Description::default();
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (1.0, 0.01, 0.007);
        (c.base_distance, c.rod_distance, c.friction_kept) = (0.6, 1.3, 0.8);
        let cylinder = Cylinder::of_boom(&d).expect("a described cylinder");
        let mut lifts = Lifts::new(Geometry::of(&d), cylinder);
        let moments = (0..1500).filter_map(|k| {
            let time = 0.01 * f64::from(k);
            lifts.step(&Sample {
                time,
                velocity: Some(0.0),
                posture: [Some(0.4 + 0.1 * time.min(2.0)), Some(-1.2), Some(-0.5)],
                boom_head_pressure: Some(12e6),
                boom_rod_pressure: Some(1e6),
                ..Sample::default()
            })
        });
        let last = moments.last().expect("a moment");
        assert!(!last.moves);
        assert!((last.direction - 0.8).abs() < 1e-3, "{}", last.direction);
    }
}
