//! Which measurements are used, and how much.

use crate::loader::settings::Settings;
use crate::math::sqrt;

/// Whether a measurement is used, and whether it was de-weighted; `std` grows in that case.
pub(super) fn gate(
    settings: &Settings,
    innovation: f64,
    std: &mut f64,
    predicted_std: impl Fn() -> f64,
) -> (bool, bool) {
    if !innovation.is_finite() {
        return (false, false);
    }
    if !settings.protected() {
        return (true, false);
    }
    let keys = &settings.estimator;
    let predicted = predicted_std();
    let normalised = innovation.abs() / sqrt(*std * *std + predicted * predicted);
    if normalised >= keys.reject || normalised.is_nan() {
        return (false, false);
    }
    let soft = normalised > keys.gate;
    if soft {
        *std += innovation.abs() / keys.gate;
    }
    (true, soft)
}
