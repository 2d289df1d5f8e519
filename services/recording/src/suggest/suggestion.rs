//! A proposed map, and the signals that it lacks.

use crate::signal::Sensors;

/// Angles of the links, in the order of the links.
pub(super) const LINKS: [&str; 3] = ["boom_angle", "arm_angle", "bucket_angle"];

/// A first map of a file.
#[derive(Debug)]
pub struct Suggestion {
    /// The map.
    pub text: String,
    /// Groups of signals of which the machine needs one and none was found.
    pub missing: Vec<&'static [&'static str]>,
    /// Columns with a text in brackets that is no known unit, and that text.
    pub unknown: Vec<String>,
    /// Columns in `1/s`, which may mean radians or turns.
    pub of_second: Vec<String>,
    /// Columns in a unit of another dimension than the signal of their name, and that unit.
    pub of_others: Vec<String>,
    /// Links whose angles were not found although that of another link was.
    pub links: Vec<&'static str>,
    /// Number of signals found.
    pub(crate) found: usize,
}

impl Suggestion {
    /// A map of a file without columns, in which these signals were found.
    pub(crate) fn of<S: Sensors>(text: String, found: &[String]) -> Self {
        Self {
            text,
            missing: missing::<S>(found),
            unknown: Vec::new(),
            of_second: Vec::new(),
            of_others: Vec::new(),
            links: links(found),
            found: found.len(),
        }
    }
}

/// Groups of signals that a machine needs one of, and none was found.
pub(super) fn missing<S: Sensors>(found: &[String]) -> Vec<&'static [&'static str]> {
    let is_missing = |group: &&[&str]| !group.iter().any(|s| found.iter().any(|f| f == s));
    S::REQUIRED.iter().copied().filter(is_missing).collect()
}

/// The links of an excavator whose angles were not found although that of another link was: a posture needs all.
pub(super) fn links(found: &[String]) -> Vec<&'static str> {
    let is_found = |link: &&str| found.iter().any(|signal| signal == link);
    let (known, missing): (Vec<&str>, Vec<&str>) = LINKS.into_iter().partition(is_found);
    if known.is_empty() {
        return Vec::new();
    }
    missing
}
