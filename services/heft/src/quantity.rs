//! The estimated quantities: their fields in the messages, and their texts.

use messages::{Envelope, Machine, Message, Receiver, Value};
use view::number;

/// An estimated quantity with a verdict of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// Channel of the estimate.
    pub channel: &'static str,
    /// Its row in the sheet; the truth has it under the same name.
    pub row: &'static sheet::Quantity,
    /// Field of its standard deviation.
    pub std: &'static str,
}

/// The quantities of a channel of estimates, the headline first.
pub fn of_channel(channel: &'static str) -> impl Iterator<Item = Quantity> {
    let machine = channel.split_once('/');
    let machine = machine.and_then(|(machine, _)| Machine::from_name(machine));
    let rows = machine.into_iter().flat_map(Machine::shown);
    rows.filter(|row| row.is_headline).filter_map(move |row| {
        let std = row.std?;
        Some(Quantity { channel, row, std })
    })
}

impl Quantity {
    /// Its label within a sentence: the first letter is small.
    pub fn label(&self) -> String {
        let mut letters = self.row.label.chars();
        let first = letters.next().map(char::to_lowercase);
        first.into_iter().flatten().chain(letters).collect()
    }

    /// The same for a line that has little room: "swing inertia", "height".
    pub fn short(&self) -> String {
        let label = self.label();
        let of = label.split_once(" of the ");
        of.map_or(label.clone(), |(first, _)| first.to_owned())
    }

    /// `value ± std`, rounded to two digits of the standard deviation.
    pub fn text(&self, value: f64, std: f64) -> String {
        number::with_std(value, std, &number::unit(self.row.unit))
    }

    /// A value without its unit, rounded like an estimate of this standard deviation.
    pub fn number(&self, value: f64, std: f64) -> String {
        number::grouped(value, number::decimals(std))
    }

    /// The true value in a truth message, if it is known.
    pub fn truth(&self, message: &Envelope) -> Option<f64> {
        truth(message, self.row.name)
    }
}

/// The true value of this name in a truth message, if it is known.
pub fn truth(message: &Envelope, name: &'static str) -> Option<f64> {
    message.open(Truth(name))
}

struct Truth(&'static str);

impl Receiver for Truth {
    type Output = Option<f64>;

    fn receive<M: Message>(self, message: &M) -> Option<f64> {
        let index = M::index(self.0)?;
        // Bit i of `known` belongs to the i-th field of the message itself.
        let own = index.checked_sub(messages::HEAD)?;
        (message.bits_of("known") >> own & 1 == 1).then(|| message.get(index).map(Value::as_f64))?
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::channels;
    use steps::stages::Pipeline;

    #[test]
    fn every_channel_of_estimates_has_quantities_whose_fields_exist() {
        for machine in Machine::ALL {
            for channel in Pipeline::of(machine).estimates() {
                assert!(of_channel(channel.name).next().is_some());
                for q in of_channel(channel.name) {
                    let fields = |channel: &str| {
                        let channel = channels::find(channel).expect("a channel");
                        channel.payload.shape().fields
                    };
                    let has = |channel: &str, name| fields(channel).iter().any(|f| f.name == name);
                    for name in [q.row.name, q.std, "flags"] {
                        assert!(has(q.channel, name), "{name}");
                    }
                    assert!(has(&format!("{machine}/truth"), q.row.name));
                }
            }
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
            of_channel("loader/cg_ukf")
                .find(|q| q.row.name == field)
                .expect("a quantity")
                .truth(&envelope)
        };
        assert_eq!((of("cg_ratio"), of("cg_height")), (Some(0.45), None));
    }
}
