//! What the parameters of a loader are, and what is known of its loads.

use estimation::Quantity;
use estimation::loader::weigh::Reference;

/// What a parameter is in the guess; a load is numbered, 0 is the machine as described.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Relative error of the front rolling radius.
    FrontRadius,
    /// Relative error of the rear rolling radius.
    RearRadius,
    /// Load sensitivity of the radii.
    LoadSensitivity,
    /// Measured over true torque in front.
    FrontGain,
    /// Measured over true torque behind.
    RearGain,
    /// Slip stiffness.
    Stiffness,
    /// Slip stiffness in front over that behind.
    StiffnessRatio,
    /// How the stiffness falls with the load.
    LoadExponent,
    /// Limit of friction.
    Friction,
    /// Rolling resistance.
    Rolling,
    /// Zero of the slope.
    SlopeBias,
    /// Zero of the accelerometer.
    AccelerationOffset,
    /// Delay of the slope.
    SlopeDelay,
    /// Share of the acceleration that the slope sensor follows.
    SlopeFollows,
    /// Delay of the speed.
    SpeedDelay,
    /// Delay of the torques.
    TorqueDelay,
    /// Relaxation length of the tyres.
    Relaxation,
    /// Scatter between the wheels.
    WheelScatter,
    /// Scatter of the speed.
    SpeedScatter,
    /// Scatter of the balance of force.
    ForceScatter,
    /// Scatter of the motion.
    MotionScatter,
    /// Scatter of the slopes there and back.
    WayScatter,
    /// What is left of the shift between the marks of a way.
    Mark(usize),
    /// Mass with a load.
    Mass(usize),
    /// Share in front with a load.
    Ratio(usize),
    /// Height of the centre of gravity with a load.
    Height(usize),
    /// How far a load lies ahead of the front axle, where no scales tell the share.
    Reach(usize),
    /// Height of a load, where no scales tell that of the centre of gravity.
    Lift(usize),
}

impl Role {
    /// The load it belongs to, if it does.
    pub fn load(self) -> Option<usize> {
        match self {
            Self::Mass(load)
            | Self::Ratio(load)
            | Self::Height(load)
            | Self::Reach(load)
            | Self::Lift(load) => Some(load),
            _ => None,
        }
    }

    /// Whether it is only about noise.
    pub fn is_noise(self) -> bool {
        use Role::{ForceScatter, MotionScatter, SpeedScatter, WayScatter, WheelScatter};
        matches!(
            self,
            WheelScatter | SpeedScatter | ForceScatter | MotionScatter | WayScatter
        )
    }

    /// Whether it is about what the slope sensor shows.
    pub(super) fn is_of_slope(self) -> bool {
        use Role::{AccelerationOffset, SlopeBias, SlopeDelay, SlopeFollows, WayScatter};
        matches!(
            self,
            AccelerationOffset | SlopeBias | SlopeDelay | SlopeFollows | WayScatter
        )
    }

    /// Whether it only takes part with what is known of it, so that its tolerance counts in the others: lags and limits that
    /// means over half a second hardly show, where the load lies, and the marks of a way.
    pub fn is_nuisance(self) -> bool {
        use Role::{Friction, Lift, Mark, Reach, Relaxation, TorqueDelay};
        matches!(
            self,
            Friction | Relaxation | TorqueDelay | Mark(_) | Reach(_) | Lift(_)
        ) || self.is_noise()
    }
}

/// What is known of a load before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StatedLoad {
    /// Mass of the whole machine \[kg\].
    pub mass: Option<Quantity>,
    /// Share of the weight in front, from axle scales.
    pub ratio: Option<Quantity>,
    /// Height of the centre of gravity, from axle scales on a slope \[m\].
    pub height: Option<Quantity>,
}

impl StatedLoad {
    /// What axle scales say; `scale_std` is the accuracy of one, relative, and it may be common to all readings.
    pub fn weighed(reference: &Reference, scale_std: f64) -> Self {
        let ratio = reference.cg_ratio;
        let common = core::f64::consts::SQRT_2 * scale_std * ratio.value * (1.0 - ratio.value);
        Self {
            mass: None,
            ratio: Some(Quantity {
                value: ratio.value,
                std: ratio.std.max(common),
            }),
            height: reference.cg_height,
        }
    }
}
