//! The quantities that heft is about: where they stand in the messages and how people write them.

use messages::{Envelope, Message, Receiver, Value, excavator_bits, loader_bits};
use view::number;

use crate::watch::Score;

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

/// All of them.
pub const QUANTITIES: &[Quantity] = &[
    inertia("excavator/inertia_ukf"),
    inertia("excavator/inertia_rls"),
    ratio("loader/cg_ukf"),
    height("loader/cg_ukf"),
    ratio("loader/cg_ekf"),
    height("loader/cg_ekf"),
];

const fn inertia(channel: &'static str) -> Quantity {
    Quantity {
        channel,
        label: "swing inertia",
        symbol: "J",
        unit: "kg m²",
        field: "inertia",
        std_field: "inertia_std",
        truth_field: "inertia",
        trusted_bit: excavator_bits::TRUSTED,
    }
}

const fn ratio(channel: &'static str) -> Quantity {
    Quantity {
        channel,
        label: "front share of the weight",
        symbol: "λ",
        unit: "",
        field: "cg_ratio",
        std_field: "cg_ratio_std",
        truth_field: "cg_ratio",
        trusted_bit: loader_bits::TRUSTED_RATIO,
    }
}

const fn height(channel: &'static str) -> Quantity {
    Quantity {
        channel,
        label: "height of the centre of gravity",
        symbol: "h",
        unit: "m",
        field: "cg_height",
        std_field: "cg_height_std",
        truth_field: "cg_height",
        trusted_bit: loader_bits::TRUSTED_HEIGHT,
    }
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

    /// The quantity on the live line; a tick says that it is trusted.
    pub fn short(&self, score: &Score) -> String {
        let truth = score.truth.map_or(String::new(), |t| {
            format!(" (true {})", self.number(t, score.std))
        });
        let verdict = if score.trusted { '✓' } else { '?' };
        format!(
            "{} {}{truth} {verdict}",
            self.symbol,
            self.text(score.value, score.std)
        )
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

    #[test]
    fn every_quantity_names_fields_that_exist() {
        use messages::{ExcavatorEstimate, ExcavatorTruth, LoaderEstimate, LoaderTruth};
        for q in QUANTITIES {
            let (estimate, truth) = if q.channel.starts_with("excavator") {
                (ExcavatorEstimate::FIELDS, ExcavatorTruth::FIELDS)
            } else {
                (LoaderEstimate::FIELDS, LoaderTruth::FIELDS)
            };
            for name in [q.field, q.std_field, "flags"] {
                assert!(estimate.iter().any(|f| f.name == name), "{name}");
            }
            assert!(truth.iter().any(|f| f.name == q.truth_field));
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
        assert_eq!(QUANTITIES[2].truth(&envelope), Some(0.45));
        assert_eq!(QUANTITIES[3].truth(&envelope), None);
    }
}
