//! A first map, and what it lacks.

use crate::signal::Sensors;

/// A first map of a file.
#[derive(Debug)]
pub struct Suggestion {
    /// The map.
    pub text: String,
    /// Signals that the machine needs and nothing was found for: of each group, one.
    pub missing: Vec<&'static [&'static str]>,
    /// Columns whose brackets hold no unit that heft knows, with what they hold.
    pub unknown: Vec<String>,
    /// How many signals were found.
    pub(crate) found: usize,
}

/// Groups of signals that a machine needs one of, and none was found.
pub(crate) fn missing<S: Sensors>(found: &[String]) -> Vec<&'static [&'static str]> {
    let is_missing = |group: &&[&str]| !group.iter().any(|s| found.iter().any(|f| f == s));
    S::REQUIRED.iter().copied().filter(is_missing).collect()
}
