//! Events of one row.

use super::book::{Day, Truck};
use super::load::Load;

/// Events of one row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Events {
    /// A load that has reached its stage, or whose report has improved.
    pub load: Option<Load>,
    /// A truck that is complete.
    pub truck: Option<Truck>,
    /// A day that is over.
    pub day: Option<Day>,
}

impl Events {
    /// Whether nothing has happened.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
