//! What one row has brought about.

use super::book::{Day, Truck};
use super::load::Load;

/// What one row has brought about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Events {
    /// A load came as far as its stage says, or is reported better.
    pub load: Option<Load>,
    /// A truck is complete.
    pub truck: Option<Truck>,
    /// A day is over.
    pub day: Option<Day>,
}

impl Events {
    /// Whether nothing has happened.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
