//! Wind-up of the tyres: a wheel whose torque grows turns faster than in steady state.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | L | `relaxation_length` | relaxation length of the tyres | m |
//! | sigma_i | - | slip of the axle in steady state, T_i/(r K F_zi) | 1 |
//! | F_zi | `load` | static axle load, lam m g in front and (1 - lam) m g behind | N |
//!
//! The slip s of a tyre with relaxation follows L s' = (r w - v) - |v| s, and force and torque are proportional to s. Hence
//! r w - v = |v| sigma + L sigma'. The process model has the first term, this file the second:
//! ```text
//! dw_i = L (dT_i/dt)/(r^2 K F_zi)
//! ```
//! It is some mrad/s, at every change of torque, and these changes determine the height. Without this term the height is 5 % too
//! high.

use crate::loader::physics::wheel_dynamics::{Inputs, WheelDynamics};

/// Least time over which torques are differentiated [s]: at higher rates their noise would grow.
const LEAST_TIME: f64 = 0.01;

/// Least share of the weight on an axle.
pub const LEAST_SHARE: f64 = 0.1;

/// Last torques and their rates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Windup {
    last: Option<[f64; 2]>,
    /// Rates of the torques [N m/s].
    rate: [f64; 2],
}

impl Windup {
    /// Excess of front and rear wheel speed over steady state [rad/s].
    ///
    /// `relaxation_length` [m]; `stiffness` and `ratio` are the predicted K and lam.
    pub fn wheel_speeds(
        &mut self,
        relaxation_length: f64,
        machine: &WheelDynamics,
        inputs: &Inputs,
        dt: f64,
        [stiffness, ratio]: [f64; 2],
    ) -> [f64; 2] {
        let torque = [inputs.front_torque, inputs.rear_torque];
        let last = self.last.replace(torque).unwrap_or(torque);
        let weight = (dt / LEAST_TIME).min(1.0);
        let radius = machine.wheel_radius;
        core::array::from_fn(|i| {
            let rate = (torque[i] - last[i]) / dt;
            self.rate[i] += weight * (rate - self.rate[i]);
            let share = [ratio, 1.0 - ratio][i].max(LEAST_SHARE);
            let load = share * machine.mass * machine.gravity;
            relaxation_length * self.rate[i] / (radius * radius * stiffness * load)
        })
    }
}
