//! Keys without effect under a method.

use config::Excavator;
use estimation::excavator::Method;

use crate::idle::Change;

/// Whether a changed key has no effect under any of `methods`.
pub(crate) fn is_idle(_: &Excavator, change: &Change, methods: &[&str]) -> bool {
    !methods.iter().any(|m| acts(change.path, m))
}

/// Tables and keys that can be stated and that no estimator uses.
const READ_BY_NOTHING: &[&str] = &[
    // The boom's cylinder alone weighs the load.
    "machine.arm_cylinder.",
    // The rod side's force is at most a tenth of the head side's: an error of its area is negligible.
    "machine.boom_cylinder.rod_area_std",
    // White noise of a pressure is negligible beside the friction of the seals, and what the boom's oscillation adds is measured.
    "sensors.pressure_std",
];

/// Whether a key may act under a method.
fn acts(path: &str, method: &str) -> bool {
    if READ_BY_NOTHING.iter().any(|idle| path.starts_with(idle)) {
        return false;
    }
    let Ok(method) = super::method(method) else {
        return true;
    };
    let key = path.strip_prefix("estimator.").unwrap_or(path);
    if key.starts_with("paper.") || key == "epsilon" {
        method == Method::MultiForgettingRls
    } else if key.starts_with("svf_") || key.starts_with("estimate_") {
        method == Method::SvfRls
    } else if key.starts_with("filter_") || key == "forgetting" {
        method.is_regression()
    } else if key.starts_with("velocity_") {
        matches!(method, Method::Velocity | Method::Auto)
    } else {
        true
    }
}
