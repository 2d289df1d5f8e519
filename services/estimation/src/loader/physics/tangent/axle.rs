//! One axle in a pass: load, grip, and their derivatives.

use super::{H, LAM, Step, V, W, at};
use crate::loader::LoadTransfer;
use crate::loader::layout::Layout;
use crate::loader::physics::axle_loads::{LEAST_LOAD, axle_loads};
use crate::loader::physics::wheel_dynamics::{MOST_USED, WheelDynamics};

/// Use of the friction limit below which a tyre does not saturate.
const LEAST_USED: f64 = 1e-6;

/// Load of an axle and its derivatives, which are 0 where its floor applies.
#[derive(Clone, Copy)]
pub(super) struct Load {
    pub value: f64,
    pub by_height: f64,
    pub by_ratio: f64,
    pub by_bias: f64,
    pub by_acceleration: f64,
}

/// One axle in a pass.
#[derive(Clone, Copy)]
pub(super) struct Axle {
    pub load: Load,
    pub radius: f64,
    pub conductance: f64,
    pub per_denominator: f64,
    pub grip: f64,
    /// Wheel speed without the force of the ground.
    pub spun: f64,
    /// Derivatives of the conductance: by the radius alone, by the load with its radius, by acceleration, speed, wheel speed.
    pub by_radius: f64,
    pub by_load: f64,
    pub by_acceleration: f64,
    pub by_speed: f64,
    pub by_wheel: f64,
}

impl Axle {
    /// Adds the derivatives by the parameters through the load and the radius of axle `i`.
    #[inline(always)]
    pub fn put<const N: usize>(
        &self,
        row: &mut [f64; N],
        i: usize,
        [by_load, by_radius]: [f64; 2],
        machine: &WheelDynamics,
    ) {
        let layout = Layout::of(N);
        row[H] += by_load * self.load.by_height;
        row[LAM] += by_load * self.load.by_ratio;
        at(row, layout.slope_bias, by_load * self.load.by_bias);
        let radius_error = layout.radii.map(|place| place[i]);
        at(row, radius_error, by_radius * machine.wheel_radius);
        let by_sensitivity = -by_radius * machine.wheel_radius * machine.excess(self.load.value);
        at(row, layout.load_sensitivity, by_sensitivity);
    }
}

impl Step<'_> {
    #[inline(always)]
    pub(super) fn loads(&self, acceleration: f64) -> [Load; 2] {
        let (m, p, road) = (self.machine, self.p, self.road);
        let (front, rear) = axle_loads(
            m,
            acceleration,
            p.cg_height,
            p.cg_ratio,
            self.u.spade_force_z,
            road,
        );
        let sign = match m.load_transfer {
            LoadTransfer::Physical => 1.0,
            LoadTransfer::Printed => -1.0,
        };
        let (weight, per_base) = (m.mass * m.gravity, m.mass / m.wheelbase);
        let by_height = -sign * per_base * (acceleration + sign * m.gravity * road.sine);
        let by_acceleration = -sign * per_base * p.cg_height;
        let tilt = per_base * p.cg_height * m.gravity * road.cosine;
        let least = LEAST_LOAD * m.mass * m.gravity;
        let load = |value: f64, sign: f64, share: f64| {
            let live = if value > least { 1.0 } else { 0.0 };
            let signed = live * sign;
            Load {
                value,
                by_height: signed * by_height,
                by_ratio: signed * weight * road.cosine,
                by_bias: live * weight * share * road.sine + signed * tilt,
                by_acceleration: signed * by_acceleration,
            }
        };
        [
            load(front, 1.0, p.cg_ratio),
            load(rear, -1.0, 1.0 - p.cg_ratio),
        ]
    }

    /// Derivative of a rolling radius by its load [m/N].
    #[inline(always)]
    pub(super) fn radius_by_load(&self) -> f64 {
        let m = self.machine;
        let sensitivity = m.radius_load_sensitivity + self.p.load_sensitivity_error;
        -m.wheel_radius * sensitivity / (0.5 * m.empty_mass * m.gravity)
    }

    /// Axle `i` under a load, at the speeds of the pass before.
    #[inline(always)]
    pub(super) fn axle(&self, i: usize, load: Load, acceleration: f64, motion: &[f64; 3]) -> Axle {
        let (m, p, dt) = (self.machine, self.p, self.dt);
        let error = [p.front_radius_error, p.rear_radius_error][i];
        let torque = [self.u.front_torque, self.u.rear_torque][i];
        let radius = m.radius(error, p.load_sensitivity_error, load.value);
        let radius_by_load = self.radius_by_load();
        let unbent = m.axle_stiffness(i, p.slip_stiffness, load.value);
        let stiffness = m.stiffness(unbent, torque, radius, load.value, acceleration);
        let (speed, rim) = (motion[V], radius * motion[W[i]]);
        let slowest = m.slip_denominator(speed, rim);
        let conductance = stiffness * load.value / slowest;
        let wheel = m.wheel(conductance, torque, radius, self.old[W[i]], dt);

        let bent = stiffness / unbent;
        let (eta, per_demand) = self.saturation(bent, torque, radius, load.value, acceleration);
        let per_radius = 1.0 / radius;
        let inertia = m.axle_inertia * per_radius * per_demand;
        let by_slowest = -conductance / slowest;
        // The denominator is one of three, selected as `max` does.
        let (mut by_speed, mut by_wheel, mut slowest_by_radius) = (0.0, 0.0, 0.0);
        if slowest > m.minimum_speed {
            if speed.abs() > rim.abs() {
                by_speed = by_slowest * 1.0_f64.copysign(speed);
            } else {
                let signed = by_slowest * 1.0_f64.copysign(rim);
                by_wheel = signed * radius;
                slowest_by_radius = signed * motion[W[i]];
            }
        }
        let by_radius = conductance * eta * (acceleration * inertia * per_radius - per_radius)
            + slowest_by_radius;
        Axle {
            load,
            radius,
            conductance,
            per_denominator: 1.0 / wheel.denominator,
            grip: wheel.grip,
            spun: self.old[W[i]] + dt * torque / m.axle_inertia,
            by_radius,
            by_load: conductance * (1.0 - eta - m.tyres.load_exponent) / load.value
                + by_radius * radius_by_load,
            by_acceleration: -conductance * eta * inertia,
            by_speed,
            by_wheel,
        }
    }

    /// Returns eta of a tyre with this phi, and one over the torque that it bears; 0, 0 where the stiffness does not saturate.
    #[inline(always)]
    fn saturation(
        &self,
        phi: f64,
        torque: f64,
        radius: f64,
        load: f64,
        acceleration: f64,
    ) -> (f64, f64) {
        let m = self.machine;
        if m.friction.is_infinite() {
            return (0.0, 0.0);
        }
        let borne = torque - acceleration * m.axle_inertia / radius;
        let used = borne.abs() / (radius * load * m.friction);
        if !(LEAST_USED..MOST_USED).contains(&used) {
            return (0.0, 0.0);
        }
        (1.0 - phi / (1.0 - used * used), 1.0 / borne)
    }
}
