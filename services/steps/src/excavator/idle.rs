//! Keys without effect under a method.

use config::Excavator;
use estimation::excavator::Method;

use crate::idle::Change;

/// Whether a changed key has no effect under any of `methods`.
pub(crate) fn is_idle(_: &Excavator, change: &Change, methods: &[&str]) -> bool {
    !methods.iter().any(|m| acts(change.path, m))
}

/// Whether a key may act under a method.
fn acts(path: &str, method: &str) -> bool {
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
