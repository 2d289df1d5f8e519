//! A machine that nobody listed: each effect by chance, of a severity by chance up to the largest that the cases have.

use super::cases::CASES;
use super::effects::{Effects, PayloadTold};
use crate::noise::Noise;

/// Probability of each effect.
const EACH: f64 = 0.3;
/// Probability of a locked centre drive, and that a load is told by its mass alone, or not at all.
const SELDOM: f64 = 0.1;
/// Of the channels of a seed this one draws the effects.
const CHANNEL: u64 = 0x6566;

impl Effects {
    /// The effects of the machine with this seed.
    pub fn by_chance(seed: u64) -> Self {
        let noise = &mut Noise::channel(seed, CHANNEL);
        let largest = |of: fn(&Self) -> f64| CASES.iter().map(|c| of(&c.2)).fold(0.0, f64::max);
        let mut some = |of: fn(&Self) -> f64| {
            let severity = noise.uniform(0.0, largest(of));
            if noise.chance(EACH) { severity } else { 0.0 }
        };
        let (speed_delay, brakes) = (some(|e| e.speed_delay), some(|e| e.brakes));
        let (steering, hinge) = (some(|e| e.steering), some(|e| e.hinge));
        let (slope_follows, slope_lag) = (some(|e| e.slope_follows), some(|e| e.slope_lag));
        let gear_delay = some(|e| e.gear_delay);
        let stiffness_exponent = some(|e| e.stiffness_exponent);
        let mut either = |of: fn(&Self) -> f64| some(of) - some(of);
        let stiffness_difference = either(|e| e.stiffness_difference);
        let radius_sensitivity = either(|e| e.radius_sensitivity);
        let braking_stiffness = either(|e| e.braking_stiffness);
        let (torque_gain, slope_bias) = (either(|e| e.torque_gain), either(|e| e.slope_bias));
        let (mass_error, radius_error) = (either(|e| e.mass_error), either(|e| e.radius_error));
        let mut some = |of: fn(&Self) -> f64| {
            let severity = noise.uniform(0.0, largest(of));
            if noise.chance(EACH) { severity } else { 0.0 }
        };
        let (roughness, rolling_resistance) =
            (some(|e| e.roughness), some(|e| e.rolling_resistance));
        let (torque_delay, speed_period) = (some(|e| e.torque_delay), some(|e| e.speed_period));
        let jitter = some(|e| e.jitter);
        Self {
            speed_delay,
            brakes,
            brakes_told: !noise.chance(EACH),
            steering,
            steering_told: !noise.chance(EACH),
            hinge,
            locked_drive: noise.chance(SELDOM),
            slope_follows,
            slope_lag,
            gear_delay,
            stiffness_difference,
            stiffness_exponent,
            radius_sensitivity,
            payload_told: if noise.chance(SELDOM) {
                PayloadTold::Nothing
            } else if noise.chance(SELDOM) {
                PayloadTold::Mass
            } else {
                PayloadTold::All
            },
            braking_stiffness,
            roughness,
            rolling_resistance,
            reverses: noise.chance(EACH),
            torque_gain,
            torque_delay,
            slope_bias,
            speed_period,
            jitter,
            mass_error,
            radius_error,
        }
    }
}
