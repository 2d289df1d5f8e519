//! The reference plant: a half car with relaxed slip.
//!
//! | symbol | here | meaning | unit |
//! |---|---|---|---|
//! | v, omega_f, omega_r | `state[0..3]` | speed of the body, wheel speeds | m/s, rad/s |
//! | s_f, s_r | `state[3..5]` | relaxed slips | 1 |
//! | z, z', p, p' | `state[5..9]` | heave (up), pitch (nose up) and their rates | m, m/s, rad, rad/s |
//! | x | `state[9]` | distance of the centre of gravity along the road | m |
//!
//! The axle loads result from the tyre deflections, not from the load-transfer equations (6), (7) of Yang, Wang, Han 2021, which
//! the estimators use. The tyre force saturates, F_x = mu tanh(K q / mu) F_z, where their (8), (9) are linear.

use super::road::Road;
use crate::rk4::{self, Stage};

/// Acceleration of gravity [m/s^2].
pub const GRAVITY: f64 = 9.81;
/// Longest integration step [s]. Against a fifth of it, the reference's, the speed changes by 5e-6 m/s on the roughest road and by less than
/// 2e-8 m/s at work, the wheel speeds by 5e-6 and 2e-7 rad/s: a hundredth of the best sensor's noise.
const STEP: f64 = 5e-4;
/// Inputs are tabulated at this interval and linear in between [s].
const INPUT_INTERVAL: f64 = 1e-3;
/// Length after which the ground changes [m].
const STRETCH: f64 = 15.0;
/// Speed below which the rolling resistance fades out [m/s].
const ROLLING_FADE: f64 = 0.05;
/// Least speed in the relaxation, so that slip relaxes at standstill too [m/s].
const SMALLEST_SLIP_SPEED: f64 = 0.02;

/// The true loader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// Mass without payload \[kg\].
    pub mass: f64,
    /// Height of the centre of gravity above ground, without payload \[m\].
    pub cg_height: f64,
    /// Share of the static weight on the front axle, l_r / l, without payload.
    pub cg_ratio: f64,
    /// Slip stiffness K.
    pub slip_stiffness: f64,
    /// Friction coefficient mu.
    pub friction: f64,
    /// Rolling resistance f.
    pub rolling_resistance: f64,
    /// Relaxation length of the tyres \[m\].
    pub relaxation_length: f64,
    /// Time constant of the carcass \[s\].
    pub carcass_time: f64,
    /// Vertical stiffness of the tyres of one axle [N/m].
    pub tyre_stiffness: f64,
    /// Vertical damping of the tyres of one axle [N s/m].
    pub tyre_damping: f64,
    /// Moment of inertia about the lateral axis [kg m^2].
    pub pitch_inertia: f64,
    /// Nominal rolling radius \[m\].
    pub wheel_radius: f64,
    /// Moment of inertia of one axle [kg m^2].
    pub axle_inertia: f64,
    /// Wheelbase \[m\].
    pub wheelbase: f64,
    /// From the front axle to the bucket tip \[m\].
    pub bucket_reach: f64,
    /// Gear ratio from motor to wheel.
    pub gear_ratio: f64,
    /// Relative error of the front rolling radius.
    pub front_radius_error: f64,
    /// Relative error of the rear rolling radius.
    pub rear_radius_error: f64,
    /// Load sensitivity rho of the rolling radius.
    pub radius_load_sensitivity: f64,
    /// Slip stiffness of the front axle over that of the rear, less one.
    pub stiffness_difference: f64,
    /// Exponent p of a slip stiffness that falls with the load, (F_z/F_0)^-p.
    pub stiffness_exponent: f64,
    /// Slip stiffness in braking over that in driving, less one.
    pub braking_stiffness: f64,
    /// Rolling resistance of every other stretch of `STRETCH` beyond that of the rest.
    pub rough_rolling: f64,
    /// Whether the centre drive is locked, so that both axles turn at the same speed.
    pub locked_drive: bool,
    /// Distance of the steering hinge from the middle of the wheelbase, in wheelbases, forward positive.
    pub hinge: f64,
}

impl Machine {
    /// The machine of tier A: Table 1 of the paper (with its mass read as tonnes), and chosen values where it has none.
    pub const NOMINAL: Self = Self {
        mass: 4700.0,
        cg_height: 0.90,
        cg_ratio: 0.45,
        slip_stiffness: 19.0,
        friction: 0.8,
        rolling_resistance: 0.020,
        relaxation_length: 0.10,
        carcass_time: 2e-3,
        tyre_stiffness: 7.0e5,
        tyre_damping: 1.2e4,
        pitch_inertia: 4500.0,
        wheel_radius: 0.55,
        axle_inertia: 3.33,
        wheelbase: 2.30,
        bucket_reach: 1.70,
        gear_ratio: 20.0,
        front_radius_error: 0.0,
        rear_radius_error: 0.0,
        radius_load_sensitivity: 0.0,
        stiffness_difference: 0.0,
        stiffness_exponent: 0.0,
        braking_stiffness: 0.0,
        rough_rolling: 0.0,
        locked_drive: false,
        hinge: 0.0,
    };
}

/// Inputs of the machine, and its mass at present.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    /// Front axle torque at the wheel [N m].
    pub front_torque: f64,
    /// Rear axle torque at the wheel [N m].
    pub rear_torque: f64,
    /// Torque of the friction brakes on the front axle, forward positive [N m].
    pub front_brake: f64,
    /// Torque of the friction brakes on the rear axle, forward positive [N m].
    pub rear_brake: f64,
    /// Speed of the front axle: this gain times the speed of the rear body,
    pub bend_gain: f64,
    /// plus this offset [m/s]; 1 and 0 for a machine that drives straight.
    pub bend_offset: f64,
    /// Horizontal spading force at the bucket tip, at ground height, positive pushing backward \[N\].
    pub spade_force_x: f64,
    /// Vertical spading force, positive pushing down \[N\].
    pub spade_force_z: f64,
    /// Mass with payload \[kg\].
    pub mass: f64,
    /// Height of the centre of gravity with payload \[m\].
    pub cg_height: f64,
    /// Share of the static weight on the front axle, with payload.
    pub cg_ratio: f64,
}

impl Inputs {
    fn between(a: &Self, b: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        Self {
            front_torque: mix(a.front_torque, b.front_torque),
            rear_torque: mix(a.rear_torque, b.rear_torque),
            front_brake: mix(a.front_brake, b.front_brake),
            rear_brake: mix(a.rear_brake, b.rear_brake),
            bend_gain: mix(a.bend_gain, b.bend_gain),
            bend_offset: mix(a.bend_offset, b.bend_offset),
            spade_force_x: mix(a.spade_force_x, b.spade_force_x),
            spade_force_z: mix(a.spade_force_z, b.spade_force_z),
            mass: mix(a.mass, b.mass),
            cg_height: mix(a.cg_height, b.cg_height),
            cg_ratio: mix(a.cg_ratio, b.cg_ratio),
        }
    }
}

/// v, omega_f, omega_r, s_f, s_r, z, z', p, p', x.
pub type State = [f64; 10];

/// Motion and forces at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Derivative of the state.
    pub rate: State,
    /// Road slope at the centre of gravity \[rad\].
    pub slope: f64,
    /// Normal loads of the front and rear axle \[N\].
    pub loads: [f64; 2],
    /// Longitudinal tyre forces of the front and rear axle \[N\].
    pub forces: [f64; 2],
}

/// A machine on a road.
#[derive(Clone, Debug)]
pub struct Plant {
    vehicle: Vehicle,
    road: Road,
    /// Time of the state [s].
    time: f64,
    state: State,
    /// Inputs at the beginning and at the end of interval number `interval` of the input table.
    table: [Inputs; 2],
    interval: usize,
    longest_step: f64,
}

impl Plant {
    /// The machine at rest on its tyres, or rolling at `speed` [m/s], in equilibrium on level ground.
    pub fn new(
        machine: Machine,
        road: Road,
        speed: f64,
        inputs: &mut impl FnMut(f64, &State) -> Inputs,
    ) -> Self {
        let mut state = State::default();
        let start = inputs(0.0, &state);
        let weight = start.mass * GRAVITY;
        let front = weight * start.cg_ratio / machine.tyre_stiffness;
        let rear = weight * (1.0 - start.cg_ratio) / machine.tyre_stiffness;
        let pitch = -(front - rear) / machine.wheelbase;
        let wheel = speed / machine.wheel_radius;
        state[..3].copy_from_slice(&[speed, wheel, wheel]);
        state[5] = -front - pitch * (1.0 - start.cg_ratio) * machine.wheelbase;
        state[7] = pitch;
        let table = [start, inputs(INPUT_INTERVAL, &state)];
        Self {
            vehicle: Vehicle::new(machine),
            road,
            time: 0.0,
            state,
            table,
            interval: 0,
            longest_step: STEP,
        }
    }

    /// The same with another integration step \[s\].
    pub fn with_longest_step(self, longest_step: f64) -> Self {
        Self {
            longest_step,
            ..self
        }
    }

    /// The present state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The present inputs.
    pub fn inputs(&self) -> Inputs {
        self.inputs_at(self.time)
    }

    /// The present motion.
    pub fn motion(&self) -> Motion {
        motion(&self.vehicle, &self.road, &self.state, &self.inputs())
    }

    /// Integrates to `time` \[s\]. `inputs` returns the inputs at a time, and is called in the order of time.
    pub fn advance(&mut self, time: f64, inputs: &mut impl FnMut(f64, &State) -> Inputs) {
        let start = self.time;
        let steps = ((time - start) / self.longest_step - 1e-6).ceil().max(1.0) as usize;
        let h = (time - start) / steps as f64;
        for k in 0..steps {
            self.step(start + k as f64 * h, h, inputs);
        }
        self.time = time;
        self.look_up(time, inputs);
    }

    fn step(&mut self, t: f64, h: f64, inputs: &mut impl FnMut(f64, &State) -> Inputs) {
        self.look_up(t, inputs);
        let at = [0.0, 0.5, 1.0].map(|share| self.inputs_at(t + share * h));
        let (vehicle, road) = (&self.vehicle, &self.road);
        self.state = rk4::step(self.state, h, |stage, state| {
            let u = match stage {
                Stage::Start => &at[0],
                Stage::Middle => &at[1],
                Stage::End => &at[2],
            };
            motion(vehicle, road, &state, u).rate
        });
    }

    /// Updates the table to the interval that contains time `t`.
    fn look_up(&mut self, t: f64, inputs: &mut impl FnMut(f64, &State) -> Inputs) {
        // By rounding, a time may lie just below a grid point; it belongs to the interval above.
        while t >= (self.interval + 1) as f64 * INPUT_INTERVAL - 1e-9 {
            self.interval += 1;
            let end = (self.interval + 1) as f64 * INPUT_INTERVAL;
            self.table = [self.table[1], inputs(end, &self.state)];
        }
    }

    fn inputs_at(&self, t: f64) -> Inputs {
        let share = t / INPUT_INTERVAL - self.interval as f64;
        Inputs::between(&self.table[0], &self.table[1], share)
    }
}

/// The equations of motion.
#[inline]
fn motion(vehicle: &Vehicle, road: &Road, state: &State, u: &Inputs) -> Motion {
    let machine = &vehicle.machine;
    let &[v, wheel_f, wheel_r, slip_f, slip_r, z, z_rate, p, p_rate, x] = state;
    let rear_arm = u.cg_ratio * machine.wheelbase;
    let front_arm = machine.wheelbase - rear_arm;
    let slope = road.slope(x);
    let (sin, cos) = sin_cos(slope);
    let load = |arm: f64| {
        let [height, derivative] = road.profile(x + arm);
        let compression = height - (z + p * arm);
        let compression_rate = v * derivative - (z_rate + p_rate * arm);
        let force = machine.tyre_stiffness * compression + machine.tyre_damping * compression_rate;
        if compression > 0.0 {
            force.max(0.0)
        } else {
            0.0
        }
    };
    let loads = [load(front_arm), load(-rear_arm)];
    let per_mass = 1.0 / u.mass;
    let per_axle_weight = 2.0 / (machine.mass * GRAVITY);
    let front = axle(
        vehicle,
        v * u.bend_gain + u.bend_offset,
        wheel_f,
        slip_f,
        [loads[0], loads[0] * per_axle_weight],
        [
            machine.front_radius_error,
            vehicle.stiffness_per_friction[0],
        ],
    );
    let rear = axle(
        vehicle,
        v,
        wheel_r,
        slip_r,
        [loads[1], loads[1] * per_axle_weight],
        [machine.rear_radius_error, vehicle.stiffness_per_friction[1]],
    );
    let mut spin = [
        u.front_torque + u.front_brake - front.radius * front.force,
        u.rear_torque + u.rear_brake - rear.radius * rear.force,
    ];
    if machine.locked_drive {
        spin = [0.5 * (spin[0] + spin[1]); 2];
    }
    let normal = loads[0] + loads[1];
    let soft = machine.rough_rolling != 0.0 && (x / STRETCH).floor().rem_euclid(2.0) != 0.0;
    let resistance = machine.rolling_resistance + if soft { machine.rough_rolling } else { 0.0 };
    let rolling = resistance * normal * tanh(v * (1.0 / ROLLING_FADE));
    let traction = front.force + rear.force - rolling;
    let pitch_moment = loads[0] * front_arm - loads[1] * rear_arm + u.cg_height * traction
        - u.spade_force_z * (front_arm + machine.bucket_reach)
        - u.spade_force_x * u.cg_height;
    Motion {
        rate: [
            (traction - u.spade_force_x) * per_mass - GRAVITY * sin,
            spin[0] * vehicle.per_axle_inertia,
            spin[1] * vehicle.per_axle_inertia,
            front.slip_rate,
            rear.slip_rate,
            z_rate,
            (normal - u.spade_force_z) * per_mass - GRAVITY * cos,
            p_rate,
            pitch_moment * vehicle.per_pitch_inertia,
            v,
        ],
        slope,
        loads,
        forces: [front.force, rear.force],
    }
}

/// A machine and the reciprocals that the equations of motion need; divisions would be a third of their cost.
#[derive(Clone, Copy, Debug)]
struct Vehicle {
    machine: Machine,
    per_relaxation_length: f64,
    /// Front and rear.
    stiffness_per_friction: [f64; 2],
    per_axle_inertia: f64,
    per_pitch_inertia: f64,
}

impl Vehicle {
    fn new(machine: Machine) -> Self {
        Self {
            machine,
            per_relaxation_length: 1.0 / machine.relaxation_length,
            stiffness_per_friction: {
                let gain = (1.0 + machine.stiffness_difference).sqrt();
                let mean = machine.slip_stiffness / machine.friction;
                [mean * gain, mean / gain]
            },
            per_axle_inertia: 1.0 / machine.axle_inertia,
            per_pitch_inertia: 1.0 / machine.pitch_inertia,
        }
    }
}

struct Axle {
    radius: f64,
    slip_rate: f64,
    force: f64,
}

/// One axle under a load [N], also relative to half the weight of the empty machine, to which its tyre data refer.
#[inline]
fn axle(
    vehicle: &Vehicle,
    v: f64,
    wheel: f64,
    slip: f64,
    [load, relative]: [f64; 2],
    [error, mut stiffness]: [f64; 2],
) -> Axle {
    let machine = &vehicle.machine;
    let radius = machine.wheel_radius
        * (1.0 + error)
        * (1.0 - machine.radius_load_sensitivity * (relative - 1.0));
    let rim = radius * wheel;
    let speed = v.abs().max(rim.abs()).max(SMALLEST_SLIP_SPEED);
    let slip_rate = ((rim - v) - speed * slip) * vehicle.per_relaxation_length;
    let carcass_slip = slip + machine.carcass_time * slip_rate;
    if machine.stiffness_exponent != 0.0 {
        stiffness *= relative.max(0.05).powf(-machine.stiffness_exponent);
    }
    if machine.braking_stiffness != 0.0 && carcass_slip * v < 0.0 {
        stiffness *= 1.0 + machine.braking_stiffness;
    }
    let force = machine.friction * tanh(stiffness * carcass_slip) * load;
    Axle {
        radius,
        slip_rate,
        force,
    }
}

/// The hyperbolic tangent. The library's would take half of the plant's time. Below 0.5 the [7/6] Pade approximant is exact to
/// rounding, and beyond 20 the result is 1.
#[inline]
fn tanh(x: f64) -> f64 {
    let s = x * x;
    if s < 0.25 {
        let numerator = 135_135.0 + s * (17_325.0 + s * (378.0 + s));
        let denominator = 135_135.0 + s * (62_370.0 + s * (3_150.0 + s * 28.0));
        x * numerator / denominator
    } else if s > 400.0 {
        x.signum()
    } else {
        x.tanh()
    }
}

/// Sine and cosine; the Taylor series is exact to rounding on roads.
#[inline]
fn sin_cos(x: f64) -> (f64, f64) {
    let s = x * x;
    if s > 0.0225 {
        return x.sin_cos();
    }
    let sin = 1.0
        - s * (1.0 / 6.0)
            * (1.0 - s * (1.0 / 20.0) * (1.0 - s * (1.0 / 42.0) * (1.0 - s * (1.0 / 72.0))));
    let cos = 1.0
        - s * (1.0 / 2.0)
            * (1.0
                - s * (1.0 / 12.0)
                    * (1.0
                        - s * (1.0 / 30.0) * (1.0 - s * (1.0 / 56.0) * (1.0 - s * (1.0 / 90.0)))));
    (x * sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fast_sine_and_cosine_are_the_sine_and_cosine() {
        for k in -200..200 {
            let x = f64::from(k) * 1e-3 + 1e-5;
            let (sin, cos) = sin_cos(x);
            assert!(
                (sin - x.sin()).abs() <= 4e-16 * x.abs() && (cos - x.cos()).abs() <= 4e-16,
                "{x}"
            );
        }
    }

    #[test]
    fn the_fast_tanh_is_the_tanh() {
        for k in -3000..3000 {
            let x = f64::from(k) * 0.01 + 1e-4;
            assert!((tanh(x) - x.tanh()).abs() <= 4e-16 * x.tanh().abs(), "{x}");
        }
    }
}
