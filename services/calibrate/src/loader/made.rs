//! Recordings of a machine that follows the model exactly, for tests.

use estimation::loader::Sample;

use super::GRAVITY;
use super::guess::{Guess, Scatter};
use super::wheels::{Acting, load, radius, slipping};

pub fn guess() -> Guess {
    Guess {
        mass: 4700.0,
        empty_mass: 4700.0,
        ratio: 0.45,
        height: 0.9,
        radius: 0.55,
        radius_errors: [0.002, -0.001],
        load_sensitivity: 0.01,
        stiffness: 19.0,
        stiffness_ratio: 1.05,
        load_exponent: 0.1,
        friction: 0.8,
        brush: 0.0,
        load_variance: 0.0225,
        torque_gains: [1.01, 0.99],
        rolling_resistance: 0.02,
        slope_bias: 0.005,
        acceleration_offset: 0.0,
        slope_delay: 0.2,
        slope_sensitivity: 0.3,
        squat: 0.0,
        speed_delay: 0.03,
        torque_delay: 0.01,
        relaxation_length: 0.1,
        axle_inertia: 3.3,
        wheelbase: 2.3,
        scatter: Scatter {
            wheels: 5e-4,
            speed: 4e-3,
            force: 0.01,
            motion: 5e-3,
            path: 1e-3,
        },
    }
}

/// Uniform noise of variance 1 from a linear congruence.
pub fn noise(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    ((*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
}

/// A machine with varying speed over waves of the ground for 60 s, as modelled; `split` shifts the torque between the axles.
pub fn samples(g: &Guess, split: f64, seed: u64) -> Vec<Sample> {
    driven(g, split, seed, None, 1.0)
}

/// The same in reverse, starting from the same mark.
pub fn reversed(g: &Guess, split: f64, seed: u64) -> Vec<Sample> {
    driven(g, split, seed, None, -1.0)
}

/// The same, or `turned` round at this distance [m], and driving back.
pub fn turned(g: &Guess, split: f64, seed: u64, turned: Option<f64>) -> Vec<Sample> {
    driven(g, split, seed, turned, 1.0)
}

fn driven(g: &Guess, split: f64, seed: u64, turned: Option<f64>, gear: f64) -> Vec<Sample> {
    let (mut state, mut shown) = (seed, 0.0);
    let hills = |x: f64| 0.01 + 0.012 * (0.43 * x).sin() + 0.012 * (0.27 * x + 1.0).sin();
    let rolled = |t: f64| {
        gear * (3.0 * t + 1.2 / 0.9 * (1.0 - (0.9 * t).cos()) + 0.4 / 2.1 * (1.0 - (2.1 * t).cos()))
    };
    let ground = |t: f64| turned.map_or_else(|| hills(rolled(t)), |at| -hills(at - rolled(t)));
    let speed = |t: f64| gear * (3.0 + 1.2 * (0.9 * t).sin() + 0.4 * (2.1 * t).sin());
    let rate = |t: f64| gear * (1.08 * (0.9 * t).cos() + 0.84 * (2.1 * t).cos());
    let force = |t: f64| rate(t) + GRAVITY * ground(t).sin();
    let torque = |t: f64| {
        let share = [0.5 + split * (0.7 * t).sin(), 0.5 - split * (0.7 * t).sin()];
        let spin = 2.0 * g.axle_inertia / (g.radius * g.radius);
        let pull = (force(t) + gear * g.rolling_resistance * GRAVITY) * g.mass + spin * rate(t);
        let radii = [0, 1].map(|i| radius(g, i, load(g, i, force(t))));
        [0, 1].map(|i| share[i] * pull * radii[i])
    };
    (0..3000)
        .map(|k| {
            let t = f64::from(k) * 0.02;
            let acting = Acting {
                torque: torque(t),
                torque_rate: [0, 1].map(|i| (torque(t + 0.01)[i] - torque(t - 0.01)[i]) / 0.02),
                along: force(t) - rate(t),
            };
            let wheels = [0, 1].map(|i| {
                let axle = slipping(g, i, &acting, gear, force(t));
                (speed(t) * axle.faster + axle.wound) / axle.radius
            });
            let late = torque(t - g.torque_delay);
            let squat = g.squat * force(t);
            let seen = ground(t) + (g.slope_sensitivity * rate(t) + squat) / GRAVITY;
            let weight = 0.02 / (0.02 + g.slope_delay);
            shown += weight * (seen + g.slope_bias - shown);
            Sample {
                time: t,
                speed: Some(speed(t - g.speed_delay) + 0.02 * noise(&mut state)),
                front_wheel_speed: Some(wheels[0] + 0.002 * noise(&mut state)),
                rear_wheel_speed: Some(wheels[1] + 0.002 * noise(&mut state)),
                front_torque: Some(g.torque_gains[0] * late[0]),
                rear_torque: Some(g.torque_gains[1] * late[1]),
                slope: Some(shown + 5e-4 * noise(&mut state)),
                acceleration: Some(
                    force(t) + squat + g.acceleration_offset + 0.05 * noise(&mut state),
                ),
                ..Sample::default()
            }
        })
        .collect()
}
