//! Settings of every excavator estimator; the default is the reference machine.

use super::geometry::Geometry;

/// What is assumed of damping, torque offset and payload. `torque`, `posture` and `velocity` hold the
/// damping fixed; unless it is `Known`, `prior.damping_std` widens their interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Variant {
    /// Payload that may change, noticed by itself (`posture-torque`); damping and torque offset held
    /// at their nominal values, with their uncertainty in the interval (`torque`).
    #[default]
    Auto,
    /// Damping and torque are calibrated.
    Known,
    /// Damping and torque offset estimated, payload constant while moving.
    Tolerant,
    /// As tolerant, with the older drop model; for comparison (for `torque`: as `Tolerant`).
    Drop,
}

/// Sensors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensors {
    /// Samples per second; only the first sample needs it, later ones bring their time [Hz].
    pub rate: f64,
    /// Noise of a velocity sample (sigma_w) [rad/s].
    pub swing_velocity_std: f64,
    /// Noise of a swing angle sample [rad].
    pub swing_angle_std: f64,
    /// Noise of a torque sample (sigma_T) [N m].
    pub swing_torque_std: f64,
    /// Standard deviation of the torque's gain about 1. No estimator can notice it; it widens the
    /// interval.
    pub swing_torque_gain_std: f64,
    /// A velocity of this size or more is missing [rad/s].
    pub swing_velocity_limit: f64,
    /// A joint angle of this size or more is missing [rad].
    pub angle_limit: f64,
    /// Measured over true torque, as calibrated.
    pub swing_torque_gain: f64,
    /// Torque that is measured where there is none, as calibrated [N m].
    pub swing_torque_offset: f64,
}

/// What is known before the first sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Swing inertia [kg m^2].
    pub inertia: f64,
    /// Its standard deviation [kg m^2].
    pub inertia_std: f64,
    /// Payload [kg].
    pub payload: f64,
    /// Its standard deviation [kg].
    pub payload_std: f64,
    /// Standard deviation of the damping about its nominal value (s_b), not for `Known`; 0 says that
    /// it is calibrated [N m s/rad].
    pub damping_std: f64,
    /// Standard deviation of the torque offset (s_d) [N m].
    pub torque_offset_std: f64,
    /// The same for `Known` [N m].
    pub known_torque_offset_std: f64,
    /// Standard deviation of the Coulomb friction about its nominal value [N m].
    pub friction_std: f64,
}

/// The regression of the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paper {
    /// Known times of torque changes [s]; all `None` finds them online.
    pub change_times: [Option<f64>; 8],
    /// Forgetting of inertia, damping and torque outside the change windows.
    pub lambda_normal: [f64; 3],
    /// The same inside the change windows.
    pub lambda_window: [f64; 3],
    /// Initial variances P_i of the three.
    pub covariance: [f64; 3],
    /// Initial total torque [N m].
    pub torque: f64,
    /// The nominal-parameter rule (Eqs. 28-29) is on.
    pub nominal_rule: bool,
    /// The regression begins at this time [s].
    pub start_time: Option<f64>,
    /// It holds its estimate after this time [s].
    pub stop_time: Option<f64>,
    /// No regression at standstill.
    pub hold_at_standstill: bool,
}

/// Constants of the estimators.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimator {
    /// Natural frequency of the equal filters [rad/s].
    pub filter_frequency: f64,
    /// Their damping ratio.
    pub filter_damping: f64,
    /// Random walk of the acceleration in the Kalman filter, variance per second (q_c)
    /// [rad^2/s^5]; per step q = q_c T.
    pub q_c: f64,
    /// Length of a change window [s]; `None` computes it from the gain.
    pub convergence_delay: Option<f64>,
    /// Forgetting of `svf-rls` per sample; `None` takes 0.9 per 0.01 s at any rate, or a memory of
    /// 20 s where other parameters are estimated beside the inertia.
    pub forgetting: Option<f64>,
    /// The nominal rule acts beyond this distance from the nominal damping [N m s/rad].
    pub epsilon: f64,
    /// `svf-rls` estimates the viscous damping.
    pub estimate_damping: bool,
    /// `svf-rls` estimates the Coulomb friction.
    pub estimate_friction: bool,
    /// `svf-rls` estimates a torque offset.
    pub estimate_offset: bool,
    /// The caller declares that the inertia does not change.
    pub constant_inertia: bool,
    /// Assumptions of the methods with torque.
    pub variant: Variant,
    /// Velocity over which the friction changes sign in the joint estimators [rad/s].
    pub friction_width: f64,
    /// The same in the equal filters [rad/s].
    pub svf_friction_width: f64,
    /// `svf-rls` learns the inertia above this filtered acceleration [rad/s^2].
    pub svf_acceleration_min: f64,
    /// Variance of `svf-rls` at the start and its largest value.
    pub svf_covariance: f64,
    /// The torque enters each step as the mean of two samples, with variance (sigma_T / this)^2. 1.41
    /// would be right if the means were independent; but each sample is in two of them, so that over
    /// many steps nothing averages out: 1, by which the interval holds the truth also where the
    /// torque noise decides (coverage 91 instead of 81 % on a machine of a third of the inertia).
    pub torque_noise_divisor: f64,
    /// Innovations beyond this many standard deviations are weakened.
    pub gate: f64,
    /// Innovations beyond this many standard deviations are dropped, at most three in a row.
    pub reject: f64,
    /// Smallest payload [kg].
    pub payload_min: f64,
    /// Largest payload [kg].
    pub payload_max: f64,
    /// Random walk of the payload, variance per second (q_m) [kg^2/s].
    pub q_m: f64,
    /// Random walk of ln J, variance per second (q_l) [1/s].
    pub q_l: f64,
    /// Factor of the reported standard deviation of `torque`, known damping (c_I).
    pub interval_factor: f64,
    /// Velocity bias is measured over the first 0.5 s at rest.
    pub calibrate_at_rest: bool,
    /// Velocity noise is measured in the same time.
    pub measure_noise_at_rest: bool,
    /// After a stand of this length the payload may be another [s].
    pub reopen_after: f64,
    /// Second, more sensitive detector of torque changes.
    pub weak_onset: bool,
    /// Bucket opening rate that announces a change of payload [rad/s].
    pub opening_rate: f64,
    /// Share of the payload that leaves per angle of opening [1/rad].
    pub opening_decay: f64,
    /// Largest free change of payload per angle of opening [kg/rad].
    pub opening_change_max: f64,
    /// Free change of payload after an alarm and in the second filter [kg/s].
    pub change_rate_std: f64,
    /// Sum of normalised innovations at which a changed payload is declared.
    pub change_threshold: f64,
    /// Random walk of the payload in the second model of `Drop`, variance per second [kg^2/s].
    pub drop_q_m: f64,
    /// Relative random walk of the inertia in `velocity` [1/sqrt(s)].
    pub velocity_drift: f64,
    /// The same with constant inertia.
    pub velocity_drift_constant: f64,
    /// Random walk of the torque in `velocity` [N m/sqrt(s)].
    pub velocity_torque_drift: f64,
    /// The same with constant inertia.
    pub velocity_torque_drift_constant: f64,
    /// Verdict: excited at this velocity [rad/s].
    pub excited_velocity: f64,
    /// Verdict: consistent up to this mean of the normalised innovations squared.
    pub consistent_nis: f64,
    /// Verdict: converged when the half width of the 95 % interval is below this share.
    pub converged_share: f64,
    /// Verdict: fresh with a velocity at most this old [s].
    pub fresh_velocity: f64,
    /// Verdict: fresh with torque and angles at most this old [s].
    pub fresh_others: f64,
}

/// Everything an excavator estimator needs to know beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Lengths and masses.
    pub geometry: Geometry,
    /// Viscous damping of the swing (b-bar) [N m s/rad].
    pub nominal_damping: f64,
    /// Coulomb friction torque (T_f) [N m].
    pub coulomb_friction: f64,
    /// Smallest inertia that an estimate may take [kg m^2].
    pub inertia_min: f64,
    /// Largest inertia that an estimate may take [kg m^2].
    pub inertia_max: f64,
    /// Sensors.
    pub sensors: Sensors,
    /// Prior.
    pub prior: Prior,
    /// Constants.
    pub estimator: Estimator,
    /// The paper's regression.
    pub paper: Paper,
}

impl Settings {
    /// The configuration that reproduces Table 1 of the paper on its own cycle, starting at
    /// `inertia`: the figures are reached only by starting at the true one.
    pub fn paper(inertia: f64) -> Self {
        let mut settings = Self::default();
        settings.prior.inertia = inertia;
        settings.estimator.calibrate_at_rest = false;
        settings.estimator.convergence_delay = Some(0.25);
        settings.paper.change_times[0] = Some(5.5);
        settings.paper.change_times[1] = Some(7.5);
        settings.paper.start_time = Some(5.5);
        settings.paper.stop_time = Some(9.3);
        settings.paper.hold_at_standstill = false;
        settings
    }

    /// Smallest and largest payload that an estimate may take: as set, but never less than what the
    /// prior holds possible [kg].
    pub(super) fn payload_range(&self) -> [f64; 2] {
        let prior = self.prior.payload + 4.0 * self.prior.payload_std;
        let e = &self.estimator;
        [e.payload_min, e.payload_max.max(prior)]
    }
}
