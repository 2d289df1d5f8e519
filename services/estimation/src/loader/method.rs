//! The methods by the names that the command line and the files use.

use core::fmt;

/// How the centre of gravity is estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Method {
    /// 11 states with rolling radii, unknown spade force, slope bias and delay of the speed (9 without an accelerometer),
    /// protected against bad input, by sigma points: the product.
    #[default]
    Full,
    /// The improved square-root UKF with 6 states exactly as Yang, Wang, Han 2021 print it.
    IsrUkfPrinted,
    /// The same 6 states with gain and covariance that agree with each other.
    IsrUkf,
    /// The extended Kalman filter on the same 6 states.
    Ekf,
    /// `full` by the model's tangent: an extended Kalman filter of the same states, noise, conditions and verdict, at an eighth
    /// of the cost.
    FullEkf,
}

impl Method {
    /// Every method, the default first.
    pub const ALL: [Self; 5] = [
        Self::Full,
        Self::IsrUkfPrinted,
        Self::IsrUkf,
        Self::Ekf,
        Self::FullEkf,
    ];

    /// The name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::IsrUkfPrinted => "isr-ukf-printed",
            Self::IsrUkf => "isr-ukf",
            Self::Ekf => "ekf",
            Self::FullEkf => "full-ekf",
        }
    }

    /// The method of that name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
