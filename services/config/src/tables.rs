//! Complete description: parsing, changes, printing.

use crate::{Error, Errors, Keyed, Value, parse, print};

/// A complete description: the tables of a machine, and their form as text.
pub trait Tables: Keyed {
    /// Reads a description; keys that it does not name keep their defaults.
    ///
    /// # Errors
    /// All defects of the text, each with its line.
    fn parse(text: &str, file_name: &str) -> Result<Self, Errors> {
        parse::parse(text, file_name, None)
    }

    /// Sets one key, as `--set` does: `sensors.swing_velocity_std=0.008`.
    ///
    /// # Errors
    /// No such key, or a value outside its range or form; the description is then unchanged.
    fn set(&mut self, assignment: &str) -> Result<(), Error> {
        self.set_all(&[assignment])
    }

    /// Sets several keys in their order. Limits that are changed together need not be consistent one by one.
    ///
    /// # Errors
    /// As [`Self::set`]; the description is then unchanged.
    fn set_all(&mut self, assignments: &[impl AsRef<str>]) -> Result<(), Error> {
        parse::set_all(self, assignments)
    }

    /// The number under a key such as `sensors.swing_torque_std`; none if there is no such key or no number.
    fn number(&self, key: &str) -> Option<f64> {
        let (table, index) = self.place(key)?;
        match self.tables()[table].get(index) {
            Some(Value::Number(number)) => Some(number),
            _ => None,
        }
    }

    /// Sets a number, clamped to the key's range; false if there is no such key.
    fn set_number(&mut self, key: &str, value: f64) -> bool {
        let Some((table, index)) = self.place(key) else {
            return false;
        };
        let table = self.tables_mut().swap_remove(table);
        let range = table.keys()[index].range;
        let value = range.map_or(value, |range| value.clamp(range.low, range.high));
        table.set(index, &Value::Number(value))
    }

    /// The whole description with its comments; [`Self::parse`] returns the same value, every
    /// number to the last bit.
    fn to_toml(&self) -> String {
        print::print(self)
    }
}

impl<M: Keyed> Tables for M {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_and_set_within_their_range() {
        let mut d = crate::Excavator::default();
        assert_eq!(d.number("machine.nominal_damping"), Some(1500.0));
        assert!(d.set_number("sensors.rate", 1e9));
        assert_eq!(d.sensors.rate, 100_000.0);
        assert!(!d.set_number("machine.nothing", 1.0));
        assert_eq!(d.number("machine.nothing"), None);
    }
}
