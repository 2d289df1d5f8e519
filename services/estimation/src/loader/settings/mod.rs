//! What the estimator is given: the tables of a description, read as they are, and how much of a real machine the filter
//! reckons with. SI units.
//!
//! | file | idea |
//! |---|---|
//! | `described` | what a description means for a method |
//! | `presets` | each filter as a difference to the defaults of the keys |
//! | `check` | which settings can be used |

use crate::GRAVITY;
use crate::keys::Range;

mod check;
mod described;
mod presets;

pub use super::keys::{
    Estimator, Inputs, LiftArm, LiftCylinder, LoadTransfer, Machine, Prior, Sensors,
};
pub use check::{MustBe, SettingsError};

/// Gravity of the paper and of the golden vectors of the filters that it specifies [m/s^2].
const PAPERS_GRAVITY: f64 = 9.81;

/// How much of a real machine the filter reckons with, each more than the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Realism {
    /// A linear, rigid tyre and parameters without bounds.
    Paper,
    /// The friction limit and the load sensitivity of the tyre, bounds of the parameters.
    Tyre,
    /// Bad input: gates, digging, gaps, restarts.
    Protected,
    /// A machine at work: tyres wind up, wheel speeds come in steps, speeds late, loads shift, what the start taught is
    /// learnt again, parameters wander in gaps, and inputs are doubted: a value that never changes is missing, wheel
    /// speeds count only with their torques and without brakes and steering, the slope as far as the motion bears it out,
    /// and manoeuvres must agree.
    AtWork,
}

/// Everything the estimator is given.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// The machine.
    pub machine: Machine,
    /// Its lift arm.
    pub lift_arm: LiftArm,
    /// The cylinders of the arm.
    pub lift_cylinder: LiftCylinder,
    /// Its sensors.
    pub sensors: Sensors,
    /// The prior.
    pub prior: Prior,
    /// Noises, protections, floors and limits of the verdict.
    pub estimator: Estimator,
    /// What of them acts.
    pub realism: Realism,
}

impl Settings {
    /// Whether the tyre is a real one.
    pub(super) fn real_tyre(&self) -> bool {
        self.realism >= Realism::Tyre
    }

    /// Standard deviation of the load sensitivity of the rolling radii, however sure the description is.
    pub(super) fn load_sensitivity_std(&self) -> f64 {
        let stated = self.machine.radius_load_sensitivity_std;
        stated.max(self.estimator.load_sensitivity_floor)
    }

    /// Whether bad input is expected.
    pub(super) fn protected(&self) -> bool {
        self.realism >= Realism::Protected
    }

    /// Whether the machine is taken for one at work.
    pub(super) fn at_work(&self) -> bool {
        self.realism >= Realism::AtWork
    }

    /// Gravity: standard but for the filters whose numbers others have printed [m/s^2].
    pub(super) fn gravity(&self) -> f64 {
        if self.at_work() {
            GRAVITY
        } else {
            PAPERS_GRAVITY
        }
    }

    /// Friction limit of tyre on ground; infinite for the linear tyre.
    pub(super) fn friction(&self) -> f64 {
        if self.real_tyre() && self.machine.friction > 0.0 {
            self.machine.friction
        } else {
            f64::INFINITY
        }
    }

    /// Step between rows after which speeds are taken anew [s].
    pub(super) fn gap(&self) -> f64 {
        if self.protected() {
            self.estimator.gap
        } else {
            f64::INFINITY
        }
    }

    /// Bounds of K, h, lam.
    pub(super) fn bounds(&self) -> [Range; 3] {
        let e = &self.estimator;
        let bounds = [
            (e.slip_stiffness_min, e.slip_stiffness_max),
            (e.cg_height_min, e.cg_height_max),
            (e.cg_ratio_min, e.cg_ratio_max),
        ];
        bounds.map(|(low, high)| {
            if self.real_tyre() {
                Range { low, high }
            } else {
                Range {
                    low: f64::NEG_INFINITY,
                    high: f64::INFINITY,
                }
            }
        })
    }
}
