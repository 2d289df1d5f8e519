//! Regression stage: swing motion in, inertia out (process `rls`).
//!
//! # The paper (`multi-forgetting-rls`)
//!
//! Eq. 12, with its total torque T_t, is written as `0 = J a + b w - T_t`. The regressor is
//! phi = (a, w, -1), theta = (J, b, T_t), and the output 0 (Eqs. 13-15). Before each update the
//! nominal rule (Eqs. 28-29) resets b to its nominal value if it deviates by more than epsilon. The
//! source subtracts J from b in Eq. 28, and its Eq. 29 conflicts with the joint solution; here the
//! rule acts on the value before the update. Inside change windows another triple of forgetting
//! factors applies (section 3.5; the source does not state which one).
//!
//! The output is 0, so the recursion is homogeneous: twice the initial theta gives twice every
//! estimate. **J is not identified.** An initial error of 20 % stays 20 %. The reported standard
//! deviation is that of the prior, and the verdict is never `identifiable`.
//!
//! # Measured torque (`svf-rls`)
//!
//! All signals pass equal filters: `T_f = J a_f + b w_f + Fc s_f + offset 1_f`. The regression
//! estimates only the inertia (one scalar, forgetting 0.9, above a least acceleration), or with
//! `estimate_damping`, `estimate_friction`, `estimate_offset` these too, by ordinary RLS. It lacks the
//! posture term Jd w: while an arm moves the error reaches 25 % and more.

pub(in crate::excavator) mod joint;
pub(in crate::excavator) mod single;
pub(in crate::excavator) mod svf;

use super::estimate::{Estimate, Flags, Method};
use super::joint::JointRegression;
use super::motion::Motion;
use super::reason::Reason;
use super::settings::{PartialRange, Settings};
use super::settings_error::SettingsError;
use super::single::SingleRegression;
use crate::Quantity;
use crate::consistency::{MOST_NIS, NisWindow};
use crate::rls::MultipleForgettingRls;

#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "no allocator; one per process")]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Kind {
    Paper(MultipleForgettingRls<3>),
    Single(SingleRegression),
    Joint(JointRegression),
}

/// The regression estimators.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Regression {
    settings: Settings,
    method: Method,
    kind: Kind,
    nis: NisWindow<50>,
    running_for: f64,
    /// Time of the last motion [s].
    time: Option<f64>,
    /// Whether the torque alone identifies the inertia of this machine, see [`Settings::is_partly_identifiable`].
    tells: bool,
    /// Range of the inertia otherwise.
    partial_range: PartialRange,
    /// Time since the last torque; infinite before the first [s].
    torque_age: f64,
    refused: u64,
    last: Estimate,
}

/// Result of one update.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fit {
    pub(super) inertia: Quantity,
    pub(super) damping: Option<Quantity>,
    pub(super) torque: Option<Quantity>,
    pub(super) friction: Option<Quantity>,
    pub(super) offset: Option<Quantity>,
    pub(super) forgetting: [f64; 3],
    pub(super) nominal: bool,
    pub(super) window: bool,
    pub(super) identifiable: bool,
}

impl Regression {
    /// Checks the settings. `method` is `MultiForgettingRls` or `SvfRls`; `Auto` is `SvfRls`.
    pub fn new(settings: &Settings, method: Method) -> Result<Self, SettingsError> {
        settings.check()?;
        let e = &settings.estimator;
        let joint = e.estimate_damping || e.estimate_friction || e.estimate_offset;
        let (method, kind) = match method {
            Method::MultiForgettingRls => (method, Kind::Paper(paper(settings))),
            Method::SvfRls | Method::Auto if joint => {
                (Method::SvfRls, Kind::Joint(JointRegression::new(settings)))
            }
            Method::SvfRls | Method::Auto => (
                Method::SvfRls,
                Kind::Single(SingleRegression::new(settings)),
            ),
            other => {
                return Err(SettingsError::WrongStage {
                    method: other.name(),
                });
            }
        };
        let last = Estimate {
            inertia: settings.prior.inertia,
            inertia_std: settings.prior.inertia_std,
            method,
            ..Estimate::default()
        };
        Ok(Self {
            settings: *settings,
            method,
            kind,
            nis: NisWindow::new(MOST_NIS),
            running_for: 0.0,
            time: None,
            tells: settings.is_partly_identifiable(),
            partial_range: settings.partial_range(None),
            torque_age: f64::INFINITY,
            refused: 0,
            last,
        })
    }

    /// The settings as stated.
    pub fn described(&self) -> Settings {
        self.settings
    }

    /// Takes one motion and always returns an estimate.
    pub fn step(&mut self, motion: &Motion) -> Estimate {
        if motion.refused || !motion.time.is_finite() {
            self.refused += 1;
            let mut again = self.last;
            again.refused = self.refused;
            again.flags.refused = true;
            return again;
        }
        self.forget(motion);
        self.torque_age = if motion.torque_measured {
            0.0
        } else {
            self.torque_age + motion.period
        };
        let held = self.holds(motion);
        let fit = self.update(motion, held);
        self.last = self.estimate(motion, &fit, held);
        self.last
    }

    /// Applies the forgetting of samples that did not reach the regression.
    fn forget(&mut self, motion: &Motion) {
        let last = self.time.replace(motion.time);
        let missed = last.map_or(0.0, |last| motion.time - last - motion.period);
        if missed < 0.5 * motion.period {
            return;
        }
        match &mut self.kind {
            Kind::Paper(_) => {} // J stays at its initial value, see above
            Kind::Single(single) => single.forget(&self.settings, missed, motion.period),
            Kind::Joint(joint) => joint.forget(&self.settings, missed, motion.period),
        }
    }

    /// Whether the regression pauses: outside its stated time, at standstill, or before the filters have settled.
    fn holds(&mut self, motion: &Motion) -> bool {
        let p = &self.settings.paper;
        let settling = 5.0 / self.settings.estimator.filter_frequency;
        self.running_for = if motion.period > settling {
            0.0
        } else {
            self.running_for + motion.period
        };
        match self.kind {
            Kind::Paper(_) => {
                // Half a period of tolerance: 9.3 is not a binary fraction.
                let slack = 0.5 * motion.period;
                p.start_time.is_some_and(|t| motion.time < t - slack)
                    || p.stop_time.is_some_and(|t| motion.time > t + slack)
                    || p.hold_at_standstill() && motion.standstill
            }
            _ => self.running_for < settling || self.torque_age.is_infinite(),
        }
    }

    fn update(&mut self, motion: &Motion, held: bool) -> Fit {
        let s = &self.settings;
        match &mut self.kind {
            Kind::Paper(rls) => paper_step(s, rls, motion, held),
            Kind::Single(single) => single.step(s, motion, self.torque_age, held),
            Kind::Joint(joint) => joint.step(s, motion, self.torque_age, held),
        }
    }

    fn estimate(&mut self, motion: &Motion, fit: &Fit, held: bool) -> Estimate {
        let e = &self.settings.estimator;
        let nis = if motion.innovation_std > 0.0 {
            let z = motion.innovation / motion.innovation_std;
            z * z
        } else {
            0.0
        };
        if motion.measured && !motion.standstill {
            self.nis.push(nis);
        }
        let paper = self.method == Method::MultiForgettingRls;
        let excited = if paper {
            motion.velocity.abs() >= e.excited_velocity
        } else {
            !held && motion.filtered_acceleration.abs() > e.svf_acceleration_min
        };
        // The joint regression does not use the Kalman filter; its own residual measures the noise.
        let measured_noise = matches!(self.kind, Kind::Joint(_));
        let fresh = motion.age <= e.fresh_velocity && (paper || self.torque_age <= e.fresh_others);
        let mut inertia = fit.inertia;
        if !self.tells {
            inertia.std = self.partial_range.widened(inertia.value, inertia.std);
        }
        Estimate {
            inertia: inertia.value,
            inertia_std: inertia.std,
            damping: fit.damping,
            torque: fit.torque,
            friction: fit.friction,
            offset: fit.offset,
            velocity: motion.velocity,
            acceleration: motion.acceleration,
            nis,
            flags: Flags {
                excited,
                consistent: measured_noise || self.nis.mean() <= e.consistent_nis,
                fresh,
                converged: crate::HALF_WIDTH_95 * inertia.std < e.converged_share * inertia.value,
                identifiable: fit.identifiable && self.tells,
                held,
                nominal: fit.nominal,
                window: fit.window,
                ..Flags::default()
            },
            method: self.method,
            forgetting: fit.forgetting,
            refused: self.refused,
            reason: if self.tells {
                Reason::None
            } else {
                Reason::Method
            },
            ..Estimate::default()
        }
    }
}

fn paper(settings: &Settings) -> MultipleForgettingRls<3> {
    let p = &settings.paper;
    MultipleForgettingRls::new(
        [settings.prior.inertia, settings.nominal_damping, p.torque],
        p.covariance,
    )
}

/// Update by Eqs. 12-29 with one sample.
fn paper_step(
    settings: &Settings,
    rls: &mut MultipleForgettingRls<3>,
    motion: &Motion,
    held: bool,
) -> Fit {
    let p = &settings.paper;
    let window = in_window(settings, motion);
    let forgetting = if window {
        p.lambda_window
    } else {
        p.lambda_normal
    };
    let mut nominal = false;
    if !held {
        let distance = settings.nominal_damping - rls.parameters[1]; // (28)
        nominal = p.nominal_rule && distance.abs() > settings.estimator.epsilon;
        if nominal {
            rls.parameters[1] = settings.nominal_damping; // (29)
        }
        let regressor = [motion.acceleration, motion.velocity, -1.0]; // (14)
        rls.update(&regressor, 0.0, &forgetting); // (26)
    }
    if !rls.parameters.iter().all(|x| x.is_finite()) {
        *rls = paper(settings);
    }
    let [inertia, damping, torque] = rls.parameters;
    let relative = settings.prior.inertia_std / settings.prior.inertia;
    Fit {
        // The prior determines the scale, and so its uncertainty.
        inertia: Quantity {
            value: inertia,
            std: relative * inertia.abs(),
        },
        damping: Some(Quantity {
            value: damping,
            std: relative * damping.abs(),
        }),
        torque: Some(Quantity {
            value: torque,
            std: relative * torque.abs(),
        }),
        forgetting,
        nominal,
        window,
        identifiable: false,
        ..Fit::default()
    }
}

/// Whether `tc <= t < tc + delay` for a stated or a detected change.
fn in_window(settings: &Settings, motion: &Motion) -> bool {
    let times = &settings.paper.change_times;
    if times.is_empty() {
        return motion.manoeuvre;
    }
    // A nanosecond of tolerance: recorded times are decimal fractions.
    let t = motion.time + 1e-9;
    times
        .iter()
        .any(|&tc| (tc..tc + motion.convergence_delay).contains(&t))
}
