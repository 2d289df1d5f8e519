//! The quantities that heft is about: where they stand in the messages and how people write them.

use messages::{Envelope, Machine, Message, Receiver, Value};
use view::number;

use crate::machines;

/// An estimated quantity.
#[derive(Debug)]
pub struct Quantity {
    /// Channel of the estimate.
    pub channel: &'static str,
    /// What people call it.
    pub label: &'static str,
    /// Its symbol on the live line.
    pub symbol: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Field of the estimate.
    pub field: &'static str,
    /// Field of its standard deviation.
    pub std_field: &'static str,
    /// Field of the truth.
    pub truth_field: &'static str,
    /// Flag that says that it may be believed.
    pub trusted_bit: u32,
}

/// Those of all machines.
pub fn all() -> impl Iterator<Item = &'static Quantity> {
    let machines = Machine::ALL.into_iter();
    machines.flat_map(|machine| machines::entry(machine).told())
}

impl Quantity {
    /// `value ± std`, rounded to two digits of the standard deviation.
    pub fn text(&self, value: f64, std: f64) -> String {
        number::with_std(value, std, self.unit)
    }

    /// A value without its unit, rounded like an estimate of this standard deviation.
    pub fn number(&self, value: f64, std: f64) -> String {
        number::grouped(value, number::decimals(std))
    }

    /// The true value in a truth message, if it is known.
    pub fn truth(&self, message: &Envelope) -> Option<f64> {
        message.open(Truth(self.truth_field))
    }
}

struct Truth(&'static str);

impl Receiver for Truth {
    type Output = Option<f64>;

    fn receive<M: Message>(self, message: &M) -> Option<f64> {
        let index = M::index(self.0)?;
        // Bit i of `known` belongs to the i-th field of the message itself.
        let own = index.checked_sub(messages::HEAD)?;
        let Some(Value::U32(known)) = message.get(M::index("known")?) else {
            return None;
        };
        (known >> own & 1 == 1).then(|| message.get(index).map(Value::as_f64))?
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::channels;

    #[test]
    fn every_quantity_names_fields_that_exist() {
        struct Names;
        impl channels::Visitor for Names {
            type Output = &'static [messages::Field];
            fn visit<M: Message>(self) -> Self::Output {
                M::FIELDS
            }
        }
        for q in all() {
            let (machine, _) = q.channel.split_once('/').expect("a machine's");
            let fields = |channel: &str| {
                channels::find(channel)
                    .expect("a channel")
                    .payload
                    .visit(Names)
            };
            let has = |channel: &str, name| fields(channel).iter().any(|f| f.name == name);
            for name in [q.field, q.std_field, "flags"] {
                assert!(has(q.channel, name), "{name}");
            }
            assert!(has(&format!("{machine}/truth"), q.truth_field));
        }
    }

    #[test]
    fn truth_is_taken_only_where_it_is_known() {
        use messages::LoaderTruth;
        let mut truth = LoaderTruth {
            cg_height: 0.9,
            cg_ratio: 0.45,
            ..LoaderTruth::default()
        };
        truth.known = 1 << 4; // the fifth field is the ratio
        let envelope = truth.envelope();
        let of = |field| {
            all()
                .find(|q| q.field == field)
                .expect("a quantity")
                .truth(&envelope)
        };
        assert_eq!((of("cg_ratio"), of("cg_height")), (Some(0.45), None));
    }
}
