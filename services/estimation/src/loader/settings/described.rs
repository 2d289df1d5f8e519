//! From the description of a loader to the settings of its estimator.

use super::{
    Clamps, Digging, Gates, Inflation, Machine, Prior, ProcessNoise, Relearning, Reset, Sensors,
    Settings, Tuning, Verdict,
};
use crate::loader::Method;
use crate::loader::keys::{self, Description, Estimator as Keys, Inputs};

impl Settings {
    /// What a method is told under a description.
    #[must_use]
    pub fn of(description: &Description, method: Method) -> Self {
        Self {
            machine: machine(description),
            sensors: sensors(description),
            prior: prior(description),
            verdict: verdict(&description.estimator),
            tuning: Some(tuning(&description.estimator, method)),
        }
    }
}

fn machine(description: &Description) -> Machine {
    let m = &description.machine;
    Machine {
        mass: m.mass,
        wheel_radius: m.wheel_radius,
        axle_inertia: m.axle_inertia,
        wheelbase: m.wheelbase,
        bucket_reach: m.bucket_reach,
        rolling_resistance: m.rolling_resistance,
        gear_ratio: m.gear_ratio,
        friction: if m.friction > 0.0 {
            m.friction
        } else {
            f64::INFINITY
        },
        radius_load_sensitivity: m.radius_load_sensitivity,
        radius_load_sensitivity_std: m.radius_load_sensitivity_std,
        stiffness_ratio: m.stiffness_ratio,
        stiffness_ratio_std: m.stiffness_ratio_std,
        stiffness_load_exponent: m.stiffness_load_exponent,
        stiffness_load_exponent_std: m.stiffness_load_exponent_std,
        relaxation_length: m.relaxation_length,
    }
}

fn sensors(description: &Description) -> Sensors {
    let s = &description.sensors;
    Sensors {
        speed_std: s.speed_std,
        wheel_speed_std: s.wheel_speed_std,
        slope_std: s.slope_std,
        acceleration_std: s.acceleration_std,
        torque_gains: [s.front_torque_gain, s.rear_torque_gain],
        torque_gain_std: s.torque_gain_std,
        speed_delay: s.speed_delay,
        speed_delay_std: s.speed_delay_std,
    }
}

fn prior(description: &Description) -> Prior {
    let p = &description.prior;
    Prior {
        slip_stiffness: p.slip_stiffness,
        slip_stiffness_std: p.slip_stiffness_std,
        cg_height: p.cg_height,
        cg_height_std: p.cg_height_std,
        cg_ratio: p.cg_ratio,
        cg_ratio_std: p.cg_ratio_std,
        speed_std: p.speed_std,
        wheel_speed_std: p.wheel_speed_std,
        radius_errors: [p.front_radius_error, p.rear_radius_error],
        radius_std: p.radius_std,
        spade_force_x_std: p.spade_force_std,
        slope_bias: p.slope_bias,
        slope_bias_std: p.slope_bias_std,
    }
}

fn verdict(keys: &Keys) -> Verdict {
    Verdict {
        cg_height_floor: keys.cg_height_floor,
        cg_ratio_floor: keys.cg_ratio_floor,
        load_sensitivity_floor: keys.load_sensitivity_floor,
        excited_torque: keys.excited_torque,
        excited_acceleration: keys.excited_acceleration,
        fresh: keys.fresh,
        consistent_nis: keys.consistent_nis,
        converged_ratio: keys.converged_ratio,
        converged_height: keys.converged_height,
    }
}

/// `full` and `full-ekf` take every key. The methods with six states are the paper's, exactly, or take the keys that `tuned` knows.
fn tuning(keys: &Keys, method: Method) -> Tuning {
    let base = match (method, keys.tuning) {
        (Method::Full | Method::FullEkf, _) => protected(keys, Tuning::product()),
        (_, keys::Tuning::Paper) => Tuning::paper(),
        (_, keys::Tuning::Tuned) => tuned(keys),
    };
    let midpoint_inputs = match keys.inputs {
        Inputs::Auto => base.midpoint_inputs,
        Inputs::Midpoint => true,
        Inputs::Hold => false,
    };
    let substeps = u32::try_from(keys.substeps).unwrap_or(u32::MAX);
    Tuning {
        midpoint_inputs,
        load_transfer: keys.load_transfer,
        substeps,
        minimum_speed: keys.v_min,
        ..base
    }
}

fn protected(keys: &Keys, base: Tuning) -> Tuning {
    let reset = base.reset.map(|reset| Reset {
        level: keys.reset_nis,
        ..reset
    });
    Tuning {
        inflation: Inflation {
            radius_ripple: keys.c_rho,
            ..inflation(keys, base)
        },
        gates: Some(Gates {
            soft: keys.gate,
            hard: keys.reject,
        }),
        digging: Some(Digging {
            force: keys.dig_force,
            hold: keys.dig_hold,
            reopen: keys.reopen,
            boom_gain: keys.boom_gain,
        }),
        gap: keys.gap,
        reset,
        relearning: base.relearning.map(|rule| Relearning {
            gain: keys.relearn,
            ..rule
        }),
        ..common(keys, base)
    }
}

fn tuned(keys: &Keys) -> Tuning {
    let base = Tuning::tuned();
    Tuning {
        inflation: inflation(keys, base),
        ..common(keys, base)
    }
}

fn inflation(keys: &Keys, base: Tuning) -> Inflation {
    Inflation {
        load_ripple: keys.c_b,
        torque_lag: keys.c_t,
        ..base.inflation
    }
}

/// What every tuning but the paper's takes from the keys.
fn common(keys: &Keys, base: Tuning) -> Tuning {
    Tuning {
        noise: ProcessNoise {
            speed: keys.q_speed,
            wheel_speed: keys.q_wheel_speed,
            slip_stiffness: keys.q_slip_stiffness,
            cg_height: keys.q_cg_height,
            cg_ratio: keys.q_cg_ratio,
            spade_force_x: keys.q_spade_force,
            radius: keys.q_radius,
            slope_bias: keys.q_slope_bias,
            speed_delay: keys.q_speed_delay,
        },
        spread: keys.alpha,
        beta: keys.beta,
        kappa: keys.kappa,
        freeze_speed: keys.v_freeze,
        clamps: Some(Clamps {
            slip_stiffness: (keys.slip_stiffness_min, keys.slip_stiffness_max),
            cg_height: (keys.cg_height_min, keys.cg_height_max),
            cg_ratio: (keys.cg_ratio_min, keys.cg_ratio_max),
        }),
        ..base
    }
}
