//! A complete description: read, changed, printed.

use crate::{Error, Errors, Keyed, parse, print};

/// A complete description: the tables of a machine, and their form as text.
pub trait Tables: Keyed {
    /// Reads a description; keys that it does not name keep their defaults.
    ///
    /// # Errors
    /// Everything that is wrong with the text, each with its line.
    fn parse(text: &str, file_name: &str) -> Result<Self, Errors> {
        parse::parse(text, file_name)
    }

    /// Sets one key, as `--set` does: `sensors.swing_velocity_std=0.008`.
    ///
    /// # Errors
    /// No such key, or a value that it cannot have; the description is then unchanged.
    fn set(&mut self, assignment: &str) -> Result<(), Error> {
        self.set_all(&[assignment])
    }

    /// Sets several keys in their order. Limits that are moved together need not fit one by one.
    ///
    /// # Errors
    /// As [`Self::set`]; the description is then unchanged.
    fn set_all(&mut self, assignments: &[impl AsRef<str>]) -> Result<(), Error> {
        parse::set_all(self, assignments)
    }

    /// The whole description with its comments; [`Self::parse`] gives the same value back, every
    /// number to the last bit.
    #[must_use]
    fn to_toml(&self) -> String {
        print::print(self)
    }
}

impl<M: Keyed> Tables for M {}
