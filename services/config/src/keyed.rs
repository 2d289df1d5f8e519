//! Descriptions of the machines as tables of keys.

use estimation::keys::Table;
use messages::Machine;

use crate::{Description, Error};

/// A machine's tables of keys.
pub trait Keyed: Default + Clone {
    /// The machine.
    const MACHINE: Machine;
    /// The contents of a description of this machine.
    fn inside(description: &Description) -> Option<&Self>;
    /// All tables, in printed order.
    fn tables(&self) -> Vec<&dyn Table>;
    /// All tables, mutable.
    fn tables_mut(&mut self) -> Vec<&mut dyn Table>;
    /// Keys that are jointly at their defaults only on the reference machine, and its mass \[kg\].
    const REFERENCE: (&'static [&'static str], f64);
    /// Notes that a key is stated, and whether at its default.
    fn note(&mut self, path: &str, is_default: bool);
    /// The defaults of a machine of the described size.
    fn of_its_size(&self) -> Self {
        Self::default()
    }
    /// Place of a key such as `sensors.rate`: its table, and its index in that.
    fn place(&self, path: &str) -> Option<(usize, usize)> {
        let (table_name, name) = path.rsplit_once('.')?;
        let tables = self.tables();
        let at = tables.iter().position(|t| t.name() == table_name)?;
        let index = tables[at].keys().iter().position(|k| k.name == name)?;
        Some((at, index))
    }
    /// Contradictions between keys that are each in range (`file` and `line` left empty).
    fn contradictions(&self) -> Vec<Error>;
}

/// Implements the tables of a machine.
macro_rules! tables {
    ($name:ident, $machine:expr, $rules:path, $size:path, [$($table:ident),+]) => {
        impl $crate::keyed::Keyed for $name {
            const MACHINE: Machine = $machine;
            const REFERENCE: (&'static [&'static str], f64) =
                ($name::REFERENCE, $name::REFERENCE_MASS);
            fn note(&mut self, path: &str, is_default: bool) {
                $name::note(self, path, is_default);
            }
            fn inside(description: &$crate::Description) -> Option<&Self> {
                match description {
                    $crate::Description::$name(described) => Some(described),
                    _ => None,
                }
            }
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
