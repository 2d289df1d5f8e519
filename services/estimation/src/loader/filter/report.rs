//! Result of a row in the filter.

use crate::loader::estimate::Status;

/// Result of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::loader) struct RowReport<const M: usize> {
    /// Status of the row.
    pub status: Status,
    /// Normalised innovation squared, the sum over the accepted measurements.
    pub nis: f64,
    /// Which measurements were used.
    pub accepted: [bool; M],
    /// Which of them were de-weighted.
    pub deweighted: [bool; M],
    /// Slow or digging.
    pub frozen: bool,
    /// Wheels and their torques are present, but brakes act.
    pub set_aside: bool,
}

impl<const M: usize> RowReport<M> {
    /// A report without any measurement.
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
