//! What every loader estimator says, as a message.

use estimation::loader::Estimate;
use messages::{LoaderEstimate, loader_bits as bits};

use crate::bits::set_bits;
use crate::rows::flags_of_estimate;

/// The message of an estimate; what the method does not estimate stays 0 without its bit.
#[must_use]
pub fn message(e: &Estimate) -> LoaderEstimate {
    let force = e.spade_force_x.unwrap_or_default();
    LoaderEstimate {
        speed: e.speed,
        front_wheel_speed: e.front_wheel_speed,
        rear_wheel_speed: e.rear_wheel_speed,
        slip_stiffness: e.slip_stiffness.value,
        slip_stiffness_std: e.slip_stiffness.std,
        cg_height: e.cg_height.value,
        cg_height_std: e.cg_height.std,
        cg_ratio: e.cg_ratio.value,
        cg_ratio_std: e.cg_ratio.std,
        cg_distance: e.cg_distance,
        spade_force_x: force.value,
        spade_force_x_std: force.std,
        slope_bias: e.slope_bias.unwrap_or_default(),
        front_radius_scale: e.front_radius_scale.unwrap_or_default(),
        rear_radius_scale: e.rear_radius_scale.unwrap_or_default(),
        nis: e.nis,
        speed_delay: e.speed_delay.unwrap_or_default().value,
        speed_delay_std: e.speed_delay.unwrap_or_default().std,
        flags: flags(e),
        estimated: estimated(e),
        method: e.method as u32,
        resets: e.resets,
        refused: e.refused,
        reason: e.reason as u32,
        payload: e.payload.unwrap_or_default().value,
        payload_std: e.payload.unwrap_or_default().std,
        ..LoaderEstimate::default()
    }
}

sheet::loader_flags!(flags_of_estimate);

fn estimated(e: &Estimate) -> u32 {
    set_bits(&[
        (bits::STATE, e.started),
        (
            bits::ESTIMATED_SPADE_FORCE_X,
            e.started && e.spade_force_x.is_some(),
        ),
        (bits::SLOPE_BIAS, e.started && e.slope_bias.is_some()),
        (
            bits::RADIUS_SCALES,
            e.started && e.front_radius_scale.is_some(),
        ),
        (bits::SPEED_DELAY, e.started && e.speed_delay.is_some()),
        (bits::PAYLOAD, e.started && e.payload.is_some()),
    ])
}
