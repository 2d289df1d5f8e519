//! Test of the stated mass against force over acceleration, and detection of unreported loads.
//!
//! It uses all rows, and those in which the torques drive. Unreported brakes make the machine look lighter while it brakes, and have no
//! effect while it drives.

use super::inertia::{Inertia, Push};
use super::unreported_load::{BETWEEN, BETWEEN_STATED, SLOW, UnreportedLoad};

/// Change of a reported mass beyond which it is weighed, as a share.
const WEIGHS: f64 = 0.01;

/// State of the test.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StatedMass {
    /// Mass of the first row [kg]. A reported mass that has changed since is weighed, and not only stated.
    first: f64,
    is_weighed: bool,
    /// Estimates by all rows, and by those in which the torques drive.
    inertia: Inertia,
    driven: Inertia,
    unreported_load: UnreportedLoad,
    /// As [`Self::lighter`].
    lighter: f64,
}

/// Conditions of a row.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// The row states the mass with its load.
    pub states_mass: bool,
    /// The torques alone move the machine.
    pub tells: bool,
    /// The torques drive the machine.
    pub drives: bool,
    /// The machine is so slow that stiction and the ground act.
    pub stands: bool,
    /// An external force acts that the torques do not explain.
    pub pushes: bool,
}

impl StatedMass {
    /// Updates with a row and the mass that is used [kg].
    pub fn see(&mut self, mass: f64, row: &Push, kind: &Kind, dt: f64) {
        if self.first == 0.0 {
            self.first = mass;
        }
        let changed = (mass - self.first).abs() > WEIGHS * mass;
        self.is_weighed |= kind.states_mass && changed;
        if self.is_weighed {
            self.inertia.mass_is_reported();
            self.driven.mass_is_reported();
        }
        let drives = kind.tells && kind.drives;
        self.driven.see(row, drives, true, dt);
        let lighter = self.driven.excess().max(0.0);
        self.inertia.see(row, kind.tells, lighter > 0.0, dt);
        self.lighter = self.inertia.excess().min(lighter);
        if self.is_weighed || self.inertia.stepped() {
            self.unreported_load.settle();
        } else {
            self.expect_load(row, kind, dt);
        }
    }

    /// Updates the probability of an unreported load, which may come or go while the machine is idle.
    fn expect_load(&mut self, row: &Push, kind: &Kind, dt: f64) {
        // A machine that has carried an unreported load may take up another whenever it is slow.
        let carries = self.inertia.since_step().is_finite();
        let slow = row.speed.abs() < SLOW;
        let idle = kind.stands || slow && (kind.pushes || carries);
        let between = if kind.states_mass {
            BETWEEN_STATED
        } else {
            BETWEEN
        };
        let idle = if idle { (dt / between).min(1.0) } else { 0.0 };
        let tells = kind.tells && !(slow && carries);
        let (signals, known) = (self.inertia.signals(), self.inertia.known());
        self.unreported_load.see(signals, known, idle, tells, dt);
    }

    /// Excess of kappa over 1 beyond tolerances and chance: the machine is lighter (or its torques larger) than stated. Negative where it
    /// is heavier.
    pub fn lighter(&self) -> f64 {
        self.lighter
    }

    /// Difference of stated and true mass, as a share, without allowance for tolerances.
    pub fn off(&self) -> f64 {
        let by = if self.lighter() > 0.0 {
            &self.driven
        } else {
            &self.inertia
        };
        (1.0 - by.gain()).abs()
    }

    /// Unreported load by force and acceleration, as a share of the loaded machine.
    pub fn carried(&self) -> f64 {
        (1.0 - self.inertia.gain()).max(0.0)
    }

    /// An unreported load has come or gone with this row.
    pub fn load_stepped(&self) -> bool {
        self.inertia.stepped()
    }

    /// Root-mean-square difference of the load from the one under which the ratio was estimated, as a share of the machine.
    pub fn other_load(&self) -> f64 {
        self.unreported_load.share()
    }

    /// Time since an unreported load has come or gone [s].
    pub fn since_load(&self) -> f64 {
        self.inertia.since_step()
    }
}
