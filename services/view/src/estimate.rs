//! What report, live page and terminal need to know of an estimate: its parameters with label,
//! unit, truth and verdict, in one table per machine.

/// A parameter without verdict, whose errors count while the bit `$excited` is set; `$truth` says where the truth of it stands.
macro_rules! parameter {
    ($excited:expr, $key:literal, $label:literal, $unit:literal, $possible:expr, $value:ident, $std:expr, $bit:expr, $truth:expr) => {
        $crate::estimate::Parameter {
            key: $key,
            label: $label,
            unit: $unit,
            possible: $possible,
            value: |e| e.$value,
            std: $std,
            estimated: |e| e.estimated & $bit != 0,
            truth: $truth,
            trusted: 0,
            excited: $excited,
        }
    };
}
pub(crate) use parameter;

use messages::{Machine, Message};

use crate::panels::Panel;
use crate::run::Estimator;
use crate::words::Judgement;

/// An estimate message of one machine.
pub trait Estimate: Message {
    /// The truth that belongs to it.
    type Truth: Message;
    /// Whose.
    const MACHINE: Machine;
    /// Names of the methods, indexed by [`Estimate::method`].
    const METHODS: &'static [&'static str];
    /// Its parameters, those that the machine is about first.
    const PARAMETERS: &'static [Parameter<Self, Self::Truth>];
    /// How its normalised innovations are judged.
    const INNOVATION: InnovationRule;

    /// The conditions of the verdict, by their bits; a name that ends in "trusted" is the verdict.
    const CONDITIONS: &'static [(&'static str, u32)];
    /// What a stretch of motion is called, and the least speed of one [rad/s, m/s].
    const MOTION_NAME: (&'static str, f64);
    /// Keys of the parameters that are told of each stretch of motion.
    const STRETCH: &'static [&'static str];
    /// Keys of those whose sum over the stretches means something.
    const SUMMED: &'static [&'static str];

    /// How fast the machine moves [rad/s, m/s].
    fn motion(&self) -> f64;
    /// Index of the method.
    fn method(&self) -> u32;
    /// Verdict bits.
    fn flags(&self) -> u32;
    /// Normalised innovation squared, 0 where no measurement was accepted.
    fn nis(&self) -> f64;
    /// What heft says of each headline parameter.
    fn judgements(&self) -> Vec<Judgement>;
    /// Forgetting factors of inertia, damping and torque, where the method has them.
    fn forgetting(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Panels that only this machine's estimators have.
    fn own_panels(_: &Estimator<Self>) -> Vec<Panel> {
        Vec::new()
    }

    /// Name of the method.
    fn method_name(&self) -> &'static str {
        usize::try_from(self.method())
            .ok()
            .and_then(|i| Self::METHODS.get(i))
            .copied()
            .unwrap_or("unknown method")
    }

    /// Whether every headline parameter is trusted.
    fn trusted(&self) -> bool {
        Self::PARAMETERS
            .iter()
            .filter(|p| p.headline())
            .all(|p| self.flags() & p.trusted != 0)
    }
}

/// How the normalised innovation squared of a machine's filters is averaged and judged.
#[derive(Debug, Clone, Copy)]
pub struct InnovationRule {
    /// Samples in the moving mean.
    pub window: usize,
    /// Measurements a sample.
    pub measurements: f64,
    /// The mean above which `consistent` goes off.
    pub limit: f64,
}

/// A quantity of an estimate.
#[derive(Debug)]
pub struct Parameter<E, T> {
    /// Name of the field, as in the CSV.
    pub key: &'static str,
    /// What people call it.
    pub label: &'static str,
    /// Unit, as in [`messages::Field::unit`].
    pub unit: &'static str,
    /// What it can be, in the machine as it is built; a plot's axis goes no further.
    pub possible: (f64, f64),
    pub(crate) value: fn(&E) -> f64,
    pub(crate) std: Option<fn(&E) -> f64>,
    pub(crate) estimated: fn(&E) -> bool,
    pub(crate) truth: Option<fn(&T) -> Option<f64>>,
    /// Bit of [`Estimate::flags`] that says that it may be believed; 0 where there is no verdict.
    pub trusted: u32,
    /// Bit that says that the motion informs about it; errors are counted there.
    pub excited: u32,
}

/// Any number.
pub(crate) const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
/// No negative number.
pub(crate) const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);

/// A true value, where its bit of `known` says so.
pub(crate) fn known(known: u32, bit: u32, value: f64) -> Option<f64> {
    (known & (1 << bit) != 0).then_some(value)
}

impl<E, T> Parameter<E, T> {
    /// The value, NaN where the method does not estimate it.
    pub fn value(&self, estimate: &E) -> f64 {
        if (self.estimated)(estimate) {
            (self.value)(estimate)
        } else {
            f64::NAN
        }
    }

    /// Its standard deviation, NaN where there is none.
    pub fn std(&self, estimate: &E) -> f64 {
        match self.std {
            Some(std) if (self.estimated)(estimate) => std(estimate),
            _ => f64::NAN,
        }
    }

    /// The truth, NaN where it is not known.
    pub fn truth(&self, truth: &T) -> f64 {
        self.truth.and_then(|f| f(truth)).unwrap_or(f64::NAN)
    }

    /// Whether heft gives a verdict on it.
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
