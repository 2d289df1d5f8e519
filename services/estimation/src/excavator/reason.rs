//! Reasons why an estimate is not trusted; the list is in the sheet.

use crate::reasons::reasons;

sheet::excavator_reasons!(reasons);

impl Reason {
    /// Whether it names a constant of the machine. Where inputs are missing, that is no cause.
    pub(super) fn is_constant(self) -> bool {
        matches!(
            self,
            Self::Slope
                | Self::Loss
                | Self::Friction
                | Self::Gain
                | Self::Delay
                | Self::Offset
                | Self::Damping
                | Self::Attachment
        )
    }
}
