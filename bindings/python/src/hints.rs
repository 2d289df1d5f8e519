//! Warnings beside the estimates: data that seem to be in other units, or of another machine.

use config::Description;
use estimation::excavator::{self, Geometry};
use estimation::loader;
use messages::{Envelope, ExcavatorSensors, LoaderSensors, Message};
use recording::Gaps;

/// Looks at the rows on their way.
pub struct Hints {
    plausible: Plausible,
    times: Vec<f64>,
    gaps: Gaps,
    rate: f64,
}

/// Compares data and machine.
enum Plausible {
    Excavator(Box<excavator::Plausible>),
    Loader(loader::Plausible),
}

/// Times that are looked at: enough to know their step.
const TIMES: usize = 1000;

impl Hints {
    pub fn new(description: &Description) -> Self {
        let plausible = match description {
            Description::Excavator(d) => {
                Plausible::Excavator(Box::new(excavator::Plausible::new(Geometry::of(d))))
            }
            Description::Loader(d) => Plausible::Loader(loader::Plausible::new(
                d.machine.mass,
                d.machine.wheel_radius,
            )),
        };
        Self {
            plausible,
            times: Vec::new(),
            gaps: Gaps::default(),
            rate: description.rate(),
        }
    }

    pub fn add(&mut self, sample: &Envelope) {
        let time = sample.stamp().time;
        self.gaps.see(time);
        if self.times.len() < TIMES && time.is_finite() {
            self.times.push(time);
        }
        match &mut self.plausible {
            Plausible::Excavator(plausible) => {
                if let Some(sample) = ExcavatorSensors::inside(sample) {
                    plausible.push(&steps::excavator::sample(sample));
                }
            }
            Plausible::Loader(plausible) => {
                if let Some(sample) = LoaderSensors::inside(sample) {
                    plausible.push(&steps::loader::sample(sample));
                }
            }
        }
    }

    /// In words, as `heft estimate` says them.
    pub fn words(&self) -> Vec<String> {
        let mismatch = match &self.plausible {
            Plausible::Excavator(plausible) => plausible.mismatch().map(|m| m.to_string()),
            Plausible::Loader(plausible) => plausible.mismatch().map(|m| m.to_string()),
        };
        let rate = self.rate;
        let unit = recording::time_unit(&self.times, rate).map(|(step, unit)| {
            format!(
                "the rows are {step} s apart, and sensors.rate is {rate} Hz: is the time in {unit}?"
            )
        });
        let gaps = self.gaps.fault().or_else(|| self.gaps.words());
        unit.into_iter().chain(gaps).chain(mismatch).collect()
    }
}
