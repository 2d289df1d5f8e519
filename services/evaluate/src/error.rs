//! Errors of an evaluation.

use std::fmt;

/// Reason why an evaluation did not take place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// There is no table of that name.
    UnknownTable {
        /// The requested name.
        name: String,
        /// The known names.
        known: Vec<&'static str>,
    },
    /// No seed was run: none was requested, or the evaluation was interrupted before the first.
    NoSeeds,
    /// A simulation or an estimator refused its input.
    Refused(String),
}

impl Error {
    /// Wraps the error of a simulation or an estimator.
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
