//! The axles in a pass: load, grip, and their derivatives. Both pass through the formulas together, the front axle in the first lane.

use super::{H, LAM, Step, V, at, wheels};
use crate::loader::LoadTransfer;
use crate::loader::layout::Layout;
use crate::loader::physics::axle_loads::{LEAST_LOAD, axle_loads};
use crate::loader::physics::wheel_dynamics::{MOST_USED, WheelDynamics};
use crate::pair::Pair;
use crate::scalar::Scalar;

/// Use of the friction limit below which a tyre does not saturate.
const LEAST_USED: f64 = 1e-6;

const ZERO: Pair = Pair([0.0; 2]);
const ONE: Pair = Pair([1.0; 2]);

/// Load of an axle and its derivatives, which are 0 where its floor applies.
#[derive(Clone, Copy)]
pub(super) struct Load {
    pub value: Pair,
    pub by_height: Pair,
    pub by_ratio: Pair,
    pub by_bias: Pair,
    pub by_acceleration: Pair,
}

/// The axles in a pass.
pub(super) struct Axles {
    pub load: Load,
    pub radius: Pair,
    pub conductance: Pair,
    pub per_denominator: Pair,
    pub grip: Pair,
    /// Wheel speed without the force of the ground.
    pub spun: Pair,
    /// Derivatives of the conductance: by the radius alone, by the load with its radius, by acceleration, speed, wheel speed.
    pub by_radius: Pair,
    pub by_load: Pair,
    pub by_acceleration: Pair,
    pub by_speed: Pair,
    pub by_wheel: Pair,
}

/// Derivatives by the parameters, through the load and the radius of each axle.
pub(super) struct ByParameter {
    height: Pair,
    ratio: Pair,
    bias: Pair,
    radius_error: Pair,
    sensitivity: Pair,
}

impl Axles {
    /// Derivatives of a quantity with these derivatives by load and radius.
    #[inline(always)]
    pub fn parameters(
        &self,
        by_load: Pair,
        by_radius: Pair,
        machine: &WheelDynamics,
    ) -> ByParameter {
        ByParameter {
            height: by_load * self.load.by_height,
            ratio: by_load * self.load.by_ratio,
            bias: by_load * self.load.by_bias,
            radius_error: by_radius * machine.wheel_radius,
            sensitivity: -by_radius * machine.wheel_radius * machine.excess(self.load.value),
        }
    }
}

impl ByParameter {
    /// Adds those of axle `i`.
    #[inline(always)]
    pub fn put<const N: usize>(&self, row: &mut [f64; N], i: usize) {
        let layout = Layout::of(N);
        row[H] += self.height.0[i];
        row[LAM] += self.ratio.0[i];
        at(row, layout.slope_bias, self.bias.0[i]);
        let place = layout.radii.map(|place| place[i]);
        at(row, place, self.radius_error.0[i]);
        at(row, layout.load_sensitivity, self.sensitivity.0[i]);
    }
}

impl Step<'_> {
    #[inline(always)]
    pub(super) fn loads(&self, acceleration: f64) -> Load {
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
        let least = Pair::constant(LEAST_LOAD * m.mass * m.gravity);
        let (value, share) = (Pair([front, rear]), Pair([p.cg_ratio, 1.0 - p.cg_ratio]));
        let live = value.above(least, ONE, ZERO);
        let signed = live * Pair([1.0, -1.0]);
        Load {
            value,
            by_height: signed * by_height,
            by_ratio: signed * weight * road.cosine,
            by_bias: live * weight * share * road.sine + signed * tilt,
            by_acceleration: signed * by_acceleration,
        }
    }

    /// Derivative of a rolling radius by its load [m/N].
    #[inline(always)]
    pub(super) fn radius_by_load(&self) -> f64 {
        let m = self.machine;
        let sensitivity = m.radius_load_sensitivity + self.p.load_sensitivity_error;
        -m.wheel_radius * sensitivity / (0.5 * m.empty_mass * m.gravity)
    }

    /// The axles at this acceleration, at the speeds of the pass before.
    #[inline(always)]
    pub(super) fn axles(&self, acceleration: f64, motion: &[f64; 3]) -> Axles {
        let (m, p, dt) = (self.machine, self.p, self.dt);
        let load = self.loads(acceleration);
        let error = Pair([p.front_radius_error, p.rear_radius_error]);
        let sensitivity_error = Pair::constant(p.load_sensitivity_error);
        let radius = m.radius(error, sensitivity_error, load.value);
        let radius_by_load = self.radius_by_load();
        let slip_stiffness = Pair::constant(p.slip_stiffness);
        let unbent = m.axle_stiffness(Pair(m.tyres.gains), slip_stiffness, load.value);
        let rate = Pair::constant(acceleration);
        let stiffness = m.stiffness(unbent, self.torques, radius, load.value, rate);
        let (speed, wheel_speed) = (Pair::constant(motion[V]), wheels(motion));
        let rim = radius * wheel_speed;
        let slowest = m.slip_denominator(speed, rim);
        let conductance = stiffness * load.value / slowest;
        let wheel = m.wheel(conductance, self.torques, radius, wheels(&self.old), dt);

        let (eta, per_demand) = self.saturation(stiffness / unbent, radius, load.value, rate);
        let per_radius = ONE / radius;
        let inertia = per_radius * m.axle_inertia * per_demand;
        // The denominator is one of three, selected as `max` does.
        let by_slowest = -conductance / slowest;
        let slides = |by: Pair| slowest.above(Pair::constant(m.minimum_speed), by, ZERO);
        let by_speed = slides(speed.abs().above(rim.abs(), by_slowest * sign(speed), ZERO));
        let by_rim = slides(speed.abs().above(rim.abs(), ZERO, by_slowest * sign(rim)));
        let by_radius = conductance * eta * (inertia * acceleration * per_radius - per_radius)
            + by_rim * wheel_speed;
        Axles {
            load,
            radius,
            conductance,
            per_denominator: ONE / wheel.denominator,
            grip: wheel.grip,
            spun: wheels(&self.old) + self.torques * dt / m.axle_inertia,
            by_radius,
            by_load: conductance * (-eta + 1.0 - m.tyres.load_exponent) / load.value
                + by_radius * radius_by_load,
            by_acceleration: -conductance * eta * inertia,
            by_speed,
            by_wheel: by_rim * radius,
        }
    }

    /// Returns eta of a tyre with this phi, and one over the torque that it bears; 0, 0 where the stiffness does not saturate.
    #[inline(always)]
    fn saturation(&self, phi: Pair, radius: Pair, load: Pair, acceleration: Pair) -> (Pair, Pair) {
        let m = self.machine;
        if m.friction.is_infinite() {
            return (ZERO, ZERO);
        }
        let borne = self.torques - acceleration * m.axle_inertia / radius;
        let used = borne.abs() / (radius * load * m.friction);
        let saturates = |value: Pair| {
            let value = Pair::constant(LEAST_USED).above(used, ZERO, value);
            Pair::constant(MOST_USED).above(used, value, ZERO)
        };
        let eta = -(phi / (-(used * used) + 1.0)) + 1.0;
        (saturates(eta), saturates(ONE / borne))
    }
}

/// 1 or -1.
#[inline(always)]
fn sign(of: Pair) -> Pair {
    Pair(of.0.map(|x| 1.0_f64.copysign(x)))
}
