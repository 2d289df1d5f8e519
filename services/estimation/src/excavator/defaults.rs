//! The settings of the reference machine, a 5.5 t excavator.

use super::geometry::Geometry;
use super::settings::{Estimator, Paper, Prior, Sensors, Settings, Variant};

impl Default for Sensors {
    fn default() -> Self {
        Self {
            rate: 100.0,
            swing_velocity_std: 0.005,
            swing_angle_std: 0.0005,
            swing_torque_std: 100.0,
            swing_torque_gain_std: 0.0,
            swing_velocity_limit: 5.0,
            angle_limit: core::f64::consts::TAU,
            swing_torque_gain: 1.0,
            swing_torque_offset: 0.0,
        }
    }
}

impl Default for Prior {
    fn default() -> Self {
        Self {
            inertia: 6500.0,
            inertia_std: 1950.0,
            payload: 200.0,
            payload_std: 160.0,
            damping_std: 225.0,
            torque_offset_std: 60.0,
            known_torque_offset_std: 30.0,
            friction_std: 250.0,
        }
    }
}

impl Default for Paper {
    fn default() -> Self {
        Self {
            change_times: [None; 8],
            lambda_normal: [0.99, 0.69, 0.1],
            lambda_window: [0.99, 0.69, 0.1],
            covariance: [19.0, 6e6, 6e9],
            torque: 2548.0,
            nominal_rule: true,
            start_time: None,
            stop_time: None,
            hold_at_standstill: true,
        }
    }
}

impl Default for Estimator {
    fn default() -> Self {
        Self {
            filter_frequency: 11.7,
            filter_damping: 0.707,
            q_c: 4.7e-3,
            convergence_delay: None,
            forgetting: None,
            epsilon: 27.0,
            estimate_damping: false,
            estimate_friction: false,
            estimate_offset: false,
            constant_inertia: false,
            variant: Variant::Auto,
            friction_width: 0.008,
            svf_friction_width: 0.02,
            svf_acceleration_min: 0.05,
            svf_covariance: 100.0,
            torque_noise_divisor: 1.0,
            gate: 4.0,
            reject: 5.0,
            payload_min: -50.0,
            payload_max: 900.0,
            q_m: 1.0,
            q_l: 0.15 * 0.15,
            interval_factor: 0.6,
            calibrate_at_rest: true,
            measure_noise_at_rest: true,
            reopen_after: 0.5,
            weak_onset: true,
            opening_rate: 20.0 / 180.0 * core::f64::consts::PI,
            opening_decay: 1.4,
            opening_change_max: 300.0,
            change_rate_std: 600.0,
            change_threshold: 10.0,
            drop_q_m: 250.0 * 250.0,
            velocity_drift: 0.2,
            velocity_drift_constant: 0.005,
            velocity_torque_drift: 30.0,
            velocity_torque_drift_constant: 10.0,
            excited_velocity: 0.10,
            consistent_nis: 1.8,
            converged_share: 0.10,
            fresh_velocity: 0.10,
            fresh_others: 0.20,
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            geometry: Geometry::default(),
            nominal_damping: 1500.0,
            coulomb_friction: 250.0,
            inertia_min: 2500.0,
            inertia_max: 20_000.0,
            sensors: Sensors::default(),
            prior: Prior::default(),
            estimator: Estimator::default(),
            paper: Paper::default(),
        }
    }
}
