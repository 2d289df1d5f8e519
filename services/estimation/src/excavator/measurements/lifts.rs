//! The moments of a whole recording, for whoever learns what the boom's cylinders do: `calibrate`.

use super::boom_moment::{BoomMoment, Front, Moment};
use crate::excavator::cylinder::Cylinder;
use crate::excavator::estimate::Sample;
use crate::excavator::geometry::Geometry;
use crate::math::sin_cos;

/// A longer gap between rows ends what belongs together \[s\].
const GAP: f64 = 0.25;

/// Follows the rows of a recording.
#[derive(Debug, Clone)]
pub struct Lifts {
    geometry: Geometry,
    cylinder: Cylinder,
    moments: BoomMoment,
    time: Option<f64>,
    turn: f64,
}

impl Lifts {
    /// A machine with this drawing and these cylinders.
    #[must_use]
    pub fn new(geometry: Geometry, cylinder: Cylinder) -> Self {
        Self {
            geometry,
            cylinder,
            moments: BoomMoment::new(),
            time: None,
            turn: 0.0,
        }
    }

    /// A row; the moment of a block of 0.2 s. The bucket is in the air. Rows without the three joint angles say nothing.
    pub fn step(&mut self, sample: &Sample) -> Option<Moment> {
        let [boom, arm, bucket] = sample.posture;
        let posture = [boom?, arm?, bucket?];
        let before = self.time.replace(sample.time)?;
        let period = sample.time - before;
        if !(period > 0.0 && period < GAP) {
            self.moments = BoomMoment::new();
            return None;
        }
        let velocity = sample.velocity.unwrap_or(0.0);
        self.turn += velocity * period;
        let (head, rod) = (sample.boom_head_pressure, sample.boom_rod_pressure);
        let front = Front {
            period,
            posture,
            pressures: head.zip(rod).map(|(head, rod)| [head, rod]),
            velocity,
            turn: sin_cos(self.turn),
        };
        self.moments
            .step(&self.geometry, &self.cylinder, &front, true)
    }
}
