//! Roles of a loader's parameters, and stated values of its loads.

use estimation::Quantity;
use estimation::loader::weigh::Reference;

/// Role of a parameter; loads are numbered, 0 is the described machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Relative error of the front rolling radius.
    FrontRadius,
    /// Relative error of the rear rolling radius.
    RearRadius,
    /// Load sensitivity of the radii.
    LoadSensitivity,
    /// Measured over true front torque.
    FrontGain,
    /// Measured over true rear torque.
    RearGain,
    /// Slip stiffness.
    Stiffness,
    /// Front over rear slip stiffness.
    StiffnessRatio,
    /// Exponent by which the stiffness falls with the load.
    LoadExponent,
    /// Friction coefficient.
    Friction,
    /// Share of a brush's curve of the slip.
    Brush,
    /// Variance of the axle loads on bumps.
    LoadVariance,
    /// Rolling resistance.
    Rolling,
    /// Zero of the slope.
    SlopeBias,
    /// Zero of the accelerometer.
    AccelerationOffset,
    /// Delay of the slope.
    SlopeDelay,
    /// Sensitivity of the slope sensor to acceleration.
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
    /// Scatter of the slopes out and back.
    PathScatter,
    /// Remaining offset between the marks of a path.
    Mark(usize),
    /// Mass with a load.
    Mass(usize),
    /// Front share with a load.
    Ratio(usize),
    /// Height of the centre of gravity with a load.
    Height(usize),
    /// Distance of a load ahead of the front axle, where no axle weights determine the share.
    Reach(usize),
    /// Pitch of the chassis on its tyres by the specific force, and under a load.
    Squat,
    /// Pitch of the chassis under a load, over what the same springs give.
    Settling,
    /// Height of a load, where no axle weights determine that of the centre of gravity.
    Lift(usize),
}

impl Role {
    /// The load that it belongs to, if any.
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

    /// Whether it is a noise.
    pub fn is_noise(self) -> bool {
        use Role::{ForceScatter, MotionScatter, PathScatter, SpeedScatter, WheelScatter};
        matches!(
            self,
            WheelScatter | SpeedScatter | ForceScatter | MotionScatter | PathScatter
        )
    }

    /// Whether it acts on the slope residuals of a path.
    pub(super) fn is_of_slope(self) -> bool {
        use Role::{
            AccelerationOffset, PathScatter, Settling, SlopeBias, SlopeDelay, SlopeFollows, Squat,
        };
        matches!(
            self,
            AccelerationOffset
                | SlopeBias
                | SlopeDelay
                | SlopeFollows
                | PathScatter
                | Squat
                | Settling
        )
    }

    /// Whether it is estimated only to propagate its tolerance to the others: lags and limits that
    /// means over half a second hardly determine, position of the load and pitch of the chassis, and the marks of a path.
    pub fn is_nuisance(self) -> bool {
        use Role::{
            Brush, Friction, Lift, LoadVariance, Mark, Reach, Relaxation, Settling, Squat,
            TorqueDelay,
        };
        matches!(
            self,
            Friction
                | Brush
                | LoadVariance
                | Relaxation
                | TorqueDelay
                | Squat
                | Settling
                | Mark(_)
                | Reach(_)
                | Lift(_)
        ) || self.is_noise()
    }
}

/// Stated values of a load.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StatedLoad {
    /// Mass of the whole machine \[kg\].
    pub mass: Option<Quantity>,
    /// Front share of the weight, from axle scales.
    pub ratio: Option<Quantity>,
    /// Height of the centre of gravity, from axle scales on a slope \[m\].
    pub height: Option<Quantity>,
    /// Distance of the load ahead of the front axle, by the drawing of the arm \[m\].
    pub reach: Option<Quantity>,
    /// Height of the load above the ground, by the same \[m\].
    pub lift: Option<Quantity>,
}

impl StatedLoad {
    /// Values from axle scales; `scale_std` is the relative standard deviation of one, which may be common to all readings.
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
            ..Self::default()
        }
    }
}
