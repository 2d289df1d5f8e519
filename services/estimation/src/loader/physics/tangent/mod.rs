//! The implicit step of [`super::wheel_dynamics`] with its derivatives in closed form: the model's tangent at one state.
//!
//! Each quantity of an axle depends on few others, so its derivatives are a handful of numbers. Only the acceleration and the
//! speeds of the first pass depend on everything, and are rows. This takes a fifth of the work of dual numbers, and equals them but
//! for rounding (a test compares). The model's own functions compute the values.
//!
//! | file | idea |
//! |---|---|
//! | `stage` | intermediate result of the step |
//! | `axle` | both axles: load, grip, and their derivatives |
//! | `pass` | speeds under the loads and grips of the stage before |
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | N_i | `load` | axle load, and its derivatives by h, lam, b, a |
//! | c_i | `conductance` | force per slip speed, K q N^-p phi N/den |
//! | phi, eta | - | u/atanh u of the tyre that saturates, and its derivative by ln u over phi |
//! | den | - | max(\|v\|, \|r w\|, v_min) |
//! | d_i | `denominator` | 1 + dt r^2 c/I |

use super::wheel_dynamics::{Inputs, Motion, Parameters, ROLLING_WIDTH, Road, WheelDynamics};
use crate::ekf::add;
use crate::loader::layout::{
    CG_HEIGHT as H, CG_RATIO as LAM, FRONT_WHEEL, REAR_WHEEL, SLIP_STIFFNESS as K, SPEED as V,
};
use crate::math::tanh;
use crate::pair::Pair;
use stage::Stage;

mod axle;
mod pass;
mod stage;

/// The wheel speeds.
const W: [usize; 2] = [FRONT_WHEEL, REAR_WHEEL];

/// Both wheel speeds of a motion.
#[inline(always)]
fn wheels(motion: &[f64; 3]) -> Pair {
    Pair(W.map(|i| motion[i]))
}

/// The motion after a step, and its derivatives by the state before it.
#[derive(Clone, Copy, Debug)]
pub(in crate::loader) struct Tangent<const N: usize> {
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

/// Resistance, and its derivatives by speed and slope bias; that by the spade force is 1.
struct Drag {
    value: f64,
    by_speed: f64,
    by_bias: f64,
}

/// Values common to all passes.
struct Step<'a> {
    machine: &'a WheelDynamics,
    old: [f64; 3],
    p: &'a Parameters<f64>,
    u: &'a Inputs,
    /// Of both axles.
    torques: Pair,
    road: &'a Road<f64>,
    dt: f64,
    drag: Drag,
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
            torques: Pair([u.front_torque, u.rear_torque]),
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
        let weight = self.mass * self.gravity;
        let rolling = (road.cosine * weight + u.spade_force_z) * self.rolling_resistance;
        Drag {
            value: self.faded_drag(fade, u, road) + p.spade_force_x + u.spade_force_x,
            by_speed: rolling * (1.0 - fade * fade) / ROLLING_WIDTH,
            by_bias: weight * (self.rolling_resistance * fade * road.sine - road.cosine),
        }
    }
}

/// Adds to the derivative by a parameter, where it is a state.
#[inline(always)]
fn at<const N: usize>(row: &mut [f64; N], place: Option<usize>, value: f64) {
    if let Some(place) = place {
        row[place] += value;
    }
}

#[cfg(test)]
#[allow(clippy::needless_range_loop)]
mod tests {
    use super::*;
    use crate::dual::Dual;
    use crate::loader::LoadTransfer;
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
            gravity: 9.81,
            mass: 4700.0,
            empty_mass: 4300.0,
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
        check::<12>(4);
    }
}
