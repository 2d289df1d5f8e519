//! What the alarms remember of a machine.

use std::collections::BTreeMap;
use std::time::Instant;

use super::shown::Quantity;

/// What is remembered of a machine.
#[derive(Debug, Default)]
pub struct State {
    /// Alarms that are on, by kind, in words.
    pub on: BTreeMap<&'static str, String>,
    /// Since when it runs without being trusted.
    pub(super) untrusted: Option<Instant>,
    /// The first trusted value of each learnt parameter since the collector began, and what it drifted to.
    pub(super) first: BTreeMap<&'static str, Quantity>,
}
