//! Longitudinal motion of a loader with driven axles, slip and load transfer: the process model of the estimator.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | v, w_f, w_r | `Motion` | body speed, wheel speeds | m/s, rad/s |
//! | K, h, lam | `Parameters` | slip stiffness, height and ratio of the centre of gravity | -, m, - |
//! | d_f, d_r | `front_radius_error`, .. | relative rolling-radius errors | - |
//! | T_f, T_r | `front_torque`, .. | axle torques at the wheel | N m |
//! | F_x, F_z | `spade_force_x`, .. | forces on the bucket tip, backward and down positive | N |
//! | th | `slope` | road slope, uphill positive | rad |
//! | r, I, rho, mu | `wheel_radius`, .. | rolling radius, axle inertia, load sensitivity, friction limit | m, kg m^2, - |
//! | sigma_i | - | slip (r w_i - v)/max(\|r w_i\|, \|v\|, v_min), not defined in the paper | - |
//!
//! Source: Yang, Wang, Han 2021, (1)-(18). Rolling resistance is a force on the body, f tanh(v/0.05) times the load, so that
//! it vanishes at standstill; (4), (5) have no sign.
//!
//! | file | idea |
//! |---|---|
//! | `implicit` | the linearly implicit step, which the estimator takes |

pub use super::machine::{Road, Tyres, WheelDynamics};
use crate::loader::layout::{
    CG_HEIGHT, CG_RATIO, FRONT_WHEEL, Layout, REAR_WHEEL, SLIP_STIFFNESS, SPEED,
};
use crate::math::tanh;
use crate::scalar::Scalar;

mod implicit;

/// Width of the rolling resistance at standstill [m/s].
pub(in crate::loader) const ROLLING_WIDTH: f64 = 0.05;

/// Limit of the use of friction, at which the saturation of a tyre stops: at 1 the slip would be infinite.
pub(super) const MOST_USED: f64 = 0.995;

/// Inputs of the machine during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Front axle torque [N m].
    pub front_torque: f64,
    /// Rear axle torque [N m].
    pub rear_torque: f64,
    /// Measured force on the bucket tip, backward positive \[N\].
    pub spade_force_x: f64,
    /// Measured force on the bucket tip, down positive \[N\].
    pub spade_force_z: f64,
    /// Measured slope \[rad\].
    pub slope: f64,
}

impl Inputs {
    /// From these, in the order of the fields.
    pub fn of(
        [
            front_torque,
            rear_torque,
            spade_force_x,
            spade_force_z,
            slope,
        ]: [f64; 5],
    ) -> Self {
        Self {
            front_torque,
            rear_torque,
            spade_force_x,
            spade_force_z,
            slope,
        }
    }
}

/// Dynamic part of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<T> {
    /// Body speed [m/s].
    pub speed: T,
    /// Front wheel speed [rad/s].
    pub front_wheel_speed: T,
    /// Rear wheel speed [rad/s].
    pub rear_wheel_speed: T,
}

/// Part of the state that is constant during a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<T> {
    /// Slip stiffness.
    pub slip_stiffness: T,
    /// Height of the centre of gravity \[m\].
    pub cg_height: T,
    /// Share of the static weight in front.
    pub cg_ratio: T,
    /// Spade force beside the measured one \[N\].
    pub spade_force_x: T,
    /// Relative radius error in front.
    pub front_radius_error: T,
    /// Relative radius error behind.
    pub rear_radius_error: T,
    /// Slope bias, true slope = measured - bias \[rad\].
    pub slope_bias: T,
    /// Error of the load sensitivity of the rolling radii: true = stated + error.
    pub load_sensitivity_error: T,
}

impl<T: Scalar> Motion<T> {
    /// Motion at the head of a state vector.
    pub fn of<const N: usize>(x: &[T; N]) -> Self {
        Self {
            speed: x[SPEED],
            front_wheel_speed: x[FRONT_WHEEL],
            rear_wheel_speed: x[REAR_WHEEL],
        }
    }

    /// Writes it to the head of a state vector.
    pub(in crate::loader) fn put<const N: usize>(self, x: &mut [T; N]) {
        x[SPEED] = self.speed;
        x[FRONT_WHEEL] = self.front_wheel_speed;
        x[REAR_WHEEL] = self.rear_wheel_speed;
    }
}

impl<T: Scalar> Parameters<T> {
    /// Parameters of a state vector; those that it does not have are 0.
    pub fn of<const N: usize>(x: &[T; N]) -> Self {
        let zero = T::constant(0.0);
        let layout = const { Layout::of(N) };
        let at = |state: Option<usize>| state.map_or(zero, |i| x[i]);
        let [front, rear] = layout.radii.map_or([zero; 2], |radii| radii.map(|i| x[i]));
        Self {
            slip_stiffness: x[SLIP_STIFFNESS],
            cg_height: x[CG_HEIGHT],
            cg_ratio: x[CG_RATIO],
            spade_force_x: at(layout.spade_force),
            front_radius_error: front,
            rear_radius_error: rear,
            slope_bias: at(layout.slope_bias),
            load_sensitivity_error: at(layout.load_sensitivity),
        }
    }
}

impl WheelDynamics {
    /// Acceleration of the torques without slip, from which the loads start [m/s^2].
    #[inline(always)]
    pub(super) fn rigid_acceleration<T: Scalar>(
        &self,
        radius_front: T,
        radius_rear: T,
        u: &Inputs,
        drag: T,
    ) -> T {
        let force = T::constant(u.front_torque) / radius_front
            + T::constant(u.rear_torque) / radius_rear
            - drag;
        let spin = |radius: T| T::constant(self.axle_inertia) / (radius * radius);
        force / (spin(radius_front) + spin(radius_rear) + self.mass)
    }

    /// Mass with the inertia of the axles, as at their rims [kg].
    pub(in crate::loader) fn rolling_mass(&self) -> f64 {
        self.mass + 2.0 * self.axle_inertia / (self.wheel_radius * self.wheel_radius)
    }

    /// Acceleration of the torques without slip on this slope, at nominal radii [m/s^2].
    pub(in crate::loader) fn free_acceleration(&self, u: &Inputs, speed: f64, sine: f64) -> f64 {
        let pull = (u.front_torque + u.rear_torque) / self.wheel_radius;
        let weight = self.mass * self.gravity;
        let rolling = self.rolling_resistance * tanh(speed / ROLLING_WIDTH) * weight;
        (pull - rolling - weight * sine - u.spade_force_x) / self.rolling_mass()
    }

    /// Rolling resistance and slope: forces against forward motion that do not depend on slip [N].
    #[inline(always)]
    fn drag<T: Scalar>(&self, speed: T, u: &Inputs, road: &Road<T>) -> T {
        self.faded_drag((speed / ROLLING_WIDTH).tanh(), u, road)
    }

    /// The same with the rolling resistance at this share of its full size.
    #[inline(always)]
    pub(super) fn faded_drag<T: Scalar>(&self, fade: T, u: &Inputs, road: &Road<T>) -> T {
        let load = road.cosine * (self.mass * self.gravity) + u.spade_force_z;
        fade * load * self.rolling_resistance + road.sine * (self.mass * self.gravity)
    }

    /// Rolling radius under load [m], from its own error and that of the load sensitivity.
    #[inline(always)]
    pub(super) fn radius<T: Scalar>(&self, error: T, sensitivity_error: T, load: T) -> T {
        let sensitivity = sensitivity_error + self.radius_load_sensitivity;
        (error - self.excess(load) * sensitivity + 1.0) * self.wheel_radius
    }

    /// An axle's load over half the weight of the empty machine, less one.
    #[inline(always)]
    pub(super) fn excess<T: Scalar>(&self, load: T) -> T {
        load / (0.5 * self.empty_mass * self.gravity) - 1.0
    }

    /// Slip stiffness of an axle with this gain under its load, before it saturates.
    #[inline(always)]
    pub(super) fn axle_stiffness<T: Scalar>(&self, gain: T, stiffness: T, load: T) -> T {
        let stiffness = stiffness * gain;
        if self.tyres.load_exponent == 0.0 {
            return stiffness;
        }
        let relative = load / (0.5 * self.empty_mass * self.gravity);
        stiffness * (relative.ln() * -self.tyres.load_exponent).exp()
    }

    /// Secant slip stiffness of a tyre that saturates like mu tanh(K sigma/mu).
    #[inline(always)]
    pub(super) fn stiffness<T: Scalar>(
        &self,
        slip_stiffness: T,
        torque: T,
        radius: T,
        load: T,
        acceleration: T,
    ) -> T {
        if self.friction.is_infinite() {
            return slip_stiffness;
        }
        let demand = (-(acceleration * self.axle_inertia / radius) + torque).abs()
            / (radius * load * self.friction);
        let use_of_friction = demand.min(T::constant(MOST_USED));
        slip_stiffness * use_of_friction.per_atanh()
    }

    /// max(|v|, |r w|, v_min).
    #[inline(always)]
    pub(super) fn slip_denominator<T: Scalar>(&self, speed: T, rim_speed: T) -> T {
        speed
            .abs()
            .max(rim_speed.abs())
            .max(T::constant(self.minimum_speed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loader::Settings;

    #[test]
    fn a_tyre_gives_with_its_load_whatever_the_machine_weighs_with_its_own() {
        let mut settings = Settings::DEFAULT;
        settings.machine.stiffness_load_exponent = 0.2;
        let empty = WheelDynamics::of(&settings);
        let mut loaded = empty;
        loaded.mass *= 1.3;
        let of = |m: &WheelDynamics, load| {
            [
                m.radius(0.0, 0.001, load),
                m.axle_stiffness(m.tyres.gains[0], 19.0, load),
            ]
        };
        for load in [15_000.0, 40_000.0] {
            assert_eq!(of(&empty, load), of(&loaded, load));
        }
        let softer = of(&empty, 15_000.0)[0] - of(&empty, 40_000.0)[0];
        let rho = 0.001 + empty.radius_load_sensitivity;
        let expected = empty.wheel_radius * rho * 50_000.0 / (empty.mass * empty.gravity);
        assert!((softer - expected).abs() < 1e-12);
    }
}
