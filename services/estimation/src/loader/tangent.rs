//! The implicit step of [`super::wheel_dynamics`] with its derivatives written out: the model's tangent at one state.
//!
//! Each quantity of an axle depends on few others, so its derivatives are a handful of numbers; the acceleration and the speeds
//! of the first pass alone depend on everything and are rows. A fifth of the work of dual numbers, and equal to them but for
//! rounding (a test compares). The values are computed by the model's own functions.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | N_i | `load` | axle load, and its derivatives by h, lam, b, a |
//! | c_i | `conductance` | force per slip speed, K q N^-p phi N/den |
//! | phi, eta | - | u/atanh u of the tyre that saturates, and its derivative by ln u over phi |
//! | den | - | max(\|v\|, \|r w\|, v_min) |
//! | d_i | `denominator` | 1 + dt r^2 c/I |

use super::LoadTransfer;
use super::axle_loads::{LEAST_LOAD, axle_loads};
use super::layout::{
    CG_HEIGHT as H, CG_RATIO as LAM, FRONT_WHEEL, Layout, REAR_WHEEL, SLIP_STIFFNESS as K,
    SPEED as V,
};
use super::wheel_dynamics::{
    GRAVITY, Inputs, Motion, Parameters, ROLLING_WIDTH, Road, WheelDynamics,
};
use crate::ekf::add;
use crate::math::tanh;

/// The wheel speeds.
const W: [usize; 2] = [FRONT_WHEEL, REAR_WHEEL];

/// Use of the friction limit beyond which a tyre is taken to saturate no further.
const MOST_USED: f64 = 0.995;

/// The motion after a step, and its derivatives by the state before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangent<const N: usize> {
    /// Speed and wheel speeds one step later.
    pub motion: Motion<f64>,
    /// Row by row: of the speed, the front and the rear wheel speed.
    pub by: [[f64; N]; 3],
}

impl<const N: usize> Tangent<N> {
    /// This step and the next one as one step.
    pub(super) fn then(&self, next: &Self) -> Self {
        let by = next.by.map(|row| {
            let mut sum = row;
            sum[..3].fill(0.0);
            for (factor, before) in row.iter().zip(&self.by) {
                add(&mut sum, *factor, before);
            }
            sum
        });
        Self { by, ..*next }
    }
}

/// The step as far as it has been worked out: the acceleration that the loads are taken at, and the motion with its derivatives.
///
/// Before the first pass the motion is the old one, whose rows are unit rows; the first row is then that of the acceleration.
struct Stage<const N: usize> {
    acceleration: f64,
    motion: [f64; 3],
    by: [[f64; N]; 3],
}

impl<const N: usize> Stage<N> {
    /// Adds to a row what depends on this stage's acceleration and motion; a = (v - v_old)/dt behind a pass.
    #[inline(always)]
    fn chain<const FIRST: bool>(
        &self,
        row: &mut [f64; N],
        by_acceleration: f64,
        by_motion: [f64; 3],
        dt: f64,
    ) {
        if FIRST {
            add(row, by_acceleration, &self.by[0]);
            for j in 0..3 {
                row[j] += by_motion[j];
            }
            return;
        }
        let per_dt = by_acceleration / dt;
        row[V] -= per_dt;
        add(row, by_motion[V] + per_dt, &self.by[V]);
        for j in W {
            if by_motion[j] != 0.0 {
                add(row, by_motion[j], &self.by[j]);
            }
        }
    }
}

/// Resistance, and its derivatives by speed and slope bias; that by the spade force is 1.
struct Drag {
    value: f64,
    by_speed: f64,
    by_bias: f64,
}

/// Load of an axle and its derivatives; they vanish where the floor holds it.
#[derive(Clone, Copy)]
struct Load {
    value: f64,
    by_height: f64,
    by_ratio: f64,
    by_bias: f64,
    by_acceleration: f64,
}

/// One axle in a pass.
#[derive(Clone, Copy)]
struct Axle {
    load: Load,
    radius: f64,
    conductance: f64,
    per_denominator: f64,
    grip: f64,
    /// Wheel speed without the ground.
    spun: f64,
    /// Derivatives of the conductance: by the radius alone, by the load with its radius, by acceleration, speed, wheel speed.
    by_radius: f64,
    by_load: f64,
    by_acceleration: f64,
    by_speed: f64,
    by_wheel: f64,
}

/// What does not change from pass to pass.
struct Step<'a> {
    machine: &'a WheelDynamics,
    old: [f64; 3],
    p: &'a Parameters<f64>,
    u: &'a Inputs,
    road: &'a Road<f64>,
    dt: f64,
    drag: Drag,
}

/// Adds to the derivative by a parameter, where it is a state.
#[inline(always)]
fn at<const N: usize>(row: &mut [f64; N], place: Option<usize>, value: f64) {
    if let Some(place) = place {
        row[place] += value;
    }
}

impl WheelDynamics {
    /// [`WheelDynamics::step`] with its derivatives.
    #[inline]
    pub(super) fn step_tangent<const N: usize>(
        &self,
        old: &Motion<f64>,
        p: &Parameters<f64>,
        u: &Inputs,
        road: &Road<f64>,
        dt: f64,
    ) -> Tangent<N> {
        let step = Step {
            machine: self,
            old: [old.speed, old.front_wheel_speed, old.rear_wheel_speed],
            p,
            u,
            road,
            dt,
            drag: self.drag_tangent(old.speed, p, u, road),
        };
        let start = step.pass::<N, true>(&step.start());
        let Stage { motion, by, .. } = step.pass::<N, false>(&start);
        let [speed, front_wheel_speed, rear_wheel_speed] = motion;
        Tangent {
            motion: Motion {
                speed,
                front_wheel_speed,
                rear_wheel_speed,
            },
            by,
        }
    }

    #[inline(always)]
    fn drag_tangent(&self, speed: f64, p: &Parameters<f64>, u: &Inputs, road: &Road<f64>) -> Drag {
        let fade = tanh(speed / ROLLING_WIDTH);
        let weight = self.mass * GRAVITY;
        let rolling = (road.cosine * weight + u.spade_force_z) * self.rolling_resistance;
        Drag {
            value: self.faded_drag(fade, u, road) + p.spade_force_x + u.spade_force_x,
            by_speed: rolling * (1.0 - fade * fade) / ROLLING_WIDTH,
            by_bias: weight * (self.rolling_resistance * fade * road.sine - road.cosine),
        }
    }
}

impl Step<'_> {
    /// The rigid machine.
    #[inline(always)]
    fn start<const N: usize>(&self) -> Stage<N> {
        let (m, layout) = (self.machine, Layout::of(N));
        let errors = [self.p.front_radius_error, self.p.rear_radius_error];
        let torques = [self.u.front_torque, self.u.rear_torque];
        let radii = errors.map(|d| (d + 1.0) * m.wheel_radius);
        let acceleration = m.rigid_acceleration(radii[0], radii[1], self.u, self.drag.value);
        let per_radius = radii.map(|r| 1.0 / r);
        let spin = per_radius.map(|per| m.axle_inertia * per * per);
        let per_mass = 1.0 / (spin[0] + spin[1] + m.mass);
        let mut by = [0.0; N];
        by[V] = -self.drag.by_speed * per_mass;
        at(&mut by, layout.spade_force, -per_mass);
        at(&mut by, layout.slope_bias, -self.drag.by_bias * per_mass);
        for i in 0..2 {
            let along = 2.0 * acceleration * spin[i] - torques[i] * per_radius[i];
            let radius = m.wheel_radius * per_radius[i] * along * per_mass;
            at(&mut by, layout.radii.map(|place| place[i]), radius);
        }
        Stage {
            acceleration,
            motion: self.old,
            by: [by, [0.0; N], [0.0; N]],
        }
    }

    #[inline(always)]
    fn loads(&self, acceleration: f64) -> [Load; 2] {
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
        let (weight, per_base) = (m.mass * GRAVITY, m.mass / m.wheelbase);
        let by_height = -sign * per_base * (acceleration + sign * GRAVITY * road.sine);
        let by_acceleration = -sign * per_base * p.cg_height;
        let tilt = per_base * p.cg_height * GRAVITY * road.cosine;
        let least = LEAST_LOAD * m.mass * GRAVITY;
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
    fn radius_by_load(&self) -> f64 {
        let m = self.machine;
        let sensitivity = m.radius_load_sensitivity + self.p.load_sensitivity_error;
        -m.wheel_radius * sensitivity / (0.5 * m.mass * GRAVITY)
    }

    /// Axle `i` under a load, at the speeds of the pass before.
    #[inline(always)]
    fn axle(&self, i: usize, load: Load, acceleration: f64, motion: &[f64; 3]) -> Axle {
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
        // Which of the three the denominator is, as `max` decides.
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

    /// eta of a tyre of this phi, and one over the torque that it must bear; 0, 0 where the stiffness does not bend.
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
        if !(1e-6..MOST_USED).contains(&used) {
            return (0.0, 0.0);
        }
        (1.0 - phi / (1.0 - used * used), 1.0 / borne)
    }

    /// Speeds under the loads and grips of the stage before; the `FIRST` has unit rows.
    #[inline(always)]
    fn pass<const N: usize, const FIRST: bool>(&self, from: &Stage<N>) -> Stage<N> {
        let (m, dt, layout) = (self.machine, self.dt, Layout::of(N));
        let (per_mass, per_inertia) = (dt / m.mass, dt / m.axle_inertia);
        let stiffness = self.p.slip_stiffness;
        let radius_by_load = self.radius_by_load();
        let loads = self.loads(from.acceleration);
        let axle = |i: usize| self.axle(i, loads[i], from.acceleration, &from.motion);
        let axles = [axle(0), axle(1)];
        let [front, rear] = &axles;
        let free = [front.radius * front.spun, rear.radius * rear.spun];
        let push = front.grip * free[0] + rear.grip * free[1] - self.drag.value;
        let resistance = (front.grip + rear.grip) * per_mass + 1.0;
        let speed = (self.old[V] + push * per_mass) / resistance;
        let per_resistance = 1.0 / resistance;

        let mut speed_by = [0.0; N];
        speed_by[V] = per_resistance * (1.0 - per_mass * self.drag.by_speed);
        at(
            &mut speed_by,
            layout.spade_force,
            -per_mass * per_resistance,
        );
        let by_bias = -per_mass * per_resistance * self.drag.by_bias;
        at(&mut speed_by, layout.slope_bias, by_bias);
        let (mut by_acceleration, mut by_motion) = (0.0, [0.0; 3]);
        for (i, axle) in axles.iter().enumerate() {
            let Axle { load, radius, .. } = *axle;
            let per = axle.per_denominator;
            // Derivatives of the speed by the conductance, by the free rim speed.
            let alpha = per_mass * (free[i] - speed) * per_resistance * per * per;
            let beta = per_mass * axle.grip * per_resistance;
            let bend = 2.0 * per_inertia * radius * axle.conductance * axle.conductance;
            let by_load =
                alpha * (axle.by_load - bend * radius_by_load) + beta * axle.spun * radius_by_load;
            let by_radius = alpha * (axle.by_radius - bend) + beta * axle.spun;
            speed_by[W[i]] += beta * radius;
            speed_by[K] += alpha * axle.conductance / stiffness;
            speed_by[H] += by_load * load.by_height;
            speed_by[LAM] += by_load * load.by_ratio;
            at(&mut speed_by, layout.slope_bias, by_load * load.by_bias);
            let radius_error = layout.radii.map(|place| place[i]);
            at(&mut speed_by, radius_error, by_radius * m.wheel_radius);
            let by_sensitivity = -by_radius * m.wheel_radius * m.excess(load.value);
            at(&mut speed_by, layout.load_sensitivity, by_sensitivity);
            by_acceleration += alpha * axle.by_acceleration + by_load * load.by_acceleration;
            by_motion[V] += alpha * axle.by_speed;
            by_motion[W[i]] = alpha * axle.by_wheel;
        }
        from.chain::<FIRST>(&mut speed_by, by_acceleration, by_motion, dt);

        let mut by = [speed_by, [0.0; N], [0.0; N]];
        let mut motion = [speed, 0.0, 0.0];
        for (i, axle) in axles.iter().enumerate() {
            (motion[W[i]], by[W[i]]) = self.wheel::<N, FIRST>(i, axle, speed, &speed_by, from);
        }
        Stage {
            acceleration: (speed - self.old[V]) / dt,
            motion,
            by,
        }
    }

    /// Speed of wheel `i` behind a speed of the machine, and its derivatives.
    #[inline(always)]
    fn wheel<const N: usize, const FIRST: bool>(
        &self,
        i: usize,
        axle: &Axle,
        speed: f64,
        speed_by: &[f64; N],
        from: &Stage<N>,
    ) -> (f64, [f64; N]) {
        let (m, dt, layout) = (self.machine, self.dt, Layout::of(N));
        let (per_inertia, stiffness) = (dt / m.axle_inertia, self.p.slip_stiffness);
        let radius_by_load = self.radius_by_load();
        let torque = [self.u.front_torque, self.u.rear_torque][i];
        let (radius, conductance, per) = (axle.radius, axle.conductance, axle.per_denominator);
        let wheel = (self.old[W[i]] + (radius * conductance * speed + torque) * per_inertia) * per;
        let by_conductance = per_inertia * radius * (speed - radius * wheel) * per;
        let by_radius_alone = per_inertia * conductance * (speed - 2.0 * radius * wheel) * per;
        let by_radius = by_radius_alone + by_conductance * axle.by_radius;
        let by_load = by_conductance * axle.by_load + by_radius_alone * radius_by_load;
        let mut row = [0.0; N];
        row[W[i]] = per;
        row[K] = by_conductance * conductance / stiffness;
        row[H] = by_load * axle.load.by_height;
        row[LAM] = by_load * axle.load.by_ratio;
        at(&mut row, layout.slope_bias, by_load * axle.load.by_bias);
        let radius_error = layout.radii.map(|place| place[i]);
        at(&mut row, radius_error, by_radius * m.wheel_radius);
        let by_sensitivity = -by_radius * m.wheel_radius * m.excess(axle.load.value);
        at(&mut row, layout.load_sensitivity, by_sensitivity);
        let pull = per_inertia * radius * axle.grip;
        let by_acceleration =
            by_conductance * axle.by_acceleration + by_load * axle.load.by_acceleration;
        add(&mut row, pull, speed_by);
        let mut by_motion = [by_conductance * axle.by_speed, 0.0, 0.0];
        by_motion[W[i]] = by_conductance * axle.by_wheel;
        from.chain::<FIRST>(&mut row, by_acceleration, by_motion, dt);
        (wheel, row)
    }
}

#[cfg(test)]
#[allow(clippy::needless_range_loop)]
mod tests {
    use super::*;
    use crate::dual::Dual;
    use crate::loader::wheel_dynamics::Tyres;

    /// Uniform numbers of xorshift.
    struct Uniform(u64);

    impl Uniform {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        fn around(&mut self, centre: f64, width: f64) -> f64 {
            centre + width * (self.next() - 0.5)
        }
    }

    fn machine(k: u32) -> WheelDynamics {
        WheelDynamics {
            mass: 4700.0,
            wheel_radius: 0.55,
            axle_inertia: 3.33,
            wheelbase: 2.3,
            bucket_reach: 1.7,
            rolling_resistance: 0.02,
            friction: if k.is_multiple_of(5) {
                f64::INFINITY
            } else {
                0.8
            },
            radius_load_sensitivity: 0.004,
            minimum_speed: 0.3,
            load_transfer: if k.is_multiple_of(7) {
                LoadTransfer::Printed
            } else {
                LoadTransfer::Physical
            },
            tyres: if k.is_multiple_of(2) {
                Tyres::new(1.2, 0.15)
            } else {
                Tyres::ALIKE
            },
        }
    }

    /// Forward and backward, slow and fast, skidding, an axle in the air: values as the model's, derivatives as dual numbers'.
    fn check<const N: usize>(seed: u64) {
        let mut random = Uniform(seed);
        for k in 0..5000 {
            let machine = machine(k);
            let speed = random.around(1.0, 10.0);
            let spread = if k.is_multiple_of(3) { 0.5 } else { 0.06 };
            let x: [f64; N] = core::array::from_fn(|i| match i {
                V => speed,
                1 | 2 => speed / 0.55 * random.around(1.0, spread),
                K => random.around(20.0, 20.0),
                H => random.around(1.0, 1.0),
                LAM => random.around(0.5, 0.7),
                6 if N >= 10 => random.around(0.0, 4000.0),
                9 => random.around(0.0, 0.05),
                10 if N == 12 => random.around(0.0, 0.01),
                _ => random.around(0.0, 0.02),
            });
            let u = Inputs {
                front_torque: random.around(0.0, 30_000.0),
                rear_torque: random.around(0.0, 30_000.0),
                spade_force_x: random.around(0.0, 2000.0),
                spade_force_z: random.around(0.0, 60_000.0),
                slope: random.around(0.0, 0.3),
            };
            let dt = random.around(0.011, 0.02);
            let parameters = Parameters::of(&x);
            let road = Road::of(-parameters.slope_bias + u.slope);
            let tangent = machine.step_tangent::<N>(&Motion::of(&x), &parameters, &u, &road, dt);
            let dual: [Dual<N>; N] = core::array::from_fn(|i| {
                Dual::new(x[i], core::array::from_fn(|j| f64::from(u8::from(i == j))))
            });
            let parameters = Parameters::of(&dual);
            let road = Road::of(-parameters.slope_bias + u.slope);
            let exact = machine.step(&Motion::of(&dual), &parameters, &u, &road, dt);
            let ours = tangent.motion;
            for (value, row, exact) in [
                (ours.speed, tangent.by[0], exact.speed),
                (
                    ours.front_wheel_speed,
                    tangent.by[1],
                    exact.front_wheel_speed,
                ),
                (ours.rear_wheel_speed, tangent.by[2], exact.rear_wheel_speed),
            ] {
                assert!((value - exact.value).abs() < 1e-12 * (1.0 + value.abs()));
                let size = |i: usize| if i == 6 && N >= 10 { 1e-9 } else { 1e-3 };
                for i in 0..N {
                    // Relative, or to what moves a speed by a thousandth of it for a unit of the state.
                    let scale = exact.derivative[i].abs().max(size(i));
                    let error = (row[i] - exact.derivative[i]).abs() / scale;
                    assert!(error < 1e-9, "{k}, {i}: {} {:?}", row[i], exact.derivative);
                }
            }
        }
    }

    #[test]
    fn the_tangent_is_the_derivative_of_the_step() {
        check::<6>(1);
        check::<9>(2);
        check::<11>(3);
        check::<12>(4);
    }
}
