//! The description of an excavator in the terms of the estimators.

use config::{Excavator as Description, Variant as Described};
use estimation::excavator::{Estimator, Geometry, Paper, Prior, Sensors, Settings, Variant};

/// The settings that a description makes.
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
        forgetting: e
            .forgetting
            .first()
            .map(|f| per_centisecond(*f, d.sensors.rate)),
        epsilon: e.epsilon,
        estimate_damping: e.estimate_damping,
        estimate_friction: e.estimate_friction,
        estimate_offset: e.estimate_offset,
        constant_inertia: e.constant_inertia,
        variant: variant(e.variant),
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

/// A description says forgetting per sample at its rate; the estimators count it per 0.01 s, so
/// that irregular samples forget by time.
fn per_centisecond(factor: f64, rate: f64) -> f64 {
    // At 100 Hz the factor is taken as it stands, to the last bit.
    if rate == 100.0 {
        factor
    } else {
        factor.powf(0.01 * rate)
    }
}

fn variant(variant: Described) -> Variant {
    match variant {
        Described::Auto => Variant::Auto,
        Described::Known => Variant::Known,
        Described::Tolerant => Variant::Tolerant,
        Described::Drop => Variant::Drop,
    }
}

/// A list of three factors under `estimator.forgetting` is the paper's, inside and outside the
/// windows; one factor is for all three.
fn paper(d: &Description) -> Paper {
    let p = &d.paper;
    let given = match d.estimator.forgetting.as_slice() {
        [all] => Some([*all; 3]),
        [inertia, damping, torque, ..] => Some([*inertia, *damping, *torque]),
        _ => None,
    };
    let mut change_times = [None; 8];
    for (slot, time) in change_times.iter_mut().zip(&p.change_times) {
        *slot = Some(*time);
    }
    Paper {
        change_times,
        lambda_normal: given.unwrap_or(p.lambda_normal),
        lambda_window: given.unwrap_or(p.lambda_window),
        covariance: p.covariance,
        torque: p.torque,
        nominal_rule: p.nominal_rule,
        start_time: p.start_time,
        stop_time: p.stop_time,
        // With its own times the paper regresses also where the machine stands.
        hold_at_standstill: p.start_time.is_none(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_description_is_the_default_of_the_estimators() {
        assert_eq!(settings(&Description::default()), Settings::default());
    }

    #[test]
    fn the_paper_preset_is_that_of_the_estimators() {
        assert_eq!(
            settings(&Description::paper_preset(5000.0)),
            Settings::paper(5000.0)
        );
    }

    #[test]
    fn forgetting_per_sample_becomes_forgetting_by_time() {
        let mut d = Description::default();
        d.estimator.forgetting = vec![0.999];
        d.sensors.rate = 1000.0;
        let per_centisecond = settings(&d).estimator.forgetting.unwrap();
        assert!((per_centisecond - 0.999f64.powi(10)).abs() < 1e-15);
    }
}
