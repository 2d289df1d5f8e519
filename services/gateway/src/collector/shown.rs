//! The presentation of a message: quantities with interval and verdict, by the tables of `view`.

use messages::{Envelope, Machine};
use steps::stages::Pipeline;
use view::estimate::Estimate;
use view::number;

/// A quantity of an estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Name of the field.
    pub key: &'static str,
    /// Label for people.
    pub label: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub std: f64,
    /// Whether the estimate is trusted; for a quantity without a verdict, whether the headline quantity is.
    pub trusted: bool,
    /// Whether it is learnt over days and independent of the load.
    pub learnt: bool,
    /// Whether it is a load in the bucket.
    pub is_load: bool,
}

impl Quantity {
    /// "5 873 ± 61 kg m²".
    pub fn text(&self) -> String {
        number::with_std(self.value, self.std, &number::unit(self.unit))
    }

    /// "5 753 to 5 993".
    pub fn interval(&self) -> String {
        number::interval_95(self.value, self.std)
    }
}

/// Keys of the learnt parameters of a kind of machine.
pub fn learnt(machine: Machine) -> Vec<&'static str> {
    let rows = machine.shown().filter(|row| row.is_of_machine);
    rows.map(|row| row.name).collect()
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
        learnt: p.is_of_machine,
        is_load: p.is_load,
    });
    one.filter(|q| q.value.is_finite() && q.std.is_finite() && q.std > 0.0)
        .collect()
}

macro_rules! machines {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The quantities of an estimate that have an interval, headline quantities first.
        pub fn quantities(envelope: &Envelope) -> Vec<Quantity> {
            match envelope {
                $( Envelope::$estimate(e) => of(e), )*
                _ => Vec::new(),
            }
        }

        /// The verdict in words.
        pub fn verdict(envelope: &Envelope) -> String {
            match envelope {
                $( Envelope::$estimate(e) => view::words::verdict(e), )*
                _ => String::new(),
            }
        }

        /// The machine whose estimate this is; empty for other messages.
        pub fn kind_of(envelope: &Envelope) -> &'static str {
            match envelope {
                $( Envelope::$estimate(_) => Machine::$machine.name(), )*
                _ => "",
            }
        }
    };
}

messages::machines!(machines);

/// The first quantity of an estimate.
pub fn headline(envelope: &Envelope) -> Option<Quantity> {
    quantities(envelope).into_iter().next()
}

/// The quantity that reports a load: the payload where there is one.
pub fn load(envelope: &Envelope) -> Option<Quantity> {
    let all = quantities(envelope);
    let payload = all.iter().find(|q| q.is_load).cloned();
    payload.or_else(|| all.into_iter().next())
}

/// Name of the headline channel of a kind of machine.
pub fn main_channel(kind: &str) -> Option<&'static str> {
    let machine = Machine::from_name(kind)?;
    Some(Pipeline::of(machine).main_output()?.last_name())
}
