//! Estimate of a state-space mode after one tick, before the verdict.

use crate::excavator::reason::Reason;

/// Reading of a mode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct State {
    pub(in crate::excavator) inertia: f64,
    pub(in crate::excavator) inertia_std: f64,
    /// Value and standard deviation.
    pub(in crate::excavator) payload: Option<(f64, f64)>,
    pub(in crate::excavator) damping: Option<(f64, f64)>,
    /// Offset of the torque: true minus measured, in units of the measured one.
    pub(in crate::excavator) offset: Option<(f64, f64)>,
    /// Gain error of the torque: true over measured, minus 1; `None` where that is no state.
    pub(in crate::excavator) gain: Option<(f64, f64)>,
    /// Unknown total torque.
    pub(in crate::excavator) total_torque: Option<(f64, f64)>,
    pub(in crate::excavator) velocity: f64,
    pub(in crate::excavator) acceleration: f64,
    /// Normalised innovation squared before any gate; 0 without a measurement.
    pub(in crate::excavator) nis: f64,
    pub(in crate::excavator) changing: bool,
    /// The estimate may be invalid: the payload is possibly changing, or the estimate is at the end of its range.
    pub(in crate::excavator) unsettled: bool,
    /// The load was weighed just now, so that rows at standstill identify the inertia too.
    pub(in crate::excavator) weighed: bool,
    pub(in crate::excavator) reason: Reason,
    pub(in crate::excavator) change_mode: bool,
    pub(in crate::excavator) opening: bool,
    /// Change flag of the tick of this reading.
    pub(in crate::excavator) flagged: bool,
}
