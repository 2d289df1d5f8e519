//! The linearly implicit step: backward Euler with frozen loads and slip denominators, in closed form. It is unconditionally stable
//! at constant cost, for any sign of v, standstill included. Two passes update loads and friction.

use super::{Inputs, Motion, Parameters, Road, WheelDynamics};
use crate::loader::physics::axle_loads::axle_loads;
use crate::scalar::Scalar;

/// One axle in a pass of the implicit step.
struct Axle<T> {
    /// Gain of its slip stiffness.
    gain: T,
    torque: T,
    /// Relative radius error.
    error: T,
    /// Error of the load sensitivity of the radius.
    sensitivity_error: T,
    load: T,
    stiffness: T,
    acceleration: T,
}

/// Values common to all passes.
struct Step<'a, T> {
    machine: &'a WheelDynamics,
    old: &'a Motion<T>,
    p: &'a Parameters<T>,
    u: &'a Inputs,
    road: &'a Road<T>,
    dt: f64,
    drag: T,
}

impl<T: Scalar> Step<'_, T> {
    /// Returns the motion under the loads of an acceleration and the slips of the pass before.
    #[inline(always)]
    fn pass(&self, acceleration: T, before: &Motion<T>) -> Motion<T> {
        let Self {
            machine,
            old,
            p,
            u,
            road,
            dt,
            drag,
        } = *self;
        let (load_front, load_rear) = axle_loads(
            machine,
            acceleration,
            p.cg_height,
            p.cg_ratio,
            u.spade_force_z,
            road,
        );
        let (w_front, w_rear) = (old.front_wheel_speed, old.rear_wheel_speed);
        let axle = |axle: usize, torque, error, load| Axle {
            gain: T::constant(machine.tyres.gains[axle]),
            torque: T::constant(torque),
            error,
            sensitivity_error: p.load_sensitivity_error,
            load,
            stiffness: p.slip_stiffness,
            acceleration,
        };
        let front = axle(0, u.front_torque, p.front_radius_error, load_front);
        let speeds = [before.speed, before.front_wheel_speed];
        let front = machine.grip(&front, w_front, speeds, dt);
        let rear = axle(1, u.rear_torque, p.rear_radius_error, load_rear);
        let speeds = [before.speed, before.rear_wheel_speed];
        let rear = machine.grip(&rear, w_rear, speeds, dt);
        let push = front.grip * front.free_rim_speed + rear.grip * rear.free_rim_speed - drag;
        let speed = (old.speed + push * (dt / machine.mass))
            / ((front.grip + rear.grip) * (dt / machine.mass) + 1.0);
        Motion {
            speed,
            front_wheel_speed: machine.wheel_speed(&front, u.front_torque, w_front, speed, dt),
            rear_wheel_speed: machine.wheel_speed(&rear, u.rear_torque, w_rear, speed, dt),
        }
    }
}

/// Contribution of one wheel to the implicit step.
pub(in crate::loader::physics) struct Wheel<T> {
    /// r_i c_i: force per slip speed times radius.
    pull: T,
    /// N_i = 1 + dt r_i^2 c_i/I.
    pub denominator: T,
    /// g_i = c_i/N_i.
    pub grip: T,
    /// r_i w_i + dt r_i T_i/I: rim speed without the force of the ground.
    free_rim_speed: T,
}

impl WheelDynamics {
    /// One linearly implicit step of `dt` seconds.
    #[inline(always)]
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
        let acceleration = self.rigid_acceleration(radius_front, radius_rear, u, drag);
        let step = Step {
            machine: self,
            old,
            p,
            u,
            road,
            dt,
            drag,
        };
        // No loop over the passes: it would load their common values again.
        let first = step.pass(acceleration, old);
        step.pass((first.speed - old.speed) / dt, &first)
    }

    /// Contribution of an axle at the speeds of body and wheels of the pass before.
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
        let unbent = self.axle_stiffness(axle.gain, axle.stiffness, load);
        let stiffness = self.stiffness(unbent, torque, radius, load, axle.acceleration);
        let slip_speed = self.slip_denominator(speed, radius * wheel_speed);
        self.wheel(stiffness * load / slip_speed, torque, radius, old_speed, dt)
    }

    /// `parts` linearly implicit steps of `dt / parts` with the same inputs.
    #[inline(always)]
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
        let mut motion = *old;
        for _ in 0..parts {
            motion = self.step(&motion, p, u, road, part);
        }
        motion
    }

    #[inline(always)]
    pub(in crate::loader::physics) fn wheel<T: Scalar>(
        &self,
        force_per_slip_speed: T,
        torque: T,
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
            free_rim_speed: radius * (old_speed + torque * dt / self.axle_inertia),
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
}
