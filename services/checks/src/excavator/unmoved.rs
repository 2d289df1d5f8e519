//! Detects a swing velocity that shows no swing, although the torque turns the machine: a dead sensor, or another unit.

use estimation::excavator::{Geometry, Sample};
use recording::Finding;

/// Posture of the inertia that the torque would turn \[rad\].
const POSTURE: [f64; 3] = [0.8, -1.4, -0.6];
/// Torque that surely turns a machine, as an acceleration of its described inertia \[rad/s²\]. Friction takes .05 to .1.
const TURNS: f64 = 0.2;
/// Velocity below which nothing swings [rad/s].
const STANDS: f64 = 0.05;
/// Fewest rows with such a torque in each direction, and their least share of all rows: a bucket at a wall holds the machine too.
const FEWEST: u32 = 200;
const OFTEN: f64 = 0.02;

/// Counts rows in which the torque would turn the machine.
pub(super) struct Unmoved {
    /// The torque that turns it \[N m\].
    turns: f64,
    rows: u32,
    /// Rows with this torque, by its direction, and the largest torque \[N m\].
    turning: [u32; 2],
    largest: f64,
    fastest: f64,
}

impl Unmoved {
    pub(super) fn new(geometry: Geometry) -> Self {
        Self {
            turns: TURNS * geometry.inertia(POSTURE).empty,
            rows: 0,
            turning: [0; 2],
            largest: 0.0,
            fastest: 0.0,
        }
    }

    pub(super) fn see(&mut self, sample: &Sample) {
        let (Some(velocity), Some(torque)) = (sample.velocity, sample.torque) else {
            return;
        };
        self.rows += 1;
        self.fastest = self.fastest.max(velocity.abs());
        self.largest = self.largest.max(torque.abs());
        self.turning[usize::from(torque < 0.0)] += u32::from(torque.abs() > self.turns);
    }

    /// The fault and its remedy.
    pub(super) fn fault(&self) -> Option<Finding> {
        let least = f64::from(FEWEST).max(OFTEN * f64::from(self.rows));
        let turns = self.turning.iter().all(|rows| f64::from(*rows) > least);
        (turns && self.fastest < STANDS).then(|| {
            Finding::new(
                format!(
                    "swing_velocity never exceeds {:.3} rad/s, though swing_torque, of up to {:.0} N m, turns the machine both ways",
                    self.fastest,
                    self.largest,
                ),
                "check the sensor, and its column and unit in the signal map",
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_velocity_that_stays_near_0_is_named_where_the_torque_turns_the_machine() {
        let said = |velocity: f64, torque: f64| {
            let mut unmoved = Unmoved::new(Geometry::of(&config::Excavator::default()));
            for k in 0..6000 {
                let phase = (0.01 * f64::from(k)).sin();
                unmoved.see(&Sample {
                    velocity: Some(velocity * phase),
                    torque: Some(torque * phase),
                    ..Sample::default()
                });
            }
            unmoved.fault()
        };
        // Dead, and radians a second taken for degrees.
        for velocity in [0.0, 0.9_f64.to_radians()] {
            assert!(said(velocity, 5e3).is_some_and(|words| words.what.contains("up to 5000 N m")));
        }
        assert_eq!(said(0.9, 5e3), None, "it swings");
        assert_eq!(said(0.0, 500.0), None, "it stands");
    }
}
