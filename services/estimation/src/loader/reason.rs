//! Reasons why an estimate is not trusted: the rows are in the sheet.

use crate::reasons::reasons;

sheet::loader_reasons!(reasons);

impl Reason {
    /// The cause of a stuck signal, in the order of the watched signals.
    pub(super) fn stuck(signal: usize) -> Self {
        [
            Self::StuckSpeed,
            Self::StuckFrontWheel,
            Self::StuckRearWheel,
            Self::StuckFrontTorque,
            Self::StuckRearTorque,
            Self::StuckSlope,
            Self::StuckAcceleration,
        ][signal.min(6)]
    }
}
