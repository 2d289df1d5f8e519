//! A first map, and what it lacks.

use crate::signal::Sensors;

/// Angles of links, each from the one before it.
pub(super) const LINKS: [&str; 3] = ["boom_angle", "arm_angle", "bucket_angle"];

/// A first map of a file.
#[derive(Debug)]
pub struct Suggestion {
    /// The map.
    pub text: String,
    /// Signals that the machine needs and nothing was found for: of each group, one.
    pub missing: Vec<&'static [&'static str]>,
    /// Columns whose brackets hold no unit that heft knows, with what they hold.
    pub unknown: Vec<String>,
    /// Columns in `1/s`, which may be radians or turns.
    pub of_second: Vec<String>,
    /// Columns that are in a unit of something else than the signal that they are called, with what they are in.
    pub of_others: Vec<String>,
    /// Links whose angles were not found, where that of another was.
    pub links: Vec<&'static str>,
    /// How many signals were found.
    pub(crate) found: usize,
}

/// Groups of signals that a machine needs one of, and none was found.
pub(crate) fn missing<S: Sensors>(found: &[String]) -> Vec<&'static [&'static str]> {
    let is_missing = |group: &&[&str]| !group.iter().any(|s| found.iter().any(|f| f == s));
    S::REQUIRED.iter().copied().filter(is_missing).collect()
}

/// The links of an excavator whose angles were not found, where that of another was: one without the others is no posture.
pub(crate) fn links(found: &[String]) -> Vec<&'static str> {
    let is_found = |link: &&str| found.iter().any(|signal| signal == link);
    let (known, missing): (Vec<&str>, Vec<&str>) = LINKS.into_iter().partition(is_found);
    if known.is_empty() {
        return Vec::new();
    }
    missing
}
