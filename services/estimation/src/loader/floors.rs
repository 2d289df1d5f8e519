//! Floors of the reported intervals: errors that cannot be identified on line.
//!
//! Load sensitivity of the radius, torque ratio, and errors of the model are added to the variance in the report only, never in the
//! filter:
//! ```text
//! sd_lam,rep^2 = sd_lam^2 + lam^2 [(16 sigma_rho)^2 + ((1 - lam) sigma_Tratio)^2 + ((1 - lam) sigma_Kratio)^2 + 0.011^2] + (h sigma_z/(g l))^2
//! sd_h,rep^2   = sd_h^2 + (0.04 m)^2 + (h sigma_p)^2 + (13 h sigma_rho)^2
//! ```
//! z: the zero of the accelerometer, whose error looks like a load that is always shifted. p: the slip stiffness falls with the
//! load as F_z^-p. For the ratio this is a difference of the axles' stiffnesses, which sigma_Kratio already includes.
//!
//! The methods of the paper take the rolling radii as exact. On a real machine this error exceeds all others, and their own
//! interval does not include it. So it is added as well: their interval then covers it, and they are never trusted.

use super::layout::Each;
use super::settings::Settings;
use crate::GRAVITY;
use crate::math::norm;

/// Relative error of the ratio per load sensitivity, on the reference machine: 8 K h/(l lam [1/lam^2 + 1/(1 - lam)^2]).
///
/// An acceleration a moves the load m h a/l. The slips then differ by (a/(2 g K)) [1/lam^2 + 1/(1 - lam)^2] for a unit of the
/// share. The radii differ by 4 h a/(g l) for a unit of their sensitivity. Both are proportional to a, so one looks like the other.
/// K and h of the machine in place of the reference's gave no improvement: they are estimates too.
pub(super) const RATIO_PER_SENSITIVITY: f64 = 16.0;
/// Relative error of the height per load sensitivity, as measured on six machines of 5 to 20 t: 12 to 14.
const HEIGHT_PER_SENSITIVITY: f64 = 13.0;
/// Relative error of the ratio per relative error of a rolling radius that is taken as exact: 17 % for 0.1 %.
const RATIO_PER_RADIUS: f64 = 170.0;
/// Error of the height per the same: 0.1 % drives it to its bound [m].
const HEIGHT_PER_RADIUS: f64 = 600.0;
/// Standard deviation of the relative rolling radii, where the filter does not estimate them.
const RADIUS_STD: f64 = 0.003;

/// Parameters that a filter estimates, so that its covariance includes them and no floor has to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Learns {
    /// The rolling radii.
    pub radii: bool,
    /// Remaining standard deviation of their load sensitivity.
    pub load_sensitivity: f64,
    /// Acceleration that moves load between the axles, by an accelerometer.
    pub acceleration: bool,
}

/// Standard deviations, floors included.
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

/// Standard deviation of the ratio, floors included.
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

/// Standard deviation of the relative rolling radii where the filter takes them as exact, otherwise 0.
fn radius_std(learns: &Learns) -> f64 {
    if learns.radii { 0.0 } else { RADIUS_STD }
}
