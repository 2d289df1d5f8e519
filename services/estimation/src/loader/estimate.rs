//! The estimate after each row: values, standard deviations, and whether to trust them.

use super::{Method, Reason};
use crate::Quantity;

/// What the estimator did with a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Status {
    /// No row has been accepted yet: the values are the prior.
    #[default]
    Waiting,
    /// The first accepted row started the clock; nothing was updated.
    First,
    /// Predicted and updated.
    Updated,
    /// The time did not increase or is not finite: the row was ignored, the state is untouched.
    Refused,
    /// The row came after a gap: speeds re-anchored on the measurements, parameters unchanged.
    Gap,
    /// The clock was set back and stayed so: time continues from this row; speeds re-anchored, parameters unchanged.
    ClockSetBack,
    /// The innovations stayed too large for too long: the covariance restarted, the values are unchanged.
    Reset,
    /// The filter had a value that is not finite: everything restarted from the prior.
    Diverged,
}

/// State of the estimate after one row. Every number is finite.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Estimate {
    /// A row has been accepted; before, the values are the prior.
    pub started: bool,
    /// Time of the row \[s\]; the last accepted time when the row was refused.
    pub time: f64,
    /// Forward speed [m/s].
    pub speed: f64,
    /// Speed of the front wheels [rad/s].
    pub front_wheel_speed: f64,
    /// Speed of the rear wheels [rad/s].
    pub rear_wheel_speed: f64,
    /// Slip stiffness K of the tyres, F_x = K slip F_z.
    pub slip_stiffness: Quantity,
    /// Height h of the centre of gravity above ground \[m\]; the standard deviation includes the floor.
    pub cg_height: Quantity,
    /// Share lambda of the static weight on the front axle; the standard deviation includes the floor.
    pub cg_ratio: Quantity,
    /// Distance from the front axle back to the centre of gravity, (1 - lambda) l \[m\].
    pub cg_distance: f64,
    /// Force on the bucket tip, measured plus unknown part, positive backward \[N\].
    pub spade_force_x: Option<Quantity>,
    /// Content of the bucket, weighed by the lift pressure \[kg\].
    pub payload: Option<Quantity>,
    /// The payload is trusted: the bucket neither turns nor touches the ground, and the interval is narrow.
    pub trusted_payload: bool,
    /// The load may be changing, whatever `reason` names.
    pub changing: bool,
    /// Ratio and height are those of the empty machine with its arm at the reference.
    pub of_empty: bool,
    /// Bias of the slope sensor, true slope = measured - bias \[rad\].
    pub slope_bias: Option<f64>,
    /// Rolling radius of the front wheels over its nominal value, 1 + d_f.
    pub front_radius_scale: Option<f64>,
    /// Rolling radius of the rear wheels over its nominal value, 1 + d_r.
    pub rear_radius_scale: Option<f64>,
    /// Delay of the measured speed \[s\].
    pub speed_delay: Option<Quantity>,
    /// Normalised innovation squared of this row per accepted measurement; 1 is the expected value.
    pub nis: f64,
    /// The torques changed enough to distinguish the axle loads.
    pub excited_ratio: bool,
    /// The acceleration changed enough to shift load between the axles.
    pub excited_height: bool,
    /// The innovations are not larger than predicted.
    pub consistent: bool,
    /// Speed and wheel speeds were accepted, and torques, slope and specific force came, within the last 0.25 s; none is stuck.
    pub fresh: bool,
    /// The data, not the prior or a bound, determine the ratio.
    pub identifiable_ratio: bool,
    /// The data, not the prior or a bound, determine the height.
    pub identifiable_height: bool,
    /// The ratio's interval is narrower than its limit.
    pub converged_ratio: bool,
    /// The height's interval is narrower than its limit.
    pub converged_height: bool,
    /// Slow or digging: the parameters are held nearly constant.
    pub frozen: bool,
    /// A reset happened within the last 2 s.
    pub reset: bool,
    /// The ratio is trusted: excited, consistent, fresh, converged, identifiable, and not just reset.
    pub trusted_ratio: bool,
    /// The height is trusted: excited, consistent, fresh, converged, identifiable, and not just reset.
    pub trusted_height: bool,
    /// Why the estimate is not fresh or not consistent.
    pub reason: Reason,
    /// What was done with the row.
    pub status: Status,
    /// The method that made the estimate.
    pub method: Method,
    /// Resets so far.
    pub resets: u32,
    /// Rows refused so far.
    pub refused: u64,
}

impl Estimate {
    /// Whether the row was refused; the state is then untouched.
    pub fn is_refused(&self) -> bool {
        self.status == Status::Refused
    }

    /// Whether the filter had a value that is not finite at this row, and restarted from the prior.
    pub fn has_diverged(&self) -> bool {
        self.status == Status::Diverged
    }
}
