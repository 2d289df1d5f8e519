//! Detects a swing torque or a swing velocity without its sign, as a controller that shows amounts records it.
//!
//! The torque changes the velocity in its own direction. Without one of the signs that holds in one direction of the swing only.

use estimation::excavator::Sample;
use recording::Finding;

/// Least time between two velocities that are compared, and largest \[s\].
const APART: std::ops::RangeInclusive<f64> = 0.1..=0.3;
/// Share of the rarer direction below which a signal has one direction only.
const ONE_WAY: f64 = 0.01;
/// Share of changes of the velocity against the torque: without a sign about half.
const AGAINST: std::ops::Range<f64> = 0.25..0.75;
/// Fewest changes: some ten seconds.
const FEWEST: u32 = 100;
/// Change of the velocity beyond its noise [rad/s].
const CHANGES: f64 = 0.02;
/// Velocity above which it swings [rad/s].
const SWINGS: f64 = 0.1;

/// Numbers of positive and of negative values.
#[derive(Default)]
struct Signs([u32; 2]);

impl Signs {
    fn see(&mut self, value: f64) {
        self.0[usize::from(value < 0.0)] += 1;
    }

    fn count(&self) -> u32 {
        self.0[0] + self.0[1]
    }

    /// Share of the negative values.
    fn negative(&self) -> f64 {
        f64::from(self.0[1]) / f64::from(self.count().max(1))
    }

    fn is_one_way(&self) -> bool {
        let negative = self.negative();
        negative.min(1.0 - negative) < ONE_WAY
    }
}

/// Signs of torque and velocity while the velocity changes, and of the torque along the change.
#[derive(Default)]
pub(super) struct Signless {
    before: Option<(f64, f64)>,
    torque: Signs,
    velocity: Signs,
    along: Signs,
}

impl Signless {
    pub(super) fn see(&mut self, sample: &Sample) {
        let (Some(velocity), Some(torque)) = (sample.velocity, sample.torque) else {
            return;
        };
        let (time, last) = *self.before.get_or_insert((sample.time, velocity));
        let elapsed = sample.time - time;
        if (0.0..*APART.start()).contains(&elapsed) {
            return;
        }
        self.before = Some((sample.time, velocity));
        let change = velocity - last;
        if APART.contains(&elapsed) && velocity.abs() > SWINGS && change.abs() > CHANGES {
            self.velocity.see(velocity);
            self.torque.see(torque);
            self.along.see(torque * change);
        }
    }

    /// The fault and its remedy.
    pub(super) fn fault(&self) -> Option<Finding> {
        let signals = [
            ("swing_velocity", &self.velocity),
            ("swing_torque", &self.torque),
        ];
        let without = signals.into_iter().filter(|(_, signs)| signs.is_one_way());
        let without: Vec<&str> = without.map(|(name, _)| name).collect();
        let is_against = AGAINST.contains(&self.along.negative());
        (self.along.count() >= FEWEST && is_against && !without.is_empty()).then(|| {
            let (one, s) = (without.join(" and "), if without.len() == 1 { "s" } else { "" });
            Finding::new(
                format!(
                    "{one} seem{s} to lack the sign: the direction never changes, and the velocity changes against the torque as often as with it",
                ),
                "record the signed value (positive is anticlockwise, seen from above), not the amount",
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    /// What is said of a minute of swings to and fro, with torque and velocity as recorded.
    fn said(recorded: fn(f64, f64) -> (f64, f64)) -> Option<Finding> {
        let mut signless = Signless::default();
        for k in 0..6000 {
            let time = f64::from(k) / 100.0;
            let (velocity, change) = (0.8 * time.sin(), 0.8 * time.cos());
            let (velocity, torque) = recorded(velocity, 8000.0 * change + 600.0 * velocity);
            signless.see(&Sample {
                time,
                velocity: Some(velocity),
                torque: Some(torque),
                ..Sample::default()
            });
        }
        signless.fault()
    }

    #[test]
    fn a_torque_or_a_velocity_without_its_sign_is_named() {
        for (recorded, names) in [
            (
                (|v, t| (v, t.abs())) as fn(f64, f64) -> _,
                "swing_torque seems",
            ),
            (|v, t| (v.abs(), t), "swing_velocity seems"),
            (
                |v, t| (v.abs(), t.abs()),
                "swing_velocity and swing_torque seem to",
            ),
        ] {
            let words = text(said(recorded));
            assert!(words.starts_with(names), "{words:?}");
        }
        assert_eq!(said(|v, t| (v, t)), None);
        assert_eq!(said(|v, t| (v, -t)), None, "another fault");
        // Turning one way only, with a brake.
        assert_eq!(said(|v, t| if v > 0.0 { (v, t) } else { (0.0, 0.0) }), None);
    }
}
