//! Floors of the reported intervals: errors that cannot be learnt on line.
//!
//! Load sensitivity of the radius, torque ratio, and what the model leaves out are added to the variance in the report only, never
//! in the filter:
//! ```text
//! sd_lam,rep^2 = sd_lam^2 + lam^2 [(16 sigma_rho)^2 + ((1 - lam) sigma_Tratio)^2 + ((1 - lam) sigma_Kratio)^2 + 0.011^2] + (h sigma_z/(g l))^2
//! sd_h,rep^2   = sd_h^2 + (0.04 m)^2 + (h sigma_p)^2 + (13 h sigma_rho)^2
//! ```
//! z: the zero of the accelerometer, which is taken for a load that is always shifted. p: the slip stiffness falls with the
//! load as F_z^-p. Of the ratio that is a difference of the axles' stiffnesses, which sigma_Kratio holds already.
//!
//! The methods of the paper take the rolling radii as exact. On a real machine that error is larger than all others and
//! their own interval knows nothing of it, so it is added too: they are honest, and therefore never trusted.

use super::layout::Each;
use super::settings::Settings;
use crate::GRAVITY;
use crate::math::norm;

/// Relative error of the ratio per load sensitivity, on the reference machine: 8 K h/(l lam [1/lam^2 + 1/(1 - lam)^2]).
///
/// An acceleration a moves the load m h a/l. That makes the slips differ by (a/(2 g K)) [1/lam^2 + 1/(1 - lam)^2] for a unit of
/// the share, and the radii by 4 h a/(g l) for a unit of their sensitivity: both go with a, so one looks like the other.
/// With the K and h of the machine in place of the reference's it was no better: they are estimates too.
pub(super) const RATIO_PER_SENSITIVITY: f64 = 16.0;
/// Relative error of the height per load sensitivity, as measured on six machines of 5 to 20 t: 12 to 14.
const HEIGHT_PER_SENSITIVITY: f64 = 13.0;
/// Relative error of the ratio per relative error of a rolling radius that is taken as exact: 17 % for 0.1 %.
const RATIO_PER_RADIUS: f64 = 170.0;
/// Error of the height per the same: 0.1 % drives it to its bound [m].
const HEIGHT_PER_RADIUS: f64 = 600.0;
/// How well rolling radii are known beforehand, where the filter does not learn them.
const RADIUS_STD: f64 = 0.003;

/// What a filter estimates, so that its covariance holds it and no floor need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Learns {
    /// The rolling radii.
    pub radii: bool,
    /// What it leaves of the standard deviation of their load sensitivity.
    pub load_sensitivity: f64,
    /// What moves load between the axles, by an accelerometer.
    pub acceleration: bool,
}

/// Standard deviations with the floors.
pub(super) fn with_floors(
    settings: &Settings,
    learns: &Learns,
    centre: Each<f64>,
    std: Each<f64>,
) -> Each<f64> {
    let radius = radius_std(learns);
    let machine = &settings.machine;
    let by_height = if settings.real_tyre() {
        learns.load_sensitivity
    } else {
        0.0
    };
    let height = centre.height;
    Each {
        ratio: ratio_with_floors(settings, learns, centre, std.ratio),
        height: norm(&[
            std.height,
            settings.estimator.cg_height_floor,
            HEIGHT_PER_RADIUS * radius,
            height * machine.stiffness_load_exponent_std,
            height * HEIGHT_PER_SENSITIVITY * by_height,
        ]),
    }
}

/// The standard deviation of the ratio with the floors.
pub(super) fn ratio_with_floors(
    settings: &Settings,
    learns: &Learns,
    centre: Each<f64>,
    std: f64,
) -> f64 {
    let Each { ratio, height } = centre;
    let machine = &settings.machine;
    let left = learns.load_sensitivity;
    // A tyre modelled as rigid is wrong by the whole load sensitivity, not by its uncertainty.
    let sensitivity = if settings.real_tyre() {
        left
    } else {
        norm(&[left, machine.radius_load_sensitivity])
    };
    let torque_ratio = core::f64::consts::SQRT_2 * settings.sensors.torque_gain_std;
    let relative = norm(&[
        RATIO_PER_SENSITIVITY * sensitivity,
        (1.0 - ratio) * torque_ratio,
        (1.0 - ratio) * machine.stiffness_ratio_std,
        settings.estimator.cg_ratio_floor,
        RATIO_PER_RADIUS * radius_std(learns),
    ]);
    let shifted = if learns.acceleration {
        height * settings.sensors.acceleration_offset_std / (GRAVITY * machine.wheelbase)
    } else {
        0.0
    };
    norm(&[std, ratio * relative, shifted])
}

/// What is not known of the rolling radii where the filter takes them as exact.
fn radius_std(learns: &Learns) -> f64 {
    if learns.radii { 0.0 } else { RADIUS_STD }
}
