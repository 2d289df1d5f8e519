//! How the centre of gravity is estimated.

use crate::methods::methods;

methods! {
    /// How the centre of gravity is estimated.
    pub enum Method {
        /// 12 states with rolling radii, their load sensitivity, unknown spade force, slope bias and delay of the speed (9 without an accelerometer),
        /// protected against bad input, by sigma points: the product.
        Full = "full",
        /// The improved square-root UKF with 6 states exactly as Yang, Wang, Han 2021 print it.
        IsrUkfPrinted = "isr-ukf-printed",
        /// The same 6 states with gain and covariance that agree with each other.
        IsrUkf = "isr-ukf",
        /// The extended Kalman filter on the same 6 states.
        Ekf = "ekf",
        /// `full` by the model's tangent: an extended Kalman filter of the same states, noise, conditions and verdict, at an eighth
        /// of the cost.
        FullEkf = "full-ekf",
    }
}

impl Method {
    /// Whether it has the paper's six states.
    pub(super) const fn has_six_states(self) -> bool {
        matches!(self, Self::IsrUkfPrinted | Self::IsrUkf | Self::Ekf)
    }

    /// Whether it takes the model's tangent, and not sigma points.
    pub(super) const fn takes_tangent(self) -> bool {
        matches!(self, Self::Ekf | Self::FullEkf)
    }
}
