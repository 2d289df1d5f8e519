//! What a state-space mode says after one tick.

use super::reason::Reason;

/// Reading of a mode, before the verdict.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct State {
    pub(super) inertia: f64,
    pub(super) inertia_std: f64,
    /// Value and standard deviation.
    pub(super) payload: Option<(f64, f64)>,
    pub(super) damping: Option<(f64, f64)>,
    /// Offset of the torque: true minus measured.
    pub(super) offset: Option<(f64, f64)>,
    /// Unknown total torque.
    pub(super) total_torque: Option<(f64, f64)>,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    /// Ungated; 0 where nothing was measured.
    pub(super) nis: f64,
    pub(super) changing: bool,
    /// The value may not be what it seems: the payload is perhaps changing, or the estimate is at the
    /// end of its range.
    pub(super) unsettled: bool,
    pub(super) reason: Reason,
    pub(super) change_mode: bool,
    pub(super) opening: bool,
    pub(super) drop_probability: f64,
    /// Change flag of the tick behind this reading.
    pub(super) flagged: bool,
}
