//! A machine with random effects of random severity.

use super::effects::Effects;
use crate::noise::Noise;

/// Probability of each effect.
const EACH: f64 = 0.2;
/// Noise channel from which the effects are drawn.
const CHANNEL: u64 = 0x6566;

impl Effects {
    /// The effects of the machine with this seed.
    pub fn by_chance(seed: u64) -> Self {
        let noise = &mut Noise::channel(seed, CHANNEL);
        let none = Self::default();
        let mut some = |usual: f64, from: f64, to: f64| {
            let severity = noise.uniform(from, to);
            if noise.chance(EACH) { severity } else { usual }
        };
        Self {
            slope: some(none.slope, 0.0, 8f64.to_radians()),
            efficiency: some(none.efficiency, 0.92, 1.0),
            friction: some(none.friction, 0.6, 2.0),
            stribeck: some(none.stribeck, 1.0, 1.5),
            overturning: some(none.overturning, 0.0, 0.3),
            damping: some(none.damping, 0.7, 1.5),
            torque_gain: some(none.torque_gain, 0.93, 1.07),
            torque_offset: some(none.torque_offset, -0.02, 0.02),
            torque_lag: some(none.torque_lag, 0.0, 0.05),
            torque_delay: some(none.torque_delay, 0.0, 0.03),
            torque_period: some(none.torque_period, 0.02, 0.05),
            gyro_delay: some(none.gyro_delay, 0.0, 0.03),
            gyro_lag: some(none.gyro_lag, 0.0, 0.02),
            gyro_quantum: some(none.gyro_quantum, 0.0, 0.005),
            gyro_bias: some(none.gyro_bias, -0.005, 0.005),
            gyro_drift: some(none.gyro_drift, -0.003, 0.003),
            boom_mode: some(none.boom_mode, 2.5, 6.0),
            pendulum: some(none.pendulum, 0.0, 0.3),
            pendulum_length: some(none.pendulum_length, 0.4, 2.0),
            spill: some(none.spill, 0.0, 0.1),
            mass_error: some(none.mass_error, 0.0, 0.03),
            length_error: some(none.length_error, 0.0, 0.015),
            angle_error: some(none.angle_error, 0.0, 1f64.to_radians()),
            jitter: some(none.jitter, 0.0, 0.01),
            relief: some(none.relief, 0.0, 0.2),
            sticks: None,
            dumps_swinging: noise.chance(EACH),
            inclinometer: noise.chance(2.0 * EACH),
            seals: if noise.chance(EACH) {
                noise.uniform(0.5, 3.0)
            } else {
                none.seals
            },
            pressure_zero: if noise.chance(EACH) {
                noise.uniform(0.0, 3.0)
            } else {
                none.pressure_zero
            },
            pressure_quantum: if noise.chance(EACH) {
                200e3
            } else {
                none.pressure_quantum
            },
        }
    }
}
