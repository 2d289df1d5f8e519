//! A first map, and what it lacks.

use messages::Machine;

use super::table::LINKS;
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
    /// Columns that are in a unit of something else than the signal that they are called, with what they are in.
    pub of_others: Vec<String>,
    /// How many signals were found.
    pub(crate) found: usize,
}

/// Groups of signals that a machine needs one of, and none was found.
pub(crate) fn missing<S: Sensors>(found: &[String]) -> Vec<&'static [&'static str]> {
    let is_missing = |group: &&[&str]| !group.iter().any(|s| found.iter().any(|f| f == s));
    let links = LINKS.each_ref().map(std::slice::from_ref);
    // One angle without the others is no posture.
    let has_some = LINKS.iter().any(|link| found.iter().any(|f| f == link))
        && S::MACHINE == Machine::Excavator;
    let links = links.into_iter().filter(|_| has_some);
    S::REQUIRED
        .iter()
        .copied()
        .chain(links)
        .filter(is_missing)
        .collect()
}
