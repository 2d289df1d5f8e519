//! What can go wrong in an evaluation.

use std::fmt;

/// Why an evaluation did not take place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// There is no table of that name.
    UnknownTable {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<&'static str>,
    },
    /// No seed was run: none was asked for, or the evaluation was interrupted before the first.
    NoSeeds,
    /// A simulation or an estimator refused what it was given.
    Refused(String),
}

impl Error {
    /// Wraps what a simulation or an estimator said.
    pub fn refused(reason: impl fmt::Display) -> Self {
        Self::Refused(reason.to_string())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownTable { name, known } => {
                write!(f, "no table `{name}`; tables are {}", known.join(", "))
            }
            Self::NoSeeds => f.write_str("no seed was evaluated"),
            Self::Refused(reason) => f.write_str(reason),
        }
    }
}

impl std::error::Error for Error {}
