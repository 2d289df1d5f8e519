//! From the description of a loader to the settings of its estimator.

use super::{Estimator, Inputs, Realism, Settings};
use crate::loader::Method;
use crate::loader::keys::{Description, Tuning};

impl Settings {
    /// Settings of a method under a description: the keys that act; the others have the defaults of their filter.
    #[must_use]
    pub fn of(description: &Description, method: Method) -> Self {
        let keys = description.estimator;
        let (estimator, realism) = match (method.has_six_states(), keys.tuning) {
            (false, _) => (keys, Realism::AtWork),
            (true, Tuning::Paper) => (as_printed(keys), Realism::Paper),
            (true, Tuning::Tuned) => (unprotected(keys), Realism::Tyre),
        };
        let held = match keys.inputs {
            Inputs::Auto => realism == Realism::Paper,
            Inputs::Midpoint => false,
            Inputs::Hold => true,
        };
        Self {
            machine: description.machine,
            lift_arm: description.lift_arm,
            lift_cylinder: description.lift_cylinder,
            sensors: description.sensors,
            prior: description.prior,
            estimator: Estimator {
                inputs: if held { Inputs::Hold } else { Inputs::Midpoint },
                // It has determined the realism.
                tuning: Tuning::Paper,
                ..estimator
            },
            realism,
        }
    }
}

/// The paper's filter, exactly; what the paper leaves open has the stated values.
fn as_printed(keys: Estimator) -> Estimator {
    Estimator {
        load_transfer: keys.load_transfer,
        substeps: keys.substeps,
        v_min: keys.v_min,
        cg_height_floor: keys.cg_height_floor,
        cg_ratio_floor: keys.cg_ratio_floor,
        load_sensitivity_floor: keys.load_sensitivity_floor,
        excited_torque: keys.excited_torque,
        excited_acceleration: keys.excited_acceleration,
        fresh: keys.fresh,
        consistent_nis: keys.consistent_nis,
        converged_ratio: keys.converged_ratio,
        converged_height: keys.converged_height,
        ..Estimator::PAPER
    }
}

/// Six states, tuned: every key but those of the protections.
fn unprotected(keys: Estimator) -> Estimator {
    let without = Estimator::TUNED;
    Estimator {
        c_rho: without.c_rho,
        gate: without.gate,
        reject: without.reject,
        reset_nis: without.reset_nis,
        gap: without.gap,
        dig_force: without.dig_force,
        dig_hold: without.dig_hold,
        reopen: without.reopen,
        relearn: without.relearn,
        boom_gain: without.boom_gain,
        ..keys
    }
}
