//! Known keys of any machine.

use messages::Machine;
use toml_edit::Document;

use crate::entries;

macro_rules! keys_of_machines {
    ($( $name:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// Number of a machine's keys in a text.
        pub(crate) fn known_keys(
            machine: Machine,
            document: &Document<String>,
            text: &str,
            file: &str,
        ) -> usize {
            match machine {
                $( Machine::$name => entries::known_keys::<crate::$name>(document, text, file), )*
            }
        }

        /// All keys of a machine, with their tables.
        pub fn keys(machine: Machine) -> Vec<&'static str> {
            match machine {
                $( Machine::$name => entries::all_keys::<crate::$name>(), )*
            }
        }
    };
}

messages::machines!(keys_of_machines);
