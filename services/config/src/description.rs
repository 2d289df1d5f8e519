//! A description of any machine.

use messages::Machine;
use toml_edit::Document;

use crate::{Error, Errors, Excavator, Loader, Tables, parse};

/// Everything that must be said once per machine.
macro_rules! descriptions {
    ($( $(#[$doc:meta])* $name:ident, )*) => {
        /// A description of any machine.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Description { $( $(#[$doc])* $name(Box<$name>), )* }

        impl Description {
            /// Reads a description of whichever machine the text is for: `machine.kind` says so, or
            /// the keys do. `machine` is taken where neither does.
            ///
            /// # Errors
            /// Everything that is wrong with the text, each with its line; or that the machine is
            /// unclear.
            pub fn parse(
                text: &str,
                file_name: &str,
                machine: Option<Machine>,
            ) -> Result<Self, Errors> {
                let Some(machine) = parse::machine(text, file_name)?.or(machine) else {
                    return Err(unclear(file_name).into());
                };
                Ok(match machine {
                    $( Machine::$name => Self::$name(Box::new($name::parse(text, file_name)?)), )*
                })
            }

            /// The defaults of a machine.
            #[must_use]
            pub fn default_of(machine: Machine) -> Self {
                match machine {
                    $( Machine::$name => Self::$name(Box::default()), )*
                }
            }

            /// Which machine.
            #[must_use]
            pub fn machine(&self) -> Machine {
                match self {
                    $( Self::$name(_) => $name::MACHINE, )*
                }
            }

            /// Sets several keys in their order, as several `--set` do.
            ///
            /// # Errors
            /// No such key, a value that it cannot have, or an outcome that contradicts itself.
            pub fn set_all(&mut self, assignments: &[impl AsRef<str>]) -> Result<(), Error> {
                match self {
                    $( Self::$name(m) => m.set_all(assignments), )*
                }
            }

            /// The whole description with its comments.
            #[must_use]
            pub fn to_toml(&self) -> String {
                match self {
                    $( Self::$name(m) => m.to_toml(), )*
                }
            }
        }

        /// How many keys of a machine a text names.
        pub(crate) fn known_keys(
            machine: Machine,
            document: &Document<String>,
            text: &str,
            file: &str,
        ) -> usize {
            match machine {
                $( Machine::$name => parse::known_keys::<$name>(document, text, file), )*
            }
        }

        /// All keys of a machine, with their tables.
        pub(crate) fn all_keys(machine: Machine) -> Vec<String> {
            match machine {
                $( Machine::$name => parse::all_keys::<$name>(), )*
            }
        }
    };
}

descriptions! {
    /// Excavator.
    Excavator,
    /// Wheel loader.
    Loader,
}

impl Description {
    /// Sets one key, as `--set` does.
    ///
    /// # Errors
    /// No such key, or a value that it cannot have.
    pub fn set(&mut self, assignment: &str) -> Result<(), Error> {
        self.set_all(&[assignment])
    }
}

fn unclear(file_name: &str) -> Error {
    Error {
        what: "the description does not say which machine it is for".into(),
        file: file_name.into(),
        line: None,
        key: "machine.kind".into(),
        remedy: "write kind = \"excavator\" or kind = \"loader\" under [machine]".into(),
    }
}
