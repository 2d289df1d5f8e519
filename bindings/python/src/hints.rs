//! Warnings beside the estimates: data that seem to be in other units, or of another machine.

use config::Description;
use estimation::excavator::{Geometry, Plausible};
use messages::Envelope;

/// Looks at the rows on their way.
pub struct Hints {
    plausible: Option<Plausible>,
    times: Vec<f64>,
    rate: f64,
}

/// Times that are looked at: enough to know their step.
const TIMES: usize = 1000;

impl Hints {
    pub fn new(description: &Description) -> Self {
        let plausible = match description {
            Description::Excavator(d) => Some(Plausible::new(Geometry::of(d))),
            Description::Loader(_) => None,
        };
        Self {
            plausible,
            times: Vec::new(),
            rate: description.rate(),
        }
    }

    pub fn add(&mut self, sample: &Envelope) {
        let time = sample.stamp().time;
        if self.times.len() < TIMES && time.is_finite() {
            self.times.push(time);
        }
        if let (Some(plausible), Envelope::ExcavatorSensors(s)) = (&mut self.plausible, sample) {
            plausible.push(&steps::excavator::sample(s));
        }
    }

    /// In words, as `heft estimate` says them.
    pub fn words(&self) -> Vec<String> {
        let mismatch = self.plausible.as_ref().and_then(Plausible::mismatch);
        let rate = self.rate;
        let unit = recording::time_unit(&self.times, rate).map(|(step, unit)| {
            format!(
                "the rows are {step} s apart, and sensors.rate is {rate} Hz: is the time in {unit}?"
            )
        });
        unit.into_iter()
            .chain(mismatch.map(|m| m.to_string()))
            .collect()
    }
}
