//! Warnings beside the estimates: data that seem to be in other units, or of another machine.

use checks::Look;
use config::Description;
use messages::{Envelope, Message};
use recording::measurable::{self, Measured};
use recording::{Gaps, Map, Sensors, Together};

/// Checks the rows as they pass.
pub struct Hints {
    looks: Box<dyn Looks>,
    times: Vec<f64>,
    gaps: Gaps,
    rate: f64,
}

/// Checks of the samples of any machine.
trait Looks {
    fn add(&mut self, sample: &Envelope);
    fn words(&self) -> Vec<String>;
}

/// Checks of the samples of a machine, those of `heft estimate`.
struct Looked<L: Look> {
    look: L,
    together: Together<L::Sensors>,
    large: Large,
    is_measured: bool,
    map: Option<Map>,
}

impl<L: Look + 'static> Looked<L> {
    fn boxed(described: &L::Described, map: Option<&Map>) -> Box<dyn Looks> {
        Box::new(Self {
            look: L::of(described),
            together: Together::default(),
            large: Large::of::<L::Sensors>(|signal| L::largest(described, signal)),
            is_measured: false,
            map: map.cloned(),
        })
    }
}

impl<L: Look> Looks for Looked<L> {
    fn add(&mut self, sample: &Envelope) {
        if let Some(sample) = L::Sensors::inside(sample) {
            self.large.add(sample);
            self.is_measured |= sample.bits_of("valid") != 0;
            self.look.add(self.together.with(sample));
        }
    }

    fn words(&self) -> Vec<String> {
        let fault = self.look.fault();
        let fault = fault.map(|fault| checks::advised(fault, self.map.as_ref()).to_string());
        let nothing = (!self.is_measured).then(|| {
            "nothing was measured: no row has a value beside the time; check that the sensors were on".to_owned()
        });
        let hints = fault.into_iter().chain(nothing);
        hints.chain(self.large.words()).collect()
    }
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
    pub fn new(description: &Description, map: Option<&Map>) -> Self {
        Self {
            looks: match description {
                Description::Excavator(d) => Looked::<checks::excavator::Fits>::boxed(d, map),
                Description::Loader(d) => Looked::<checks::loader::Fits>::boxed(d, map),
            },
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
        self.looks.add(sample);
    }

    /// The warnings as text, the same as of `heft estimate`.
    pub fn words(&self) -> Vec<String> {
        let rate = self.rate;
        let unit = recording::time_unit(&self.times, rate).map(|(step, unit)| {
            format!(
                "the rows are {step} s apart, and sensors.rate is {rate} Hz: is the time in {unit}?"
            )
        });
        let slow = recording::too_slow(&self.times, rate);
        let fast = recording::too_fast(&self.times, rate);
        let gaps = self.gaps.fault().map(|fault| fault.to_string());
        let gaps = gaps.or_else(|| self.gaps.words());
        let hints = unit
            .into_iter()
            .chain(slow)
            .chain(fast)
            .chain(gaps)
            .chain(self.looks.words());
        hints.collect()
    }
}
