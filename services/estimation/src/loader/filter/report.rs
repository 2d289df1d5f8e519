//! What a row did to the filter.

use crate::loader::estimate::Status;

/// What a row did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::loader) struct RowReport<const M: usize> {
    /// How the row was taken.
    pub status: Status,
    /// Normalised innovation squared, the sum over the accepted measurements.
    pub nis: f64,
    /// Which measurements were used.
    pub accepted: [bool; M],
    /// Which of them were de-weighted.
    pub deweighted: [bool; M],
    /// Slow or digging.
    pub frozen: bool,
    /// The wheels came with their torques, but something else moves them: brakes.
    pub set_aside: bool,
}

impl<const M: usize> RowReport<M> {
    /// No measurement was used.
    pub fn without_update(status: Status, frozen: bool) -> Self {
        Self {
            status,
            nis: 0.0,
            accepted: [false; M],
            deweighted: [false; M],
            frozen,
            set_aside: false,
        }
    }
}
