//! Whether the machine is as heavy as stated: force over acceleration by all rows, and by those in which the torques drive; and what
//! that says of a load that nobody reports.
//!
//! Brakes that nobody tells make a machine look lighter while it brakes, and leave it as it is while it drives.

use super::axle_torque::AxleTorque;
use super::inertia::{Inertia, Push};
use super::unreported_load::{BETWEEN, BETWEEN_STATED, SLOW, UnreportedLoad};

/// A reported mass that changes by this share is weighed.
const WEIGHS: f64 = 0.01;

/// What is known of the mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StatedMass {
    /// Mass of the first row [kg], and whether a reported one has changed since: then it is weighed, and not only stated.
    first: f64,
    is_weighed: bool,
    /// By all rows, and by those in which the torques drive.
    inertia: Inertia,
    driven: Inertia,
    pub axle_torque: AxleTorque,
    unreported_load: UnreportedLoad,
}

/// What holds in a row.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// The mass with its load is stated.
    pub states_mass: bool,
    /// The torques alone move the machine.
    pub tells: bool,
    /// They drive it.
    pub drives: bool,
    /// Slower than this, stiction and the ground act.
    pub stands: bool,
    /// Something pushes that the torques do not explain.
    pub pushes: bool,
}

impl StatedMass {
    /// Takes a row with the mass that is taken for true [kg].
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
        if drives {
            self.axle_torque.see(self.driven.signals(), dt);
        }
        let lighter = self.driven.excess() > 0.0;
        self.inertia.see(row, kind.tells, lighter, dt);
        if self.inertia.stepped() {
            self.axle_torque.load_stepped();
        }
        if self.is_weighed || self.inertia.stepped() {
            self.unreported_load.settle();
        } else {
            self.expect_load(row, kind, dt);
        }
    }

    /// A load that nobody reports may come or go while the machine is idle.
    fn expect_load(&mut self, row: &Push, kind: &Kind, dt: f64) {
        // Who has carried a load that nobody reported may do so whenever it is slow.
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

    /// By how much the machine is lighter (or its torques larger) than stated, beyond tolerances and chance; negative where it is
    /// heavier.
    pub fn lighter(&self) -> f64 {
        let all = self.inertia.excess();
        all.min(self.driven.excess().max(0.0))
    }

    /// By how much stated and true mass differ, as a share, whatever tolerances explain.
    pub fn off(&self) -> f64 {
        let by = if self.lighter() > 0.0 {
            &self.driven
        } else {
            &self.inertia
        };
        (1.0 - by.gain()).abs()
    }

    /// What force and acceleration show of a load that nobody reported, as a share of the machine with it.
    pub fn carried(&self) -> f64 {
        (1.0 - self.inertia.gain()).max(0.0)
    }

    /// A load came or went with this row, and nobody reported it.
    pub fn load_stepped(&self) -> bool {
        self.inertia.stepped()
    }

    /// By how much the load is another one than that under which the ratio was learnt, as a share of the machine,
    /// as far as that is probable.
    pub fn other_load(&self) -> f64 {
        self.unreported_load.share()
    }

    /// Time since a load came or went that nobody reported [s].
    pub fn since_load(&self) -> f64 {
        self.inertia.since_step()
    }
}
