//! Detects a swing torque or a swing velocity without its sign, as a controller that shows amounts records it.
//!
//! The torque T changes the velocity w in its own direction, so the sum of T dw is positive. Without one of the signs that holds in
//! one direction of the swing only, and the other direction has as large a sum against it.

use estimation::excavator::Sample;

/// Least time between two velocities that are compared, and largest \[s\].
const APART: std::ops::RangeInclusive<f64> = 0.1..=0.3;
/// Share of the smaller direction below which a signal has one direction only.
const ONE_WAY: f64 = 0.01;
/// Share of the sum against the torque: without a sign about half; measured on sound recordings below .1.
const AGAINST: std::ops::Range<f64> = 0.25..0.75;
/// Fewest comparisons in which the machine swings: some ten seconds.
const FEWEST: u32 = 100;
/// Velocity above which it swings [rad/s].
const SWINGS: f64 = 0.1;

/// Sums of torque and velocity, and of torque times change of velocity, each by its sign.
#[derive(Default)]
pub(super) struct Signless {
    before: Option<(f64, f64)>,
    torque: [f64; 2],
    velocity: [f64; 2],
    work: [f64; 2],
    count: u32,
}

/// Adds an amount to the sum of its sign.
fn add(sums: &mut [f64; 2], value: f64) {
    sums[usize::from(value < 0.0)] += value.abs();
}

/// Share of the smaller sum, and of the negative one.
fn shares([positive, negative]: [f64; 2]) -> [f64; 2] {
    [positive.min(negative), negative].map(|part| part / (positive + negative))
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
        if APART.contains(&elapsed) && velocity.abs() > SWINGS {
            self.count += 1;
            add(&mut self.velocity, velocity);
            add(&mut self.torque, torque);
            add(&mut self.work, torque * (velocity - last));
        }
    }

    /// The fault and its remedy.
    pub(super) fn fault(&self) -> Option<String> {
        let is_one_way = |sums: &[f64; 2]| shares(*sums)[0] < ONE_WAY;
        let signals = [
            ("swing_velocity", &self.velocity),
            ("swing_torque", &self.torque),
        ];
        let without = signals.into_iter().filter(|(_, sums)| is_one_way(sums));
        let without: Vec<&str> = without.map(|(name, _)| name).collect();
        let is_against = AGAINST.contains(&shares(self.work)[1]);
        (self.count >= FEWEST && is_against && !without.is_empty()).then(|| {
            let (one, s) = (without.join(" and "), if without.len() == 1 { "s" } else { "" });
            format!(
                "{one} seem{s} to lack the sign: the direction never changes, and the velocity changes against the torque as often as with it\n  \
                 what to do: record the signed value (positive is anticlockwise, seen from above), not the amount"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said of a minute of swings to and fro, with torque and velocity as recorded.
    fn said(recorded: fn(f64, f64) -> (f64, f64)) -> Option<String> {
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
            let words = said(recorded).unwrap_or_default();
            assert!(words.starts_with(names), "{words:?}");
        }
        assert_eq!(said(|v, t| (v, t)), None);
        assert_eq!(said(|v, t| (v, -t)), None, "another fault");
        // Turning one way only, with a brake.
        assert_eq!(said(|v, t| if v > 0.0 { (v, t) } else { (0.0, 0.0) }), None);
    }
}
