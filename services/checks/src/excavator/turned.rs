//! Detects a swing velocity or a swing torque whose sign changes within a recording: the sensor was mounted again, or two
//! recordings with different signs were joined.
//!
//! Each part of the recording is compared with the machine file as it is, and with the velocity negated. The signs of a part are
//! right if the negated one is refused for its sign, and turned if the part itself is.

use estimation::excavator::{Geometry, Mismatch, Plausible, Sample};
use recording::Finding;

/// Duration of a part [s].
const PART: f64 = 30.0;

/// Compares the signs of the parts of a recording.
pub(super) struct Turned {
    geometry: Geometry,
    begin: Option<f64>,
    /// The part as it is, and with the velocity negated.
    part: [Plausible; 2],
    /// Whether the signs of the latest part with a verdict are right.
    is_right: Option<bool>,
    /// Begin of the first part whose signs differ from those before it \[s\].
    changed: Option<f64>,
}

impl Turned {
    pub(super) fn new(geometry: Geometry) -> Self {
        Self {
            geometry,
            begin: None,
            part: [geometry; 2].map(Plausible::new),
            is_right: None,
            changed: None,
        }
    }

    pub(super) fn see(&mut self, sample: &Sample) {
        let begin = *self.begin.get_or_insert(sample.time);
        if !(0.0..PART).contains(&(sample.time - begin)) {
            self.end_part(begin);
            self.part = [self.geometry; 2].map(Plausible::new);
            self.begin = Some(sample.time);
        }
        let velocity = sample.velocity.map(|velocity| -velocity);
        let negated = Sample {
            velocity,
            ..*sample
        };
        self.part[0].push(sample);
        self.part[1].push(&negated);
    }

    /// Whether the signs of the present part are right, if it shows that.
    fn verdict(&self) -> Option<bool> {
        let is_refused = |part: &Plausible| part.mismatch() == Some(Mismatch::Sign);
        match self.part.each_ref().map(is_refused) {
            [false, true] => Some(true),
            [true, false] => Some(false),
            _ => None,
        }
    }

    /// Whether the signs of the present part differ from those before it.
    fn differs(&self) -> bool {
        let now_and_before = self.verdict().zip(self.is_right);
        now_and_before.is_some_and(|(now, before)| now != before)
    }

    /// Ends the part that began then.
    fn end_part(&mut self, begin: f64) {
        if self.differs() {
            self.changed.get_or_insert(begin);
        }
        self.is_right = self.verdict().or(self.is_right);
    }

    /// The fault of signs that change.
    pub(super) fn fault(&self) -> Option<Finding> {
        let last = self.begin.filter(|_| self.differs());
        let time = self.changed.or(last)?;
        Some(Finding::new(
            format!(
                "swing_velocity or swing_torque changes its sign at about t = {time:.0} s: torque and acceleration agree on one side of it only"
            ),
            "divide the recording there, and write `sign = -1` for the wrong column in a signal map of that part",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    /// The fault of two minutes in which the reference machine swings to and fro, with a velocity of this sign at each time.
    fn said(sign: impl Fn(f64) -> f64) -> Option<Finding> {
        let geometry = Geometry::of(&config::Excavator::default());
        let posture = [0.8, -1.4, -0.6];
        let inertia = geometry.inertia(posture).empty;
        let mut turned = Turned::new(geometry);
        for k in 0..12_000 {
            let time = f64::from(k) / 100.0;
            let (velocity, gain) = (0.8 * time.sin(), 0.8 * time.cos());
            turned.see(&Sample {
                time,
                velocity: Some(sign(time) * velocity),
                torque: Some(inertia * gain + 600.0 * velocity),
                posture: posture.map(Some),
                ..Sample::default()
            });
        }
        turned.fault()
    }

    #[test]
    fn a_sign_that_changes_within_a_recording_is_named_with_its_time() {
        // The same sign everywhere is another fault, if it is wrong.
        assert_eq!([said(|_| 1.0), said(|_| -1.0)], [None, None]);
        for (changes, part) in [(50.0, 60), (91.0, 90)] {
            let words = text(said(|time| if time < changes { 1.0 } else { -1.0 }));
            let time = format!("changes its sign at about t = {part} s");
            assert!(words.contains(&time), "{words}");
        }
    }
}
