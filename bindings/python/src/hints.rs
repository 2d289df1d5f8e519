//! Warnings beside the estimates: data that seem to be in other units, or of another machine.

use config::Description;
use estimation::excavator::{self, Geometry};
use estimation::loader;
use messages::{Envelope, ExcavatorSensors, LoaderSensors, Message};
use recording::measurable::{self, Measured};
use recording::{Gaps, Sensors, Together};

/// Checks the rows as they pass.
pub struct Hints {
    plausible: Plausible,
    large: Large,
    is_measured: bool,
    times: Vec<f64>,
    gaps: Gaps,
    rate: f64,
}

/// Compares data and machine.
enum Plausible {
    Excavator(Together<ExcavatorSensors>, Box<excavator::Plausible>),
    Loader(Together<LoaderSensors>, Box<loader::Plausible>),
}

/// Numbers that are larger than any measurement: they count as missing.
struct Large {
    measured: Vec<Measured>,
    /// Name of each signal, and its number of rows beyond the range.
    counts: Vec<(&'static str, usize)>,
}

impl Large {
    fn of<S: Sensors>(largest: impl Fn(&str) -> Option<f64>) -> Self {
        let measured = measurable::measured::<S>(largest);
        let counts = measured.iter().map(|(i, ..)| (S::FIELDS[*i].name, 0));
        Self {
            counts: counts.collect(),
            measured,
        }
    }

    fn add<S: Sensors>(&mut self, sample: &S) {
        let beyond = measurable::beyond(sample, &self.measured);
        for ((_, bit, _), (_, count)) in self.measured.iter().zip(&mut self.counts) {
            *count += usize::from(beyond & bit != 0);
        }
    }

    fn words(&self) -> impl Iterator<Item = String> {
        let seen = self.counts.iter().filter(|(_, count)| *count > 0);
        seen.map(|(name, count)| measurable::words(name, *count))
    }
}

/// Number of times that are checked: enough to find their step.
const TIMES: usize = 1000;

impl Hints {
    pub fn new(description: &Description) -> Self {
        let plausible = match description {
            Description::Excavator(d) => {
                let plausible = excavator::Plausible::new(Geometry::of(d));
                Plausible::Excavator(Together::default(), Box::new(plausible))
            }
            Description::Loader(d) => {
                let plausible = loader::Plausible::new(d.machine.mass, d.machine.wheel_radius);
                Plausible::Loader(Together::default(), Box::new(plausible))
            }
        };
        let large = match description {
            Description::Excavator(d) => {
                Large::of::<ExcavatorSensors>(|signal| excavator::largest(signal, d))
            }
            Description::Loader(d) => {
                Large::of::<LoaderSensors>(|signal| loader::largest(signal, d))
            }
        };
        Self {
            plausible,
            large,
            is_measured: false,
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
            Plausible::Excavator(together, plausible) => {
                if let Some(sample) = ExcavatorSensors::inside(sample) {
                    self.large.add(sample);
                    self.is_measured |= sample.valid != 0;
                    plausible.push(&steps::excavator::sample(together.with(sample)));
                }
            }
            Plausible::Loader(together, plausible) => {
                if let Some(sample) = LoaderSensors::inside(sample) {
                    self.large.add(sample);
                    self.is_measured |= sample.valid != 0;
                    plausible.push(&steps::loader::sample(together.with(sample)));
                }
            }
        }
    }

    /// The warnings as text, the same as of `heft estimate`.
    pub fn words(&self) -> Vec<String> {
        let mismatch = match &self.plausible {
            Plausible::Excavator(_, plausible) => plausible.mismatch().map(|m| m.to_string()),
            Plausible::Loader(_, plausible) => plausible.mismatch().map(|m| m.to_string()),
        };
        let rate = self.rate;
        let unit = recording::time_unit(&self.times, rate).map(|(step, unit)| {
            format!(
                "the rows are {step} s apart, and sensors.rate is {rate} Hz: is the time in {unit}?"
            )
        });
        let slow = recording::too_slow(&self.times, rate);
        let fast = recording::too_fast(&self.times, rate);
        let gaps = self.gaps.fault().or_else(|| self.gaps.words());
        let nothing = (!self.is_measured).then(|| {
            "nothing was measured: no row has a value beside the time; check that the sensors were on".to_owned()
        });
        let hints = unit
            .into_iter()
            .chain(slow)
            .chain(fast)
            .chain(gaps)
            .chain(mismatch);
        hints.chain(nothing).chain(self.large.words()).collect()
    }
}
