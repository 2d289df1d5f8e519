//! The keys of whichever machine.

use messages::Machine;
use toml_edit::Document;

use crate::entries;

macro_rules! keys_of_machines {
    ($( $name:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// How many keys of a machine a text names.
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

        /// Whether a text states a key of a machine.
        pub(crate) fn states(machine: Machine, text: &str, key: &str) -> bool {
            match machine {
                $( Machine::$name => crate::parse::states::<crate::$name>(text, key), )*
            }
        }

        /// A key or table of a text that is nearly one of a machine's.
        pub(crate) fn misspelt(machine: Machine, text: &str, file: &str) -> Option<crate::Error> {
            match machine {
                $( Machine::$name => crate::parse::misspelt::<crate::$name>(text, file), )*
            }
        }

        /// All keys of a machine, with their tables.
        pub(crate) fn all_keys(machine: Machine) -> Vec<&'static str> {
            match machine {
                $( Machine::$name => entries::all_keys::<crate::$name>(), )*
            }
        }
    };
}

messages::machines!(keys_of_machines);
