//! The numerical and statistical choices of a filter.

pub use crate::loader::keys::LoadTransfer;

/// How the process model is integrated over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Integration {
    /// Linearly implicit: stable at every speed.
    #[default]
    Implicit,
    /// Explicit Euler (18): unstable for a real machine. For comparison only.
    Euler,
}

/// Process noise, standard deviation per 10 ms step; scaled with the root of the step length.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ProcessNoise {
    /// Speed [m/s].
    pub speed: f64,
    /// Wheel speeds [rad/s].
    pub wheel_speed: f64,
    /// Slip stiffness.
    pub slip_stiffness: f64,
    /// Height [m].
    pub cg_height: f64,
    /// Ratio.
    pub cg_ratio: f64,
    /// Unknown part of the spade force [N].
    pub spade_force_x: f64,
    /// Relative radius errors.
    pub radius: f64,
    /// Bias of the slope sensor [rad].
    pub slope_bias: f64,
    /// Delay of the speed [s].
    pub speed_delay: f64,
}

/// Disturbances that act on the wheels like extra measurement noise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inflation {
    /// Relative axle-load ripple acting through the slip (cb); 0 is off.
    pub load_ripple: f64,
    /// Relative axle-load ripple acting through the rolling radius (crho); 0 is off.
    pub radius_ripple: f64,
    /// Share of the not yet settled tyre torque (ct); 0 is off.
    pub torque_lag: f64,
    /// Least standard deviation of the wheel speeds while slow or digging [rad/s]; 0 is off.
    pub frozen_wheel_speed_std: f64,
}

/// Treatment of single innovations, in units of their predicted standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gates {
    /// Above: the measurement is de-weighted.
    pub soft: f64,
    /// From here on: the measurement is dropped.
    pub hard: f64,
}

/// When digging holds the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Digging {
    /// Spade force that counts as digging [N].
    pub force: f64,
    /// How long digging outlasts the force [s].
    pub hold: f64,
    /// After digging the bucket may be full: height and ratio reopen to this multiple of the prior; 0 is off.
    pub reopen: f64,
    /// Multiple of the parameter noise while the boom moves; 1 is off.
    pub boom_gain: f64,
}

/// Bounds of the estimated parameters: the mean is clamped, the covariance is not.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Clamps {
    /// Slip stiffness.
    pub slip_stiffness: (f64, f64),
    /// Height [m].
    pub cg_height: (f64, f64),
    /// Ratio.
    pub cg_ratio: (f64, f64),
}

impl Clamps {
    /// Bounds that no wheel loader leaves.
    pub const WIDE: Self = Self {
        slip_stiffness: (4.0, 80.0),
        cg_height: (0.3, 2.5),
        cg_ratio: (0.1, 0.9),
    };
}

/// When the filter restarts by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reset {
    /// Running mean of the normalised innovation squared above which the covariance restarts.
    pub level: f64,
    /// Time constant of that mean [s].
    pub time_constant: f64,
    /// Shortest time between the start, or a reset, and the next reset [s].
    pub hold_off: f64,
}

/// When the parameters are loosened because what the start taught was taken from a tangent, see `relearning`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Relearning {
    /// The ratio is known when its standard deviation is this share of the prior's.
    pub known: f64,
    /// Share of the prior's standard deviations that comes back for one standard deviation of way.
    pub gain: f64,
}

/// Numerical and statistical choices; each method has its own defaults, see [`Tuning::of`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tuning {
    /// Process noise.
    pub noise: ProcessNoise,
    /// Smallest speed in a slip denominator, v_min [m/s].
    pub minimum_speed: f64,
    /// Use the mean of two neighbouring input samples; otherwise the older one is held.
    pub midpoint_inputs: bool,
    /// Use the friction limit and the load sensitivity of the machine; otherwise the linear, rigid tyre.
    pub real_tyre: bool,
    /// Integration of the process model.
    pub integration: Integration,
    /// Equal parts into which one step is divided, at least 1.
    pub substeps: u32,
    /// Spread alpha of the sigma points: 1, or 0.01 as the paper has it.
    pub spread: f64,
    /// Weight beta of (22): acts in the printed form only.
    pub beta: f64,
    /// Kappa of (21).
    pub kappa: f64,
    /// Sign of the load transfer.
    pub load_transfer: LoadTransfer,
    /// Extra wheel noise.
    pub inflation: Inflation,
    /// Below this speed the parameters are held and the wheel rows weak [m/s]; 0 is off.
    pub freeze_speed: f64,
    /// Innovation gates; `None` is off.
    pub gates: Option<Gates>,
    /// Parameter bounds; `None` is off.
    pub clamps: Option<Clamps>,
    /// Digging rule; `None` is off.
    pub digging: Option<Digging>,
    /// Gap after which speeds are re-anchored [s]; infinite is off.
    pub gap: f64,
    /// Reset rule; `None` is off.
    pub reset: Option<Reset>,
    /// Correct the wheel speeds for the winding up of the tyres.
    pub windup: bool,
    /// Add the error of the smallest step ever seen to the noise of the wheel speeds.
    pub quantum: bool,
    /// Loosen what the start taught wrongly; `None` is off.
    pub relearning: Option<Relearning>,
    /// The delay of the speed is a state.
    pub latency: bool,
    /// Doubt the inputs: a value that never changes is missing, wheel speeds count only with their torques and without
    /// brakes and steering, the slope as far as the motion bears it out, and manoeuvres must agree.
    pub screened: bool,
    /// The parameters wander in a gap too, while nothing is measured.
    pub wandering: bool,
    /// Loosen the rolling radii when the load shifts between the axles.
    pub load_shift: bool,
}
