//! What people see of a message: quantities with interval and verdict, by the tables of `view`.

use messages::{Envelope, Machine};
use steps::stages::Pipeline;
use view::estimate::Estimate;
use view::number;

/// A quantity of an estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Name of the field.
    pub key: &'static str,
    /// What people call it.
    pub label: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub std: f64,
    /// Whether heft believes it; of one without a verdict, whether it believes the headline.
    pub trusted: bool,
    /// Whether it is learnt over days, and does not change with a load.
    pub learnt: bool,
}

impl Quantity {
    /// "5 873 ± 61 kg m²".
    #[must_use]
    pub fn text(&self) -> String {
        number::with_std(self.value, self.std, &number::unit(self.unit))
    }

    /// "5 753 to 5 993".
    #[must_use]
    pub fn interval(&self) -> String {
        number::interval_95(self.value, self.std)
    }
}

/// What is learnt over days and does not change with a load, by its key.
const LEARNT: &[&str] = &["damping", "slip_stiffness"];

/// What is learnt of a kind of machine.
#[must_use]
pub fn learnt(machine: Machine) -> Vec<&'static str> {
    fn of<E: Estimate>() -> Vec<&'static str> {
        let keys = E::PARAMETERS.iter().map(|p| p.key);
        keys.filter(|key| LEARNT.contains(key)).collect()
    }
    match machine {
        Machine::Excavator => of::<messages::ExcavatorEstimate>(),
        Machine::Loader => of::<messages::LoaderEstimate>(),
    }
}

fn of<E: Estimate>(estimate: &E) -> Vec<Quantity> {
    let one = E::PARAMETERS.iter().map(|p| Quantity {
        key: p.key,
        label: p.label,
        unit: p.unit,
        value: p.value(estimate),
        std: p.std(estimate),
        trusted: match p.trusted {
            0 => estimate.trusted(),
            bit => estimate.flags() & bit != 0,
        },
        learnt: LEARNT.contains(&p.key),
    });
    one.filter(|q| q.value.is_finite() && q.std.is_finite() && q.std > 0.0)
        .collect()
}

/// The quantities of an estimate that have an interval, those that the machine is about first.
#[must_use]
pub fn quantities(envelope: &Envelope) -> Vec<Quantity> {
    match envelope {
        Envelope::ExcavatorEstimate(e) => of(e),
        Envelope::LoaderEstimate(e) => of(e),
        _ => Vec::new(),
    }
}

/// The first of them.
#[must_use]
pub fn headline(envelope: &Envelope) -> Option<Quantity> {
    quantities(envelope).into_iter().next()
}

/// What a load is told by: the payload where there is one.
#[must_use]
pub fn load(envelope: &Envelope) -> Option<Quantity> {
    let all = quantities(envelope);
    let payload = all.iter().find(|q| q.key == "payload").cloned();
    payload.or_else(|| all.into_iter().next())
}

/// The verdict in words.
#[must_use]
pub fn verdict(envelope: &Envelope) -> String {
    match envelope {
        Envelope::ExcavatorEstimate(e) => view::words::verdict(e),
        Envelope::LoaderEstimate(e) => view::words::verdict(e),
        _ => String::new(),
    }
}

/// The machine whose messages these are; empty for messages of every machine.
#[must_use]
pub fn kind_of(envelope: &Envelope) -> &'static str {
    match envelope {
        Envelope::ExcavatorEstimate(_) => Machine::Excavator.name(),
        Envelope::LoaderEstimate(_) => Machine::Loader.name(),
        _ => "",
    }
}

/// Name of the channel that a kind of machine is told by.
#[must_use]
pub fn main_channel(kind: &str) -> Option<&'static str> {
    let machine = Machine::from_name(kind)?;
    Pipeline::of(machine).main_output()?.name.rsplit('/').next()
}
