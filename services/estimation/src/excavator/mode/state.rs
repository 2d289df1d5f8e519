//! What a state-space mode says after one tick.

use crate::excavator::reason::Reason;

/// Reading of a mode, before the verdict.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct State {
    pub(in crate::excavator) inertia: f64,
    pub(in crate::excavator) inertia_std: f64,
    /// Value and standard deviation.
    pub(in crate::excavator) payload: Option<(f64, f64)>,
    pub(in crate::excavator) damping: Option<(f64, f64)>,
    /// Offset of the torque: true minus measured.
    pub(in crate::excavator) offset: Option<(f64, f64)>,
    /// Unknown total torque.
    pub(in crate::excavator) total_torque: Option<(f64, f64)>,
    pub(in crate::excavator) velocity: f64,
    pub(in crate::excavator) acceleration: f64,
    /// Ungated; 0 where nothing was measured.
    pub(in crate::excavator) nis: f64,
    pub(in crate::excavator) changing: bool,
    /// The value may not be what it seems: the payload is perhaps changing, or the estimate is at the
    /// end of its range.
    pub(in crate::excavator) unsettled: bool,
    /// The load has been weighed just now: standing rows tell the inertia too.
    pub(in crate::excavator) weighed: bool,
    pub(in crate::excavator) reason: Reason,
    pub(in crate::excavator) change_mode: bool,
    pub(in crate::excavator) opening: bool,
    pub(in crate::excavator) drop_probability: f64,
    /// Change flag of the tick behind this reading.
    pub(in crate::excavator) flagged: bool,
}
