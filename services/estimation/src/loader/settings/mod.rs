//! Settings of the estimator: the tables of a description, read as they are, and how much of a real machine the filter models. SI
//! units.
//!
//! | file | idea |
//! |---|---|
//! | `described` | from a description to the settings of a method |
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

/// How much of a real machine the filter models, each level more than the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Realism {
    /// A linear, rigid tyre and parameters without bounds.
    Paper,
    /// The friction limit and the load sensitivity of the tyre, bounds of the parameters.
    Tyre,
    /// Bad input: gates, digging, gaps, restarts.
    Protected,
    /// A machine at work. Tyres wind up, wheel speeds are quantised, speeds are late, loads shift, and parameters wander in gaps.
    /// What the start taught is learnt again.
    ///
    /// Inputs are checked: a value that never changes is missing, and wheel speeds count only with their torques, without brakes
    /// and steering. The slope counts as far as the motion confirms it, and manoeuvres must agree.
    AtWork,
}

/// All settings of the estimator.
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
    /// Which of them act.
    pub realism: Realism,
}

impl Settings {
    /// Whether the tyre is a real one.
    pub(super) fn real_tyre(&self) -> bool {
        self.realism >= Realism::Tyre
    }

    /// Standard deviation of the load sensitivity of the rolling radii, at least its floor.
    pub(super) fn load_sensitivity_std(&self) -> f64 {
        let stated = self.machine.radius_load_sensitivity_std;
        stated.max(self.estimator.load_sensitivity_floor)
    }

    /// Whether the filter is protected against bad input.
    pub(super) fn protected(&self) -> bool {
        self.realism >= Realism::Protected
    }

    /// Whether the machine is taken for one at work.
    pub(super) fn at_work(&self) -> bool {
        self.realism >= Realism::AtWork
    }

    /// Gravity: the standard value, but for the filters with published numbers [m/s^2].
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

    /// Step between rows after which speeds are reset to their measurements [s].
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
