//! The properties of an estimate for report, live page and terminal: its parameters with label, unit, truth and verdict, in one
//! table per machine.

use std::marker::PhantomData;

use messages::{Field, HEAD, Machine, Message, Value};
use sheet::Quantity;

use crate::judgement::Judgement;
use crate::panels::Panel;

/// An estimate message of one machine.
pub trait Estimate: recording::csv::Estimate {
    /// The truth that belongs to it.
    type Truth: Message;
    /// Its machine.
    const MACHINE: Machine;
    /// Its parameters, headline quantities first.
    const PARAMETERS: &'static [Parameter<Self, Self::Truth>];
    /// Rule for its normalised innovations.
    const INNOVATION: InnovationRule;

    /// The conditions of the verdict, by their bits; a name that ends in "trusted" is the verdict.
    const CONDITIONS: &'static [(&'static str, u32)];
    /// Name of a stretch of motion, and least speed of one [rad/s, m/s].
    const MOTION_NAME: (&'static str, f64);
    /// Keys of the parameters that are reported for each stretch of motion.
    const STRETCH: &'static [&'static str];
    /// Whether each stretch carries a load of its own, so that loads are summed over them.
    const LOAD_EACH: bool;

    /// Speed of the machine [rad/s, m/s].
    fn motion(&self) -> f64;
    /// Normalised innovation squared, 0 where no measurement was accepted.
    fn nis(&self) -> f64;
    /// Verdict on each headline parameter.
    fn judgements(&self) -> Vec<Judgement>;
    /// Forgetting factors of inertia, damping and torque, if the method has them.
    fn forgetting(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Panels of this machine's estimators only.
    fn own_panels(_: &[Self]) -> Vec<Panel> {
        Vec::new()
    }

    /// The parameters with a verdict, in the order of the judgements.
    fn headlines() -> impl Iterator<Item = &'static Parameter<Self, Self::Truth>> {
        Self::PARAMETERS.iter().filter(|p| p.headline())
    }

    /// Verdict bits.
    fn flags(&self) -> u32 {
        self.codes().flags
    }

    /// Name of the method.
    fn method_name(&self) -> &'static str {
        let method = Self::METHODS.get(self.codes().method as usize);
        method.copied().unwrap_or("unknown method")
    }

    /// Whether every headline parameter is trusted.
    fn trusted(&self) -> bool {
        Self::headlines().all(|p| self.flags() & p.trusted != 0)
    }
}

/// The method of the last estimate.
pub(crate) fn method<E: Estimate>(estimates: &[E]) -> &'static str {
    estimates.last().map_or("no estimate", E::method_name)
}

/// Averaging and limit of the normalised innovation squared of a machine's filters.
#[derive(Debug, Clone, Copy)]
pub struct InnovationRule {
    /// Samples in the moving mean.
    pub window: usize,
    /// Measurements per sample.
    pub measurements: f64,
    /// Limit of the mean, above which `consistent` is not set.
    pub limit: f64,
}

/// A quantity of an estimate: a row of the sheet, with its places in the messages.
#[derive(Debug, Clone, Copy)]
pub struct Parameter<E, T> {
    /// Name of the field, as in the CSV.
    pub key: &'static str,
    /// Label for people.
    pub label: &'static str,
    /// Unit, as in [`messages::Field::unit`].
    pub unit: &'static str,
    /// Physical range; a plot's axis does not exceed it.
    pub possible: (f64, f64),
    /// Bit of [`Estimate::flags`] for trust in it; 0 if it has no verdict.
    pub trusted: u32,
    /// Bit that is set while the motion is informative of it; errors are counted there.
    pub excited: u32,
    /// Whether it is a load in the bucket, so that its sum over the stretches is meaningful.
    pub is_load: bool,
    /// Whether it is a constant of the machine, independent of the load.
    pub is_of_machine: bool,
    /// Bits of `estimated` for its presence; any of them, if it has none of its own.
    estimated: u32,
    /// Indices of value, standard deviation and `estimated` in the estimate.
    value: Option<usize>,
    std: Option<usize>,
    bits: Option<usize>,
    /// Indices of value and `known` in the truth.
    truth: Option<usize>,
    known: Option<usize>,
    messages: PhantomData<fn(&E, &T)>,
}

/// The parameters of a machine from the rows of its sheet that are shown to people, in order.
pub(crate) const fn parameters<E: Message, T: Message, const N: usize>(
    quantities: &'static [Quantity],
) -> [Parameter<E, T>; N] {
    let shown = sheet::shown::<N>(quantities);
    let mut parameters = [Parameter::of(shown[0]); N];
    let mut i = 1;
    while i < N {
        parameters[i] = Parameter::of(shown[i]);
        i += 1;
    }
    parameters
}

/// Index of a field.
const fn place(fields: &[Field], name: &str) -> Option<usize> {
    let mut i = 0;
    while i < fields.len() {
        if is_same(fields[i].name.as_bytes(), name.as_bytes()) {
            return Some(i);
        }
        i += 1;
    }
    None
}

const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

/// A number of a message, NaN if absent.
fn number<M: Message>(message: &M, place: Option<usize>) -> f64 {
    let value = place.and_then(|place| message.get(place));
    value.map_or(f64::NAN, Value::as_f64)
}

fn bits<M: Message>(message: &M, place: Option<usize>) -> u32 {
    match place.and_then(|place| message.get(place)) {
        Some(Value::U32(bits)) => bits,
        _ => 0,
    }
}

impl<E: Message, T: Message> Parameter<E, T> {
    const fn of(q: &Quantity) -> Self {
        Self {
            key: q.name,
            label: q.label,
            unit: q.unit,
            possible: q.range,
            trusted: if q.is_headline { q.trusted } else { 0 },
            excited: q.excited,
            is_load: q.is_load,
            is_of_machine: q.is_of_machine,
            estimated: q.estimated,
            value: place(E::FIELDS, q.name),
            std: match q.std {
                Some(std) => place(E::FIELDS, std),
                None => None,
            },
            bits: place(E::FIELDS, "estimated"),
            truth: place(T::FIELDS, q.name),
            known: place(T::FIELDS, "known"),
            messages: PhantomData,
        }
    }

    fn is_estimated(&self, estimate: &E) -> bool {
        let estimated = bits(estimate, self.bits);
        estimated != 0 && estimated & self.estimated == self.estimated
    }

    /// The value, NaN if the method does not estimate it.
    pub fn value(&self, estimate: &E) -> f64 {
        let value = self.value.filter(|_| self.is_estimated(estimate));
        number(estimate, value)
    }

    /// Its standard deviation, NaN if absent.
    pub fn std(&self, estimate: &E) -> f64 {
        let std = self.std.filter(|_| self.is_estimated(estimate));
        number(estimate, std)
    }

    /// The truth, NaN if unknown: bit `i` of `known` belongs to the i-th field of the message itself.
    pub fn truth(&self, truth: &T) -> f64 {
        let known = bits(truth, self.known);
        number(
            truth,
            self.truth.filter(|place| known >> (place - HEAD) & 1 == 1),
        )
    }

    /// Whether it has a verdict.
    pub fn headline(&self) -> bool {
        self.trusted != 0
    }

    /// "Swing inertia [kg m²]".
    pub fn title(&self) -> String {
        if self.unit.is_empty() {
            format!("{} [–]", self.label)
        } else {
            format!("{} [{}]", self.label, crate::number::unit(self.unit))
        }
    }
}
