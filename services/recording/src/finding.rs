//! What is wrong in data, and what to do.

use core::fmt;

use crate::Error;

/// A finding in data: what is wrong, and the remedy. Prints as two lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// What is wrong.
    pub what: String,
    /// The remedy.
    pub remedy: String,
}

impl Finding {
    /// From both.
    pub fn new(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            remedy: remedy.into(),
        }
    }

    /// The error of a file in which it stands at this place.
    pub(crate) fn at(self, place: impl Into<String>) -> Error {
        Error::new(self.what, place, self.remedy)
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}\n  what to do: {}", self.what, self.remedy)
    }
}
