//! The rates as printed, and Euler steps of them: for comparison only.
//!
//! A wheel's eigenvalue is some -1.5e4 1/s at 3 m/s, so 10 ms steps are unstable for a real machine (the paper's Table 1 gives 4.7 kg).

use super::{GRAVITY, Inputs, Motion, Parameters, ROLLING_WIDTH, Road, WheelDynamics};
use crate::loader::LoadTransfer;
use crate::loader::physics::axle_loads::unfloored_axle_loads;
use crate::scalar::Scalar;

impl WheelDynamics {
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

    /// `parts` explicit Euler steps of `dt / parts` (18). Unstable unless the steps are tiny.
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
}
