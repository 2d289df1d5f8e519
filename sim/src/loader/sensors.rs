//! Sensor grades: noise of the measurements.

/// White noise of every sensor, standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// Wheel speed from a Hall sensor, as the paper's test vehicle may have had.
    Hall,
    /// In between.
    Nominal,
    /// Wheel speed from the motor's resolver through the gear: the targets refer to it.
    Resolver,
    /// Better than any commercial sensor.
    Ideal,
}

impl Grade {
    /// `hall`, `nominal`, `resolver` or `ideal`.
    pub fn parse(text: &str) -> Option<Self> {
        match text.to_ascii_lowercase().as_str() {
            "hall" => Some(Self::Hall),
            "nominal" => Some(Self::Nominal),
            "resolver" => Some(Self::Resolver),
            "ideal" => Some(Self::Ideal),
            _ => None,
        }
    }

    /// The name that [`Self::parse`] reads.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hall => "hall",
            Self::Nominal => "nominal",
            Self::Resolver => "resolver",
            Self::Ideal => "ideal",
        }
    }

    /// Of the speed over ground [m/s].
    pub fn speed_std(self) -> f64 {
        self.pick([0.05, 0.02, 0.02, 0.002])
    }

    /// Of a wheel speed [rad/s].
    pub fn wheel_speed_std(self) -> f64 {
        self.pick([0.05, 0.01, 0.002, 0.0005])
    }

    /// Of the slope \[rad\].
    pub fn slope_std(self) -> f64 {
        self.pick([0.005, 0.002, 0.002, 0.0005])
    }

    /// Of the specific force [m/s^2].
    pub fn acceleration_std(self) -> f64 {
        self.pick([0.10, 0.05, 0.05, 0.01])
    }

    /// Of a torque, relative to it.
    pub fn torque_std(self) -> f64 {
        self.pick([0.01, 0.005, 0.005, 0.0])
    }

    fn pick(self, values: [f64; 4]) -> f64 {
        values[self as usize]
    }
}
