//! Whether to trust the estimate: excitation, consistency, freshness, convergence, and the first reason why not.

use super::input::stuck::WATCHED;
use super::layout::Each;
use super::reason::Reason;
use super::sample::Sample;
use super::settings::Settings;
use crate::Quantity;
use crate::math::sqrt;

/// Averaging time of the excitation [s].
const EXCITATION_TIME: f64 = 5.0;
/// Time for which a reset is reported [s].
const RESET_SHOWN: f64 = 2.0;
/// Share of the prior's standard deviation below which the data determine the parameter.
const OBSERVABLE: Each<f64> = Each {
    ratio: 0.5,
    height: 0.36,
};

/// Errors of an estimate beside its own covariance (*doubts*).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Doubt {
    /// Standard deviation of the ratio: that of the filter, or more where one axle alone pulls.
    pub ratio_std: f64,
    /// Birge ratio of the manoeuvres.
    pub birge: f64,
    /// Error of the mean slips by their fluctuation, as a share of it.
    pub wavering: f64,
    /// Standard deviations by the distance beyond the prior, an unknown load, and other doubts.
    pub beyond: Each<f64>,
    /// Stated ratio, independent of the slips.
    pub stated: Option<Quantity>,
    /// Standard deviation that spans the ratio and its prior, where the ratio is doubted.
    pub spans: f64,
    /// The state is at a bound.
    pub at_limit: Each<bool>,
    /// The machine is loaded, and a lift of the load would not be reported.
    pub unknown_height: bool,
    /// The first cause.
    pub reason: Reason,
    /// The load may have changed, as far as the wheels show.
    pub changing: bool,
    /// Action on the machine that its model does not contain: the reason of innovations that are too large.
    pub acts: Reason,
    /// A drive in the other direction would identify the error that keeps the ratio from being trusted.
    pub one_way: bool,
}

impl Doubt {
    /// Nothing is doubtful.
    pub const NONE: Self = Self {
        ratio_std: 0.0,
        birge: 1.0,
        wavering: 0.0,
        beyond: Each {
            ratio: 0.0,
            height: 0.0,
        },
        stated: None,
        spans: 0.0,
        at_limit: Each {
            ratio: false,
            height: false,
        },
        unknown_height: false,
        reason: Reason::None,
        changing: false,
        acts: Reason::None,
        one_way: false,
    };
}

/// Exponentially weighted mean and variance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Variation {
    mean: f64,
    variance: f64,
    started: bool,
}

impl Variation {
    fn update(&mut self, value: f64, weight: f64) {
        if !self.started {
            *self = Self {
                mean: value,
                variance: 0.0,
                started: true,
            };
        }
        let away = value - self.mean;
        self.mean += weight * away;
        self.variance = (1.0 - weight) * (self.variance + weight * away * away);
    }

    fn std(&self) -> f64 {
        sqrt(self.variance)
    }
}

/// Memory of the verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Evidence {
    torque: Variation,
    acceleration: Variation,
    /// Ages of the last accepted speed and wheel speeds, and of the last torques, slope and specific force [s].
    age: [f64; WATCHED],
    /// Ages of the last speed and wheel speeds that came, accepted or not [s].
    came: [f64; 3],
    /// The specific force is a required input.
    accelerometer: bool,
    /// A signal is stuck.
    pub stuck: Option<usize>,
    /// Time for which every measured speed and wheel speed was rejected [s].
    pub locked_out: f64,
    /// Running mean of the normalised innovation squared per measurement.
    pub consistency: f64,
    /// Time since the start or the last reset [s].
    pub since_reset: f64,
    /// Resets so far.
    pub resets: u32,
}

/// Verdict of one row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Verdict {
    pub excited: Each<bool>,
    pub consistent: bool,
    pub fresh: bool,
    pub identifiable: Each<bool>,
    pub converged: Each<bool>,
    pub reset: bool,
    pub reason: Reason,
}

/// Standard deviations of the two parameters that carry a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Intervals {
    /// Of the filter.
    pub filter: Each<f64>,
    /// As reported, floors included.
    pub reported: Each<f64>,
    /// The ratio itself: its limit is relative.
    pub ratio: f64,
}

impl Evidence {
    /// Before the first row; `accelerometer`: the specific force is a required input.
    pub fn new(accelerometer: bool) -> Self {
        Self {
            torque: Variation::default(),
            acceleration: Variation::default(),
            age: [f64::INFINITY; WATCHED],
            came: [f64::INFINITY; 3],
            accelerometer,
            stuck: None,
            locked_out: 0.0,
            consistency: 1.0,
            since_reset: 0.0,
            resets: 0,
        }
    }

    /// Advances the time; the motion of the row counts as excitation.
    pub fn advance(&mut self, dt: f64, total_torque: f64, acceleration: Option<f64>) {
        let weight = (dt / EXCITATION_TIME).min(1.0);
        self.torque.update(total_torque, weight);
        if let Some(acceleration) = acceleration {
            self.acceleration.update(acceleration, weight);
        }
        for age in &mut self.age {
            *age += dt;
        }
        for age in &mut self.came {
            *age += dt;
        }
        self.since_reset += dt;
    }

    /// Takes the plausible inputs of the row.
    pub fn receive(&mut self, sample: &Sample) {
        let inputs = [
            sample.front_torque,
            sample.rear_torque,
            sample.slope,
            sample.acceleration,
        ];
        for (age, input) in self.age[3..].iter_mut().zip(inputs) {
            if input.is_some() {
                *age = 0.0;
            }
        }
        let motion = [
            sample.speed,
            sample.front_wheel_speed,
            sample.rear_wheel_speed,
        ];
        for (age, input) in self.came.iter_mut().zip(motion) {
            if input.is_some() {
                *age = 0.0;
            }
        }
    }

    /// Whether a torque has been missing for longer than an input stays fresh: the wheels then carry no information.
    pub fn torque_lost(&self, limit: f64) -> bool {
        self.age[3].max(self.age[4]) > limit
    }

    /// Number of the watched inputs that are required.
    fn required(&self) -> usize {
        WATCHED - usize::from(!self.accelerometer)
    }

    /// Whether every required input is recent.
    fn fresh(&self, limit: f64) -> bool {
        self.stuck.is_none() && self.age[..self.required()].iter().all(|age| *age <= limit)
    }

    /// Whether a required input is missing; one that is present may have been rejected.
    fn missing(&self, limit: f64) -> bool {
        let inputs = &self.age[3..self.required()];
        self.came.iter().chain(inputs).any(|age| *age > limit)
    }

    /// Takes which of the row's measurements were accepted; `came`: any of them was present.
    pub fn admit(&mut self, came: bool, accepted: &[bool], dt: f64) {
        if accepted.iter().take(3).any(|a| *a) {
            self.locked_out = 0.0;
        } else if came {
            self.locked_out += dt;
        }
        for (age, accepted) in self.age[..3].iter_mut().zip(accepted) {
            if *accepted {
                *age = 0.0;
            }
        }
    }

    /// Counts the wheel speeds as fresh: they are present and consistent, but not used.
    pub fn set_aside(&mut self) {
        (self.age[1], self.age[2]) = (0.0, 0.0);
    }

    /// Updates the mean with the normalised innovation squared of the row, per accepted measurement.
    pub fn judge(&mut self, nis: f64, weight: f64) {
        self.consistency += weight * (nis - self.consistency);
    }

    /// Takes a restart of the filter.
    pub fn restart(&mut self) {
        self.consistency = 1.0;
        self.since_reset = 0.0;
        self.resets += 1;
    }

    pub fn verdict(
        &self,
        settings: &Settings,
        intervals: &Intervals,
        doubt: &Doubt,
        frozen: bool,
    ) -> Verdict {
        let limits = &settings.estimator;
        let fresh = self.fresh(limits.fresh);
        let consistent = self.consistency <= limits.consistent_nis && doubt.reason == Reason::None;
        let reset = self.resets > 0 && self.since_reset < RESET_SHOWN;
        let (known, prior) = (intervals.filter, &settings.prior);
        // A ratio with a narrow prior need not be narrowed by the slips, but checked.
        let checked = limits.converged_ratio * intervals.ratio;
        let observable = Each {
            ratio: known.ratio <= OBSERVABLE.ratio * prior.cg_ratio_std.max(checked),
            height: known.height <= OBSERVABLE.height * prior.cg_height_std,
        };
        let converged = Each {
            ratio: intervals.reported.ratio <= limits.converged_ratio * intervals.ratio.abs(),
            height: intervals.reported.height <= limits.converged_height,
        };
        let lacks_accelerometer = !self.accelerometer && !converged.ratio && settings.at_work();
        Verdict {
            excited: Each {
                ratio: !frozen && self.torque.std() >= limits.excited_torque,
                height: !frozen && self.acceleration.std() >= limits.excited_acceleration,
            },
            consistent,
            fresh,
            identifiable: Each {
                ratio: observable.ratio && !doubt.at_limit.ratio,
                height: observable.height && !doubt.at_limit.height && !doubt.unknown_height,
            },
            converged,
            reset,
            reason: match self.reason(limits.fresh, [fresh, consistent], doubt) {
                reason if lacks_accelerometer => without_accelerometer(reason),
                reason => reason,
            },
        }
    }

    /// Returns why the estimate is not fresh or not consistent, or what keeps it from being known.
    fn reason(&self, limit: f64, [fresh, consistent]: [bool; 2], doubt: &Doubt) -> Reason {
        match self.stuck {
            Some(signal) => Reason::stuck(signal),
            None if !fresh && self.missing(limit) => Reason::Missing,
            None if doubt.reason != Reason::None => doubt.reason,
            None if !(fresh && consistent) && doubt.acts == Reason::None => Reason::Unexplained,
            None if doubt.acts == Reason::None && doubt.one_way => Reason::OneWay,
            None => doubt.acts,
        }
    }
}

/// Replaces reasons that may be false without an accelerometer, which distinguishes slope from slip.
fn without_accelerometer(reason: Reason) -> Reason {
    match reason {
        Reason::Stiffness
        | Reason::Radius
        | Reason::AtLimit
        | Reason::Disagreement
        | Reason::Unexplained
        | Reason::OneWay
        | Reason::None => Reason::Accelerometer,
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: f64 = Settings::DEFAULT.estimator.fresh;

    /// Evidence of rows with all inputs but those that `change` takes away, whose wheel speeds are all rejected.
    fn rejected(change: impl Fn(&mut Sample)) -> Evidence {
        let mut sample = Sample {
            speed: Some(1.0),
            front_wheel_speed: Some(2.0),
            rear_wheel_speed: Some(2.0),
            front_torque: Some(0.0),
            rear_torque: Some(0.0),
            slope: Some(0.0),
            ..Sample::default()
        };
        change(&mut sample);
        let mut evidence = Evidence::new(false);
        for _ in 0..100 {
            evidence.advance(0.01, 0.0, None);
            evidence.receive(&sample);
            evidence.admit(true, &[true, false, false], 0.01);
        }
        evidence
    }

    #[test]
    fn what_came_and_was_rejected_is_not_called_missing() {
        let evidence = rejected(|_| {});
        assert!(!evidence.fresh(LIMIT) && !evidence.missing(LIMIT));
        assert_eq!(
            evidence.reason(LIMIT, [false; 2], &Doubt::NONE),
            Reason::Unexplained
        );
        let lost = rejected(|sample| sample.rear_wheel_speed = None);
        assert_eq!(
            lost.reason(LIMIT, [false; 2], &Doubt::NONE),
            Reason::Missing
        );
    }

    #[test]
    fn a_ratio_that_stays_unknown_without_an_accelerometer_has_that_reason() {
        let reported = |ratio: f64, accelerometer: bool| {
            let mut evidence = rejected(|_| {});
            evidence.accelerometer = accelerometer;
            evidence.age = [0.0; WATCHED];
            let wide = Each { ratio, height: 1.0 };
            let intervals = Intervals {
                filter: wide,
                reported: wide,
                ratio: 0.5,
            };
            let doubt = Doubt {
                reason: Reason::Stiffness,
                ..Doubt::NONE
            };
            let verdict = evidence.verdict(&Settings::DEFAULT, &intervals, &doubt, false);
            verdict.reason
        };
        assert_eq!(reported(0.1, false), Reason::Accelerometer);
        assert_eq!(reported(0.1, true), Reason::Stiffness);
        assert_eq!(reported(0.01, false), Reason::Stiffness);
    }
}
