//! The tunings that the methods have when nothing else is asked for.

use super::tuning::{
    Clamps, Digging, Gates, Inflation, Integration, LoadTransfer, ProcessNoise, Reset, Tuning,
};
use crate::loader::Method;

impl Tuning {
    /// The tuning that a method has when nothing else is asked for.
    pub const fn of(method: Method) -> Self {
        match method {
            Method::Full => Self::recommended(),
            _ => Self::paper(),
        }
    }

    /// The protected filter on a real machine.
    pub const fn recommended() -> Self {
        Self {
            noise: ProcessNoise {
                speed: 5e-4,
                wheel_speed: 1e-3,
                slip_stiffness: 3e-4,
                cg_height: 3e-5,
                cg_ratio: 3e-5,
                spade_force_x: 150.0,
                radius: 1e-7,
                slope_bias: 1e-5,
            },
            minimum_speed: 0.3,
            midpoint_inputs: true,
            real_tyre: true,
            integration: Integration::Implicit,
            substeps: 1,
            spread: 1.0,
            beta: 2.0,
            kappa: 0.0,
            load_transfer: LoadTransfer::Physical,
            linearised: false,
            inflation: Inflation {
                load_ripple: 0.1,
                radius_ripple: 0.1,
                torque_lag: 0.5,
                frozen_wheel_speed_std: 0.3,
            },
            freeze_speed: 0.5,
            gates: Some(Gates {
                soft: 5.0,
                hard: 20.0,
            }),
            clamps: Some(Clamps::WIDE),
            digging: Some(Digging {
                force: 2500.0,
                hold: 0.5,
                reopen: 2.0,
                boom_gain: 40.0,
            }),
            gap: 0.25,
            reset: Some(Reset {
                level: 6.0,
                time_constant: 2.0,
                hold_off: 3.0,
            }),
        }
    }

    /// The paper's six states: no protection, linear tyre, held inputs, alpha 0.01.
    pub const fn paper() -> Self {
        Self {
            noise: ProcessNoise {
                speed: 5e-3,
                wheel_speed: 1e-2,
                slip_stiffness: 1e-3,
                cg_height: 1e-4,
                cg_ratio: 1e-4,
                ..Self::recommended().noise
            },
            midpoint_inputs: false,
            real_tyre: false,
            spread: 0.01,
            inflation: Inflation {
                load_ripple: 0.0,
                radius_ripple: 0.0,
                torque_lag: 0.0,
                frozen_wheel_speed_std: 0.0,
            },
            freeze_speed: 0.0,
            gates: None,
            clamps: None,
            digging: None,
            gap: f64::INFINITY,
            reset: None,
            ..Self::recommended()
        }
    }

    /// The six states tuned: small process noise, real tyre, mid-point inputs, clamps; no gates and no resets.
    pub const fn tuned() -> Self {
        Self {
            spread: 0.01,
            inflation: Inflation {
                load_ripple: 0.1,
                radius_ripple: 0.0,
                torque_lag: 0.5,
                frozen_wheel_speed_std: 0.3,
            },
            gates: None,
            digging: None,
            gap: f64::INFINITY,
            reset: None,
            ..Self::recommended()
        }
    }
}
