//! Plants of the nominal machine, at rest and with their swings.

use super::geometry::{Attachment, Geometry};
use super::path::Path;
use super::payload::Load;
use super::plant::{Dynamics, Machine, Plant};
use super::plateaus::{Plateaus, Targets};

/// Viscous damping b [N m s/rad].
const DAMPING: f64 = 1500.0;
/// Coulomb friction T_f [N m].
const FRICTION: f64 = 250.0;

/// The machine with its bucket.
fn machine() -> Machine {
    Machine {
        geometry: Geometry::with(Attachment::bucket()),
        damping: DAMPING,
        friction: FRICTION,
        dynamics: Dynamics::Momentum,
    }
}

/// A plant without swings.
pub(super) fn at_rest(path: Path, loads: Vec<Load>) -> Plant {
    Plant {
        machine: machine(),
        path,
        loads,
        swings: Vec::new(),
        period: f64::INFINITY,
    }
}

/// Adds the swing that meets the targets.
pub(super) fn swing(mut plant: Plant, targets: Targets) -> Plant {
    let swing = Plateaus::new(&plant, targets).solve();
    plant.swings.push(swing);
    plant
}

/// The swing of the working cycle.
pub(super) fn working_swing() -> Targets {
    Targets::working(5.5, 7.5, 9.3)
}
