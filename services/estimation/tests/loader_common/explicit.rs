//! The rates as printed, and Euler steps of them: for comparison only.
//!
//! A wheel's eigenvalue is some -1.5e4 1/s at 3 m/s, so 10 ms steps are unstable for a real machine (the paper's Table 1 gives 4.7 kg).

use estimation::loader::LoadTransfer;
use estimation::loader::axle_loads::unfloored_axle_loads;
use estimation::loader::cg_model::CgModel;
use estimation::loader::wheel_dynamics::{Inputs, Motion, Parameters, Road, WheelDynamics};
use estimation::model::Model;
use estimation::scalar::Scalar;

/// Width of the rolling resistance at standstill [m/s].
const ROLLING_WIDTH: f64 = 0.05;

/// The machine in explicit steps.
pub struct Explicit(pub WheelDynamics);

impl Explicit {
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
        let machine = &self.0;
        let slip = |wheel_speed: T| {
            let rim = wheel_speed * machine.wheel_radius;
            let fastest = motion.speed.abs().max(rim.abs());
            (rim - motion.speed) / fastest.max(T::constant(machine.minimum_speed))
        };
        let (front, rear) = (
            slip(motion.front_wheel_speed),
            slip(motion.rear_wheel_speed),
        );
        let stiffness = p.slip_stiffness;
        let transfer = p.cg_height * stiffness * (front - rear) / machine.wheelbase;
        let rolling = (motion.speed / ROLLING_WIDTH).tanh() * machine.rolling_resistance;
        let lever = machine.bucket_reach / machine.wheelbase;
        let pull =
            p.cg_ratio * stiffness * front + (-p.cg_ratio + 1.0) * stiffness * rear - rolling;
        let spade = (stiffness * (front * (1.0 + lever) - rear * lever) - rolling)
            * (u.spade_force_z / machine.mass);
        let numerator = pull * road.cosine * machine.gravity
            - (transfer + 1.0) * road.sine * machine.gravity
            + spade
            - (p.spade_force_x + u.spade_force_x) / machine.mass;
        let denominator = match machine.load_transfer {
            LoadTransfer::Physical => transfer + 1.0,
            LoadTransfer::Printed => -transfer + 1.0,
        };
        let acceleration = numerator / denominator; // (12)
        let (load_front, load_rear) = unfloored_axle_loads(
            machine,
            acceleration,
            p.cg_height,
            p.cg_ratio,
            u.spade_force_z,
            road,
        );
        let spin = |torque: f64, slip: T, load: T| {
            (-(stiffness * slip * load * machine.wheel_radius) + torque) / machine.axle_inertia // (13), (14)
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

/// A model of the loader in explicit steps, with six states and three measurements.
pub struct ExplicitModel(pub CgModel);

impl Model<6, 3> for ExplicitModel {
    const DYNAMIC: usize = 3;
    const DIRECT: core::ops::Range<usize> = 0..3;

    fn predict<T: Scalar>(&self, state: &[T; 6]) -> ([T; 6], [T; 3]) {
        let CgModel {
            dynamics,
            inputs,
            dt,
            substeps,
            ..
        } = self.0;
        let road = Road::of(T::constant(inputs.slope));
        let (old, parameters) = (Motion::of(state), Parameters::of(state));
        let new = Explicit(dynamics).euler(&old, &parameters, &inputs, &road, dt, substeps);
        let moved = [new.speed, new.front_wheel_speed, new.rear_wheel_speed];
        let mut next = *state;
        next[..3].copy_from_slice(&moved);
        (next, moved)
    }

    fn noise_coupling(&self) -> [[f64; 6]; 3] {
        Model::<6, 3>::noise_coupling(&self.0)
    }
}
