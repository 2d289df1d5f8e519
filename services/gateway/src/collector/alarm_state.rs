//! State of the alarms of a machine.

use std::collections::BTreeMap;
use std::time::Instant;

use super::shown::Quantity;

/// Alarms and references of a machine.
#[derive(Debug, Default)]
pub struct State {
    /// Texts of the alarms that are on, by kind.
    pub on: BTreeMap<&'static str, String>,
    /// Time since which it runs without being trusted.
    pub(super) untrusted: Option<Instant>,
    /// First trusted value of each learnt parameter since the start of the collector: the reference of the drift.
    pub(super) first: BTreeMap<&'static str, Quantity>,
}
