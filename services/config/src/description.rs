//! A description of any machine.

use std::collections::BTreeMap;

use crate::{Error, Errors, Key, Keyed, Tables, parse, stated};
use messages::Machine;

macro_rules! descriptions {
    ($( $name:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        $( pub use crate::$module::$name; )*

        /// A description of any machine.
        #[derive(Debug, Clone, PartialEq)]
        #[allow(missing_docs, reason = "each is the machine of its name")]
        pub enum Description { $( $name(Box<$name>), )* }

        impl Description {
            /// Reads a description of the machine that the text is for: `machine.kind` or
            /// the keys determine it. `machine` is the default where neither does.
            ///
            /// # Errors
            /// All defects of the text, each with its line; or the machine is
            /// undetermined.
            pub fn parse(
                text: &str,
                file_name: &str,
                machine: Option<Machine>,
            ) -> Result<Self, Errors> {
                Self::parse_of_class(text, file_name, machine, None)
            }

            /// The same, for a machine of the mass `class` where the text states none \[kg\].
            ///
            /// # Errors
            /// As [`Self::parse`].
            pub fn parse_of_class(
                text: &str,
                file_name: &str,
                machine: Option<Machine>,
                class: Option<f64>,
            ) -> Result<Self, Errors> {
                let Some(machine) = parse::machine(text, file_name)?.or(machine) else {
                    return Err(unclear(text, file_name).into());
                };
                Ok(match machine {
                    $( Machine::$name => Self::$name(Box::new(parse::parse(text, file_name, class)?)), )*
                })
            }

            /// The defaults of a machine.
            pub fn default_of(machine: Machine) -> Self {
                match machine {
                    $( Machine::$name => Self::$name(Box::default()), )*
                }
            }

            /// The machine that it describes.
            pub fn machine(&self) -> Machine {
                match self {
                    $( Self::$name(_) => $name::MACHINE, )*
                }
            }

            /// Rate of the machine's sensors \[Hz\].
            pub fn rate(&self) -> f64 {
                match self {
                    $( Self::$name(m) => m.sensors.rate, )*
                }
            }

            /// Whether a machine's text states a key itself, at any value. A printed description of the reference machine states none.
            pub fn states(machine: Machine, text: &str, key: &str) -> bool {
                match machine {
                    $( Machine::$name => parse::states::<$name>(text, key), )*
                }
            }

            /// Error for a key or table that is nearly one of a machine's.
            fn misspelt(machine: Machine, text: &str, file: &str) -> Option<Error> {
                match machine {
                    $( Machine::$name => parse::misspelt::<$name>(text, file), )*
                }
            }

            /// Sets several keys in their order, as several `--set` do.
            ///
            /// # Errors
            /// No such key, a value outside its range or form, or a result that contradicts itself.
            pub fn set_all(&mut self, assignments: &[impl AsRef<str>]) -> Result<(), Error> {
                match self {
                    $( Self::$name(m) => m.set_all(assignments), )*
                }
            }

            /// The number under a key; none if there is no such key or no number.
            pub fn number(&self, key: &str) -> Option<f64> {
                match self {
                    $( Self::$name(m) => m.number(key), )*
                }
            }

            /// The stated keys: those that differ from the defaults of a machine of its size, with their values in TOML.
            pub fn stated(&self) -> BTreeMap<&'static str, String> {
                match self {
                    $( Self::$name(m) => stated::stated(m.as_ref()), )*
                }
            }

            /// The numbers that are not stated and follow from the machine's mass.
            pub fn of_mass(&self) -> Vec<(Key, f64)> {
                match self {
                    $( Self::$name(m) => stated::of_mass(m.as_ref()), )*
                }
            }

            /// The whole description with its comments.
            pub fn to_toml(&self) -> String {
                match self {
                    $( Self::$name(m) => m.to_toml(), )*
                }
            }
        }
    };
}

messages::machines!(descriptions);

impl Description {
    /// Sets one key, as `--set` does.
    ///
    /// # Errors
    /// No such key, or a value outside its range or form.
    pub fn set(&mut self, assignment: &str) -> Result<(), Error> {
        self.set_all(&[assignment])
    }

    /// The keys whose stated values differ from an earlier description of this machine, given as [`Self::stated`] of any version of
    /// heft. A new key at its default is not among them.
    pub fn changed_since(&self, stated: &BTreeMap<String, String>) -> Vec<String> {
        stated::changed(self.machine(), &self.stated(), stated)
    }
}

fn unclear(text: &str, file_name: &str) -> Error {
    let misspelt = |machine| Description::misspelt(machine, text, file_name);
    if let Some(error) = Machine::ALL.into_iter().find_map(misspelt) {
        return error;
    }
    let kinds = Machine::ALL.map(|m| format!("kind = \"{m}\"")).join(" or ");
    Error {
        what: "the machine file does not say which machine it is for".into(),
        file: file_name.into(),
        line: None,
        key: "machine.kind".into(),
        remedy: format!("write {kinds} under [machine]"),
    }
}
