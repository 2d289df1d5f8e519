//! From the description of an excavator to the settings of its estimators.

use config::{Excavator as Description, Variant as Described};
use estimation::excavator::{Estimator, Geometry, Paper, Prior, Sensors, Settings, Variant};

/// The settings that a description means.
#[must_use]
pub fn settings(d: &Description) -> Settings {
    Settings {
        geometry: geometry(d),
        nominal_damping: d.machine.nominal_damping,
        coulomb_friction: d.machine.coulomb_friction,
        inertia_min: d.machine.inertia_min,
        inertia_max: d.machine.inertia_max,
        sensors: sensors(d),
        prior: prior(d),
        estimator: estimator(d),
        paper: paper(d),
    }
}

fn geometry(d: &Description) -> Geometry {
    let g = &d.geometry;
    Geometry {
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
    }
}

fn prior(d: &Description) -> Prior {
    let p = &d.prior;
    Prior {
        inertia: p.inertia,
        inertia_std: p.inertia_std,
        payload: p.payload,
        payload_std: p.payload_std,
        damping_std: p.damping_std,
        torque_offset_std: p.torque_offset_std,
        known_torque_offset_std: p.known_torque_offset_std,
        friction_std: p.friction_std,
    }
}

fn estimator(d: &Description) -> Estimator {
    let e = &d.estimator;
    Estimator {
        filter_frequency: e.filter_frequency,
        filter_damping: e.filter_damping,
        q_c: e.q_c,
        convergence_delay: e.convergence_delay,
        forgetting: e.forgetting.first().copied(),
        epsilon: e.epsilon,
        estimate_damping: e.estimate_damping,
        estimate_friction: e.estimate_friction,
        estimate_offset: e.estimate_offset,
        constant_inertia: e.constant_inertia,
        variant: match e.variant {
            Described::Auto => Variant::Auto,
            Described::Known => Variant::Known,
            Described::Tolerant => Variant::Tolerant,
            Described::Drop => Variant::Drop,
        },
        friction_width: e.friction_width,
        svf_friction_width: e.svf_friction_width,
        svf_acceleration_min: e.svf_acceleration_min,
        svf_covariance: e.svf_covariance,
        torque_noise_divisor: e.torque_noise_divisor,
        gate: e.gate,
        reject: e.reject,
        payload_min: e.payload_min,
        payload_max: e.payload_max,
        q_m: e.q_m,
        q_l: e.q_l,
        interval_factor: e.interval_factor,
        calibrate_at_rest: e.calibrate_at_rest,
        measure_noise_at_rest: e.measure_noise_at_rest,
        reopen_after: e.reopen_after,
        weak_onset: e.weak_onset,
        opening_rate: e.opening_rate,
        opening_decay: e.opening_decay,
        opening_change_max: e.opening_change_max,
        change_rate_std: e.change_rate_std,
        change_threshold: e.change_threshold,
        drop_q_m: e.drop_q_m,
        velocity_drift: e.velocity_drift,
        velocity_drift_constant: e.velocity_drift_constant,
        velocity_torque_drift: e.velocity_torque_drift,
        velocity_torque_drift_constant: e.velocity_torque_drift_constant,
        excited_velocity: e.excited_velocity,
        consistent_nis: e.consistent_nis,
        converged_share: e.converged_share,
        fresh_velocity: e.fresh_velocity,
        fresh_others: e.fresh_others,
    }
}

fn paper(d: &Description) -> Paper {
    let p = &d.paper;
    let mut change_times = [None; 8];
    for (slot, time) in change_times.iter_mut().zip(&p.change_times) {
        *slot = Some(*time);
    }
    // A list under estimator.forgetting holds inside and outside the windows alike.
    let common = match d.estimator.forgetting.as_slice() {
        [all] => Some([*all; 3]),
        [inertia, damping, torque, ..] => Some([*inertia, *damping, *torque]),
        _ => None,
    };
    Paper {
        change_times,
        lambda_normal: common.unwrap_or(p.lambda_normal),
        lambda_window: common.unwrap_or(p.lambda_window),
        covariance: p.covariance,
        torque: p.torque,
        nominal_rule: p.nominal_rule,
        start_time: p.start_time,
        stop_time: p.stop_time,
        // Where the user says when to begin, the regression runs from then on, as the paper's did.
        hold_at_standstill: p.start_time.is_none(),
    }
}
