//! Which measurements are used, and how much.

use crate::loader::settings::Gates;
use crate::math::sqrt;

/// Whether a measurement is used, and whether it was de-weighted; `std` grows in that case.
pub(super) fn gate(
    gates: Option<Gates>,
    innovation: f64,
    std: &mut f64,
    predicted_std: impl Fn() -> f64,
) -> (bool, bool) {
    if !innovation.is_finite() {
        return (false, false);
    }
    let Some(gates) = gates else {
        return (true, false);
    };
    let predicted = predicted_std();
    let normalised = innovation.abs() / sqrt(*std * *std + predicted * predicted);
    if normalised >= gates.hard || normalised.is_nan() {
        return (false, false);
    }
    let soft = normalised > gates.soft;
    if soft {
        *std += innovation.abs() / gates.soft;
    }
    (true, soft)
}
