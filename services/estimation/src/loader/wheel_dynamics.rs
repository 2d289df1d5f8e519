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
//! Two integrators. [`WheelDynamics::derivative`] with Euler steps is (12)-(14), (18): a wheel's eigenvalue is some
//! -1.5e4 1/s at 3 m/s, so 10 ms steps are unstable for a real machine (the paper's Table 1 gives 4.7 kg). The
//! *linearly implicit* step [`WheelDynamics::step`] is backward Euler with frozen loads and slip denominators, in closed form:
//! unconditionally stable, constant cost, any sign of v, standstill included.

use super::LoadTransfer;
use super::axle_loads::{axle_loads, unfloored_axle_loads};
use super::layout::{CG_HEIGHT, CG_RATIO, FRONT_WHEEL, Layout, REAR_WHEEL, SLIP_STIFFNESS, SPEED};
pub use super::machine::{GRAVITY, Road, Tyres, WheelDynamics};
use crate::math::tanh;
use crate::scalar::Scalar;

/// Width of the rolling resistance at standstill [m/s].
pub(super) const ROLLING_WIDTH: f64 = 0.05;

/// Use of the friction limit beyond which a tyre saturates no further: at 1 it would slip without end.
pub(super) const MOST_USED: f64 = 0.995;

/// Loads and friction are inserted into the step this often.
const PASSES: usize = 2;

/// What drives the machine during a step.
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

/// The part of the state that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<T> {
    /// Body speed [m/s].
    pub speed: T,
    /// Front wheel speed [rad/s].
    pub front_wheel_speed: T,
    /// Rear wheel speed [rad/s].
    pub rear_wheel_speed: T,
}

/// The part of the state that is constant during a step.
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
    /// The motion at the head of a state vector.
    pub fn of<const N: usize>(x: &[T; N]) -> Self {
        Self {
            speed: x[SPEED],
            front_wheel_speed: x[FRONT_WHEEL],
            rear_wheel_speed: x[REAR_WHEEL],
        }
    }

    /// Puts it at the head of a state vector.
    pub(super) fn put<const N: usize>(self, x: &mut [T; N]) {
        x[SPEED] = self.speed;
        x[FRONT_WHEEL] = self.front_wheel_speed;
        x[REAR_WHEEL] = self.rear_wheel_speed;
    }
}

impl<T: Scalar> Parameters<T> {
    /// The parameters of a state vector; what it does not have is 0.
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

/// One axle in a pass of the implicit step.
struct Axle<T> {
    /// 0 in front, 1 behind.
    axle: usize,
    torque: f64,
    /// Relative radius error.
    error: T,
    /// Error of the load sensitivity of the radius.
    sensitivity_error: T,
    load: T,
    stiffness: T,
    acceleration: T,
}

/// What one wheel contributes to the implicit step.
pub(super) struct Wheel<T> {
    /// r_i c_i: force per slip speed times radius.
    pull: T,
    /// N_i = 1 + dt r_i^2 c_i/I.
    pub(super) denominator: T,
    /// g_i = c_i/N_i.
    pub(super) grip: T,
    /// r_i w_i + dt r_i T_i/I: rim speed without the ground.
    free_rim_speed: T,
}

impl WheelDynamics {
    /// One linearly implicit step of `dt` seconds.
    #[inline]
    pub fn step<T: Scalar>(
        &self,
        old: &Motion<T>,
        p: &Parameters<T>,
        u: &Inputs,
        road: &Road<T>,
        dt: f64,
    ) -> Motion<T> {
        let drag = self.drag(old.speed, u, road) + p.spade_force_x + u.spade_force_x;
        let radius_front = (p.front_radius_error + 1.0) * self.wheel_radius;
        let radius_rear = (p.rear_radius_error + 1.0) * self.wheel_radius;
        let mut acceleration = self.rigid_acceleration(radius_front, radius_rear, u, drag);
        let mut new = *old;
        for _ in 0..PASSES {
            let (load_front, load_rear) = axle_loads(
                self,
                acceleration,
                p.cg_height,
                p.cg_ratio,
                u.spade_force_z,
                road,
            );
            let (w_front, w_rear) = (old.front_wheel_speed, old.rear_wheel_speed);
            let axle = |axle, torque, error, load| Axle {
                axle,
                torque,
                error,
                sensitivity_error: p.load_sensitivity_error,
                load,
                stiffness: p.slip_stiffness,
                acceleration,
            };
            let (error_front, error_rear) = (p.front_radius_error, p.rear_radius_error);
            let front = axle(0, u.front_torque, error_front, load_front);
            let front = self.grip(&front, w_front, [new.speed, new.front_wheel_speed], dt);
            let rear = axle(1, u.rear_torque, error_rear, load_rear);
            let rear = self.grip(&rear, w_rear, [new.speed, new.rear_wheel_speed], dt);
            let push = front.grip * front.free_rim_speed + rear.grip * rear.free_rim_speed - drag;
            let speed = (old.speed + push * (dt / self.mass))
                / ((front.grip + rear.grip) * (dt / self.mass) + 1.0);
            new = Motion {
                speed,
                front_wheel_speed: self.wheel_speed(&front, u.front_torque, w_front, speed, dt),
                rear_wheel_speed: self.wheel_speed(&rear, u.rear_torque, w_rear, speed, dt),
            };
            acceleration = (speed - old.speed) / dt;
        }
        new
    }

    /// What an axle contributes at the speeds of body and wheels of the pass before.
    #[inline(always)]
    fn grip<T: Scalar>(
        &self,
        axle: &Axle<T>,
        old_speed: T,
        [speed, wheel_speed]: [T; 2],
        dt: f64,
    ) -> Wheel<T> {
        let Axle { torque, load, .. } = *axle;
        let radius = self.radius(axle.error, axle.sensitivity_error, load);
        let unbent = self.axle_stiffness(axle.axle, axle.stiffness, load);
        let stiffness = self.stiffness(unbent, torque, radius, load, axle.acceleration);
        let slip_speed = self.slip_denominator(speed, radius * wheel_speed);
        self.wheel(stiffness * load / slip_speed, torque, radius, old_speed, dt)
    }

    /// `parts` linearly implicit steps of `dt / parts` with the same inputs.
    #[inline]
    pub fn substeps<T: Scalar>(
        &self,
        old: &Motion<T>,
        p: &Parameters<T>,
        u: &Inputs,
        road: &Road<T>,
        dt: f64,
        parts: u32,
    ) -> Motion<T> {
        let part = dt / f64::from(parts);
        (0..parts).fold(*old, |motion, _| self.step(&motion, p, u, road, part))
    }

    /// Acceleration that the torques would give without slip: the start of the loads [m/s^2].
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

    /// Mass with the inertia of the axles at their rims [kg].
    pub(super) fn rolling_mass(&self) -> f64 {
        self.mass + 2.0 * self.axle_inertia / (self.wheel_radius * self.wheel_radius)
    }

    /// Acceleration that the torques would give without slip on this slope, at nominal radii [m/s^2].
    pub(super) fn free_acceleration(&self, u: &Inputs, speed: f64, sine: f64) -> f64 {
        let pull = (u.front_torque + u.rear_torque) / self.wheel_radius;
        let weight = self.mass * GRAVITY;
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
        let load = road.cosine * (self.mass * GRAVITY) + u.spade_force_z;
        fade * load * self.rolling_resistance + road.sine * (self.mass * GRAVITY)
    }

    /// Rolling radius under load [m], from its own error and that of the load sensitivity.
    #[inline(always)]
    pub(super) fn radius<T: Scalar>(&self, error: T, sensitivity_error: T, load: T) -> T {
        let sensitivity = sensitivity_error + self.radius_load_sensitivity;
        (error - self.excess(load) * sensitivity + 1.0) * self.wheel_radius
    }

    /// An axle's load over half the weight, less one.
    #[inline(always)]
    pub(super) fn excess<T: Scalar>(&self, load: T) -> T {
        load / (0.5 * self.mass * GRAVITY) - 1.0
    }

    /// Slip stiffness of an axle under its load, before it saturates.
    #[inline(always)]
    pub(super) fn axle_stiffness<T: Scalar>(&self, axle: usize, stiffness: T, load: T) -> T {
        if self.tyres == Tyres::ALIKE {
            return stiffness;
        }
        let relative = load / (0.5 * self.mass * GRAVITY);
        let falls = (relative.ln() * -self.tyres.load_exponent).exp();
        stiffness * self.tyres.gains[axle] * falls
    }

    /// Secant slip stiffness of a tyre that saturates like mu tanh(K sigma/mu).
    #[inline(always)]
    pub(super) fn stiffness<T: Scalar>(
        &self,
        slip_stiffness: T,
        torque: f64,
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

    #[inline(always)]
    pub(super) fn wheel<T: Scalar>(
        &self,
        force_per_slip_speed: T,
        torque: f64,
        radius: T,
        old_speed: T,
        dt: f64,
    ) -> Wheel<T> {
        let pull = radius * force_per_slip_speed;
        let denominator = radius * pull * (dt / self.axle_inertia) + 1.0;
        Wheel {
            pull,
            denominator,
            grip: force_per_slip_speed / denominator,
            free_rim_speed: radius * (old_speed + dt * torque / self.axle_inertia),
        }
    }

    #[inline(always)]
    fn wheel_speed<T: Scalar>(
        &self,
        wheel: &Wheel<T>,
        torque: f64,
        old_speed: T,
        speed: T,
        dt: f64,
    ) -> T {
        (old_speed + (wheel.pull * speed + torque) * (dt / self.axle_inertia)) / wheel.denominator
    }

    /// Rates of the motion, (12)-(14), linear tyre, no floor under the loads.
    ///
    /// The denominator is 1 + D for the physical load transfer and 1 - D for the printed one, D = (h K/l)(sigma_f - sigma_r).
    pub fn derivative<T: Scalar>(
        &self,
        motion: &Motion<T>,
        p: &Parameters<T>,
        u: &Inputs,
        road: &Road<T>,
    ) -> Motion<T> {
        let slip = |wheel_speed: T| {
            let rim = wheel_speed * self.wheel_radius;
            (rim - motion.speed) / self.slip_denominator(motion.speed, rim)
        };
        let (front, rear) = (
            slip(motion.front_wheel_speed),
            slip(motion.rear_wheel_speed),
        );
        let stiffness = p.slip_stiffness;
        let transfer = p.cg_height * stiffness * (front - rear) / self.wheelbase;
        let rolling = (motion.speed / ROLLING_WIDTH).tanh() * self.rolling_resistance;
        let lever = self.bucket_reach / self.wheelbase;
        let pull =
            p.cg_ratio * stiffness * front + (-p.cg_ratio + 1.0) * stiffness * rear - rolling;
        let spade = (stiffness * (front * (1.0 + lever) - rear * lever) - rolling)
            * (u.spade_force_z / self.mass);
        let numerator = pull * road.cosine * GRAVITY - (transfer + 1.0) * road.sine * GRAVITY
            + spade
            - (p.spade_force_x + u.spade_force_x) / self.mass;
        let denominator = match self.load_transfer {
            LoadTransfer::Physical => transfer + 1.0,
            LoadTransfer::Printed => -transfer + 1.0,
        };
        let acceleration = numerator / denominator; // (12)
        let (load_front, load_rear) = unfloored_axle_loads(
            self,
            acceleration,
            p.cg_height,
            p.cg_ratio,
            u.spade_force_z,
            road,
        );
        let spin = |torque: f64, slip: T, load: T| {
            (-(stiffness * slip * load * self.wheel_radius) + torque) / self.axle_inertia // (13), (14)
        };
        Motion {
            speed: acceleration,
            front_wheel_speed: spin(u.front_torque, front, load_front),
            rear_wheel_speed: spin(u.rear_torque, rear, load_rear),
        }
    }

    /// `parts` explicit Euler steps of `dt / parts` (18). Unstable unless the steps are tiny: for comparison only.
    pub fn euler<T: Scalar>(
        &self,
        old: &Motion<T>,
        p: &Parameters<T>,
        u: &Inputs,
        road: &Road<T>,
        dt: f64,
        parts: u32,
    ) -> Motion<T> {
        let part = dt / f64::from(parts);
        (0..parts).fold(*old, |motion, _| {
            let rate = self.derivative(&motion, p, u, road);
            Motion {
                speed: motion.speed + rate.speed * part,
                front_wheel_speed: motion.front_wheel_speed + rate.front_wheel_speed * part,
                rear_wheel_speed: motion.rear_wheel_speed + rate.rear_wheel_speed * part,
            }
        })
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
