//! Keys in a text, for any machine.

use messages::Machine;

use crate::{Error, parse};

macro_rules! texts_of_machines {
    ($( $name:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// Whether a text states a key of a machine.
        pub(crate) fn states(machine: Machine, text: &str, key: &str) -> bool {
            match machine {
                $( Machine::$name => parse::states::<crate::$name>(text, key), )*
            }
        }

        /// Error for a key or table that is nearly one of a machine's.
        pub(crate) fn misspelt(machine: Machine, text: &str, file: &str) -> Option<Error> {
            match machine {
                $( Machine::$name => parse::misspelt::<crate::$name>(text, file), )*
            }
        }
    };
}

messages::machines!(texts_of_machines);
