//! Errors of the construction of a step.

use core::fmt;

use config::{Description, Keyed};
use messages::Machine;

/// Why a step cannot be constructed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The machine has no method of that name.
    UnknownMethod {
        /// The machine.
        machine: &'static str,
        /// The name that was given.
        name: String,
        /// The names of the existing methods.
        known: Vec<&'static str>,
    },
    /// The description is for this machine, the step for another.
    OtherMachine(Machine),
    /// The source lacks a column that the method needs.
    MissingColumn {
        /// The method.
        method: String,
        /// The missing column, or the columns of which one suffices.
        column: &'static str,
    },
    /// The description has a value that the method cannot use, or the method runs in another
    /// process.
    Settings(String),
}

impl Error {
    pub(crate) fn settings(error: impl fmt::Display) -> Self {
        Self::Settings(error.to_string())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownMethod {
                machine,
                name,
                known,
            } => write!(
                f,
                "the {machine} has no method `{name}`; methods are {}",
                known.join(", ")
            ),
            Self::OtherMachine(machine) => {
                write!(f, "the machine file is for the {machine}, the step is not")
            }
            Self::MissingColumn { method, column } => write!(
                f,
                "the method {method} needs the column {column}, which the input does not have"
            ),
            Self::Settings(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for Error {}

/// The contents of a description of this machine.
///
/// # Errors
/// It is of another machine.
pub fn described<M: Keyed>(description: &Description) -> Result<&M, Error> {
    M::inside(description).ok_or(Error::OtherMachine(description.machine()))
}
