//! From the description of an excavator to the settings of its estimators.

use super::geometry::Geometry;
use super::keys::{Description, Paper};
use super::settings::{Sensors, Settings};

impl Settings {
    /// The settings that a description means.
    #[must_use]
    pub fn of(d: &Description) -> Self {
        Self {
            geometry: Geometry::of(d),
            nominal_damping: d.machine.nominal_damping,
            coulomb_friction: d.machine.coulomb_friction,
            inertia_min: d.machine.inertia_min,
            inertia_max: d.machine.inertia_max,
            sensors: sensors(d),
            prior: d.prior,
            estimator: d.estimator,
            paper: paper(d),
        }
    }
}

impl Geometry {
    /// The geometry that a description means.
    #[must_use]
    pub fn of(d: &Description) -> Self {
        let g = &d.geometry;
        Self {
            upper_inertia: d.machine.upper_inertia,
            boom_pin: g.boom_pin,
            lengths: [g.boom_length, g.arm_length],
            centres: [g.boom_centre, g.arm_centre, g.bucket_centre],
            payload_centre: g.payload_centre,
            payload_gyration: g.payload_gyration,
            masses: [g.boom_mass, g.arm_mass, g.bucket_mass],
            inertias: [g.boom_inertia, g.arm_inertia, g.bucket_inertia],
            axial_inertias: [
                g.boom_axial_inertia,
                g.arm_axial_inertia,
                g.bucket_axial_inertia,
            ],
        }
    }
}

fn sensors(d: &Description) -> Sensors {
    let s = &d.sensors;
    Sensors {
        rate: s.rate,
        swing_velocity_std: s.swing_velocity_std,
        swing_angle_std: s.swing_angle_std,
        swing_torque_std: s.swing_torque_std,
        swing_torque_gain_std: s.swing_torque_gain_std,
        swing_velocity_limit: s.swing_velocity_limit,
        angle_limit: s.angle_limit,
        swing_torque_gain: s.swing_torque_gain,
        swing_torque_offset: s.swing_torque_offset,
    }
}

/// A list under estimator.forgetting holds inside and outside the windows alike.
fn paper(d: &Description) -> Paper {
    let common = match *d.estimator.forgetting {
        [all] => Some([all; 3]),
        [inertia, damping, torque, ..] => Some([inertia, damping, torque]),
        _ => None,
    };
    Paper {
        lambda_normal: common.unwrap_or(d.paper.lambda_normal),
        lambda_window: common.unwrap_or(d.paper.lambda_window),
        ..d.paper
    }
}
