//! Methods that estimate the centre of gravity.

use crate::methods::methods;

sheet::loader_methods!(methods);

impl Method {
    /// Whether it has the paper's six states.
    pub(super) const fn has_six_states(self) -> bool {
        matches!(self, Self::IsrUkfPrinted | Self::IsrUkf | Self::Ekf)
    }

    /// Whether it uses the model's tangent, and not sigma points.
    pub(super) const fn takes_tangent(self) -> bool {
        matches!(self, Self::Ekf | Self::FullEkf)
    }
}
