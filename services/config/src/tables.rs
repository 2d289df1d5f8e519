//! The descriptions of the machines as tables of keys.

use estimation::keys::Table;
use messages::Machine;

use crate::{Error, Errors, parse, print};

/// A complete description: a machine's tables.
pub trait Tables: Default + Clone {
    /// Which machine.
    const MACHINE: Machine;
    /// All tables, in the order in which they are printed.
    fn tables(&self) -> Vec<&dyn Table>;
    /// All tables, to write.
    fn tables_mut(&mut self) -> Vec<&mut dyn Table>;
    /// The defaults of a machine of the size that this description tells.
    #[must_use]
    fn of_its_size(&self) -> Self {
        Self::default()
    }
    /// What contradicts itself between keys that are each in range (`file` and `line` left empty).
    fn contradictions(&self) -> Vec<Error>;

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

/// Gives a machine its tables.
macro_rules! tables {
    ($name:ident, $machine:expr, $rules:path, $size:path, [$($table:ident),+]) => {
        impl $crate::Tables for $name {
            const MACHINE: Machine = $machine;
            fn tables(&self) -> Vec<&dyn $crate::Table> {
                vec![$( &self.$table ),+]
            }
            fn tables_mut(&mut self) -> Vec<&mut dyn $crate::Table> {
                vec![$( &mut self.$table ),+]
            }
            fn of_its_size(&self) -> Self {
                $size(self)
            }
            fn contradictions(&self) -> Vec<$crate::Error> {
                $rules(self)
            }
        }
    };
}
pub(crate) use tables;
