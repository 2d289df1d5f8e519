//! Inputs and outputs of the estimators: a row of sensors, an estimate with its verdict.

use super::reason::Reason;
use crate::Quantity;
use crate::methods::methods;

/// One row of sensors; a missing value is `None`, a non-finite one counts as missing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Time of the measurement \[s\].
    pub time: f64,
    /// Swing velocity, positive anticlockwise from above [rad/s].
    pub velocity: Option<f64>,
    /// Swing angle of an encoder, same sign; used where there is no velocity \[rad\].
    pub angle: Option<f64>,
    /// Swing torque at the upper body, positive in the direction of positive motion [N m].
    pub torque: Option<f64>,
    /// Boom (to the horizontal, up positive), arm (relative to the boom), bucket (relative to the
    /// arm) \[rad\].
    pub posture: [Option<f64>; 3],
    /// Pitch (nose up positive) and roll (left side low positive) of the upper body \[rad\].
    pub inclination: [Option<f64>; 2],
    /// Pressure at the head side of the boom cylinders, their mean \[Pa\].
    pub boom_head_pressure: Option<f64>,
    /// Pressure at the rod side of the boom cylinders, their mean \[Pa\].
    pub boom_rod_pressure: Option<f64>,
    /// Pressure at the head side of the arm cylinder \[Pa\].
    pub arm_head_pressure: Option<f64>,
    /// Pressure at the rod side of the arm cylinder \[Pa\].
    pub arm_rod_pressure: Option<f64>,
    /// Number of the truck that is loaded; a change of number begins the next truck.
    pub truck: Option<f64>,
}

/// Columns that the source has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Columns {
    /// Swing velocity.
    pub velocity: bool,
    /// Swing angle.
    pub angle: bool,
    /// Swing torque.
    pub torque: bool,
    /// All three joint angles.
    pub posture: bool,
}

/// Verdict of one estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Flags {
    /// The motion carries information about the inertia.
    pub excited: bool,
    /// Innovations agree with their predicted size.
    pub consistent: bool,
    /// All inputs are recent.
    pub fresh: bool,
    /// The 95 % interval is narrower than the stated limit, the payload is not changing, and nothing is contradicted.
    pub converged: bool,
    /// The measured signals can determine the inertia.
    pub identifiable: bool,
    /// Standstill: the estimate is held.
    pub held: bool,
    /// The payload is changing, or has just done so.
    pub changing: bool,
    /// The filter was reset to its prior at this sample.
    pub reset: bool,
    /// Paper: the nominal-parameter rule acted (Eqs. 28-29).
    pub nominal: bool,
    /// Paper: inside a change window (section 3.5).
    pub window: bool,
    /// The row was refused (time not increasing or not finite); the state is unchanged.
    pub refused: bool,
}

impl Flags {
    /// Whether all five conditions hold, the payload is not changing, and the row was not refused.
    pub fn trusted(&self) -> bool {
        self.excited
            && self.consistent
            && self.fresh
            && self.converged
            && self.identifiable
            && !self.changing
            && !self.refused
    }
}

sheet::excavator_methods!(methods);

impl Method {
    /// Whether [`super::Regression`] runs this method; [`super::SwingEstimator`] runs the others.
    pub fn is_regression(self) -> bool {
        matches!(self, Self::MultiForgettingRls | Self::SvfRls)
    }

    /// Method that `auto` chooses for these columns.
    pub fn for_columns(columns: Columns) -> Self {
        match (columns.torque, columns.posture) {
            (true, true) => Self::PostureTorque,
            (true, false) => Self::Torque,
            (false, true) => Self::Posture,
            (false, false) => Self::Velocity,
        }
    }
}

/// Estimate at one sample. Every number is finite.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Estimate {
    /// Swing inertia [kg m^2].
    pub inertia: f64,
    /// Standard deviation of the inertia; the 95 % interval is inertia +- 1.96 of it [kg m^2].
    pub inertia_std: f64,
    /// Viscous damping, where it is estimated [N m s/rad].
    pub damping: Option<Quantity>,
    /// Torque [N m]: the measured torque corrected by its offset, or where none is measured the total torque T_t = T - T_f sgn(w).
    pub torque: Option<Quantity>,
    /// Payload \[kg\].
    pub payload: Option<Quantity>,
    /// Coulomb friction torque, where it is estimated [N m].
    pub friction: Option<Quantity>,
    /// Torque offset, where it is estimated: the measured torque minus the true one [N m].
    pub offset: Option<Quantity>,
    /// Swing velocity [rad/s].
    pub velocity: f64,
    /// Swing acceleration [rad/s^2].
    pub acceleration: f64,
    /// Normalised innovation squared of this sample before any gate; 0 without a measurement.
    pub nis: f64,
    /// Verdict.
    pub flags: Flags,
    /// Method that made this estimate; never `Auto`.
    pub method: Method,
    /// Forgetting factors of inertia, damping and torque (regressions; otherwise 0).
    pub forgetting: [f64; 3],
    /// Rows refused so far.
    pub refused: u64,
    /// How the machine deviates from its description, or why the estimate is not trusted.
    pub reason: Reason,
}
