//! Measurements of the machine, and its description.

use super::super::front::{Front, Pose, cylinders};
use super::super::geometry::Geometry;
use super::super::row::{Row, Truth};
use super::duty::Duty;
use super::effects::Effects;
use super::machine::{Machine, STEP};
use super::size::Size;
use crate::cylinder::{Cylinder, Gauges};
use crate::noise::Noise;

/// Integration steps per sample: 100 Hz.
const STEPS: u32 = 10;
/// Longest delay of a signal [integration steps].
const MEMORY: usize = 512;
/// Streams of noise of an empty and of a loaded trial.
const EMPTY: u64 = 300;
const LOADED: u64 = 320;
/// Noise of the joint angles [rad], of the inclinometer [rad], of the swing encoder [rad].
const ANGLE_NOISE: f64 = 0.001;
const INCLINOMETER_NOISE: f64 = 0.003;
const ENCODER_NOISE: f64 = 0.001;

/// A delayed signal: pure delay, then a first-order lag.
#[derive(Clone, Debug)]
struct Late {
    past: [f64; MEMORY],
    next: usize,
    delay: usize,
    share: f64,
    value: f64,
}

impl Late {
    fn new(delay: f64, lag: f64) -> Self {
        Self {
            past: [0.0; MEMORY],
            next: 0,
            delay: ((delay / STEP).round() as usize).min(MEMORY - 1),
            share: if lag > 0.0 {
                1.0 - (-STEP / lag).exp()
            } else {
                1.0
            },
            value: 0.0,
        }
    }

    fn push(&mut self, value: f64) {
        self.past[self.next % MEMORY] = value;
        let then = self.past[(self.next + MEMORY - self.delay) % MEMORY];
        self.value += self.share * (then - self.value);
        self.next += 1;
    }
}

/// A working machine, sampled by its sensors at 100 Hz, endless.
#[derive(Clone, Debug)]
pub struct Work {
    machine: Machine,
    effects: Effects,
    /// The described geometry.
    nominal: Geometry,
    front: Option<Front>,
    noise: [Noise; 10],
    angle_errors: [f64; 3],
    torque: Late,
    gyro: Late,
    sample: u64,
    stamp: f64,
    held_torque: f64,
    held_since: f64,
}

impl Work {
    /// A machine of a size with effects; the seed determines loads, swings, direction of the slope, signs of the errors and all
    /// noise.
    pub fn new(size: Size, effects: Effects, seed: u64) -> Self {
        let duty = Duty::new(&size, &effects, seed);
        Self::doing(size, effects, duty, seed)
    }

    /// The machine of the same seed in a calibration: swings, then slow full lifts, with a constant payload \[kg\]. Its sensors
    /// have other noise.
    pub fn trial(size: Size, effects: Effects, seed: u64, payload: f64) -> Self {
        let duty = Duty::trial(&size, &effects, seed, payload);
        let streams = if payload > 0.0 { LOADED } else { EMPTY };
        Self {
            noise: std::array::from_fn(|channel| Noise::channel(seed, streams + channel as u64)),
            ..Self::doing(size, effects, duty, seed)
        }
    }

    fn doing(size: Size, effects: Effects, duty: Duty, seed: u64) -> Self {
        let mut signs = Noise::channel(seed, 102);
        Self {
            front: None,
            machine: Machine::new(size, effects, duty, seed),
            nominal: nominal(&size.geometry, &effects, &mut signs),
            angle_errors: std::array::from_fn(|_| effects.angle_error * sign(&mut signs)),
            noise: std::array::from_fn(|channel| Noise::channel(seed, channel as u64)),
            torque: Late::new(effects.torque_delay, effects.torque_lag),
            gyro: Late::new(effects.gyro_delay, effects.gyro_lag),
            effects,
            sample: 0,
            stamp: 0.0,
            held_torque: 0.0,
            held_since: f64::NEG_INFINITY,
        }
    }

    /// The same machine with pressure sensors at the cylinders of boom and arm.
    #[must_use]
    pub fn with_gauges(mut self, seed: u64) -> Self {
        let geometry = self.machine.size.geometry;
        let e = &self.effects;
        let usual = Gauges::default();
        let gauges = Gauges {
            zero: e.pressure_zero * usual.zero,
            quantum: e.pressure_quantum,
            ..usual
        };
        let real = cylinders(&geometry).map(|c| Cylinder {
            friction: e.seals * c.friction,
            ..c
        });
        self.front = Some(Front::new(geometry, real, gauges, seed));
        self
    }

    /// The machine's size.
    pub fn size(&self) -> &Size {
        &self.machine.size
    }

    /// Described dimensions and masses.
    pub fn nominal(&self) -> &Geometry {
        &self.nominal
    }

    fn normal(&mut self, channel: usize) -> f64 {
        self.noise[channel].normal()
    }

    fn gyro_value(&mut self, time: f64) -> f64 {
        let e = self.effects;
        let bias = e.gyro_bias + e.gyro_drift * time / 60.0;
        let value = self.gyro.value + bias + self.machine.size.gyro_noise * self.normal(0);
        if e.gyro_quantum > 0.0 {
            (value / e.gyro_quantum).round() * e.gyro_quantum
        } else {
            value
        }
    }

    fn torque_value(&mut self, time: f64) -> f64 {
        let e = self.effects;
        if time - self.held_since >= e.torque_period - 1e-9 {
            let offset = e.torque_offset * self.machine.size.torque;
            let noise = self.machine.size.torque_noise * self.normal(1);
            self.held_torque = e.torque_gain * self.torque.value + offset + noise;
            self.held_since = time;
        }
        self.held_torque
    }

    fn pressures(&mut self, time: f64) -> [Option<f64>; 4] {
        let m = &self.machine;
        let pose = Pose {
            angles: m.posture,
            rates: m.joint_rates,
            accelerations: m.joint_accelerations,
            spin: m.bodies[0].velocity,
            inclination: m.inclination(),
            payload: m.duty.payload,
            contact: m.duty.contact(),
        };
        let front = self.front.as_mut();
        front.map_or([None; 4], |front| front.show(time, &pose).map(Some))
    }

    fn measure(&mut self) -> Row {
        let time = self.sample as f64 * f64::from(STEPS) * STEP;
        let late = self.effects.jitter * self.normal(2);
        self.stamp = if self.sample == 0 {
            0.0
        } else {
            (time + late).max(self.stamp + 1e-4)
        };
        let pressures = self.pressures(time);
        let m = &self.machine;
        let (bodies, posture, inclination) = (m.bodies, m.posture, m.inclination());
        let truth = Truth {
            inertia: m.inertia,
            damping: m.damping(),
            friction: m.friction(),
            torque: m.torque,
            velocity: bodies[0].velocity,
            acceleration: m.acceleration,
            payload: m.duty.payload,
            digs: m.duty.contact() > 0.0,
        };
        let errors = self.angle_errors;
        let joints: [f64; 3] =
            std::array::from_fn(|i| posture[i] + errors[i] + ANGLE_NOISE * self.normal(3 + i));
        let inclinometer = self.effects.inclinometer;
        let tilt = inclination
            .map(|angle| inclinometer.then(|| angle + INCLINOMETER_NOISE * self.noise[6].normal()));
        let encoder = bodies[0].angle + ENCODER_NOISE * self.normal(7);
        Row {
            time: self.stamp,
            swing_velocity: Some(self.gyro_value(time)),
            swing_angle: inclinometer.then_some(encoder),
            swing_torque: Some(self.torque_value(time)),
            posture: joints.map(Some),
            inclination: tilt,
            pressures,
            truth,
        }
    }
}

impl Iterator for Work {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        let row = self.measure();
        self.sample += 1;
        for _ in 0..STEPS {
            self.machine.advance();
            self.torque.push(self.machine.torque);
            self.gyro.push(self.machine.bodies[0].velocity);
        }
        Some(row)
    }
}

fn sign(noise: &mut Noise) -> f64 {
    if noise.chance(0.5) { 1.0 } else { -1.0 }
}

/// The described geometry: each mass and length deviates by its share, with a random sign.
fn nominal(geometry: &Geometry, effects: &Effects, signs: &mut Noise) -> Geometry {
    let mut g = *geometry;
    let mut off = |value: &mut f64, share: f64| *value *= 1.0 + share * sign(signs);
    for mass in [
        &mut g.upper_inertia,
        &mut g.boom.mass,
        &mut g.arm.mass,
        &mut g.attachment.link.mass,
    ] {
        off(mass, effects.mass_error);
    }
    for length in [
        &mut g.boom_length,
        &mut g.arm_length,
        &mut g.boom.centre,
        &mut g.arm.centre,
        &mut g.attachment.link.centre,
        &mut g.attachment.payload_centre,
    ] {
        off(length, effects.length_error);
    }
    g
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(effects: Effects) -> Vec<Row> {
        Work::new(Size::t13(), effects, 3).take(4000).collect()
    }

    #[test]
    fn the_machine_digs_swings_dumps_and_returns() {
        let rows = rows(Effects::default());
        let full = rows.iter().filter(|r| r.truth.payload > 500.0).count();
        let fast = rows.iter().filter(|r| r.truth.velocity > 0.5).count();
        let back = rows.iter().filter(|r| r.truth.velocity < -0.5).count();
        assert!(
            full > 500 && fast > 200 && back > 200,
            "{full} {fast} {back}"
        );
    }

    #[test]
    fn a_trial_swings_both_ways_and_lifts_slowly_with_the_load_that_it_has() {
        let rows: Vec<Row> = Work::trial(Size::t13(), Effects::default(), 3, 700.0)
            .take(18_000)
            .collect();
        assert!(
            rows.iter()
                .all(|r| r.truth.payload == 700.0 && !r.truth.digs)
        );
        let fast = |sign: f64| {
            rows.iter()
                .filter(|r| sign * r.truth.velocity > 0.5)
                .count()
        };
        assert!(
            fast(1.0) > 800 && fast(-1.0) > 800,
            "{} {}",
            fast(1.0),
            fast(-1.0)
        );
        let swings = rows.iter().rposition(|r| r.truth.velocity != 0.0);
        let lifts = &rows[swings.unwrap_or(0) + 1..];
        let boom = |r: &Row| r.posture[0].unwrap_or(0.0);
        let high = lifts.iter().map(boom).fold(0.0, f64::max);
        assert!(lifts.len() > 4400 && high > 0.95, "{} {high}", lifts.len());
    }

    #[test]
    fn momentum_follows_the_torques_on_a_sound_machine() {
        let rows = rows(Effects::default());
        for pair in rows.windows(2) {
            let [a, b] = [pair[0].truth, pair[1].truth];
            if a.velocity.abs() < 0.1
                || b.velocity.abs() < 0.1
                || (a.payload - b.payload).abs() > 1e-9
            {
                continue;
            }
            let gained = (b.inertia * b.velocity - a.inertia * a.velocity) / 0.01;
            let mean = |f: fn(&Truth) -> f64| 0.5 * (f(&a) + f(&b));
            let acted =
                mean(|t| t.torque - t.damping * t.velocity - t.friction * t.velocity.signum());
            assert!((gained - acted).abs() < 400.0, "{gained} {acted}");
        }
    }

    #[test]
    fn every_effect_changes_what_is_measured() {
        let sound = rows(Effects::default());
        for effects in [Effects::good(), Effects::usual(), Effects::worn()] {
            let differs = rows(effects).iter().zip(&sound).any(|(a, b)| {
                (a.swing_velocity.unwrap_or(0.0) - b.swing_velocity.unwrap_or(0.0)).abs() > 0.01
            });
            assert!(differs);
        }
    }
}
