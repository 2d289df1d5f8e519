//! A machine with random effects, of random severity up to the largest of the cases.

use super::cases::CASES;
use super::effects::{Effects, PayloadReport};
use crate::noise::Noise;

/// Probability of each effect.
const EACH: f64 = 0.3;
/// Probability of a locked centre drive, of a scale error of the speed, and of a load reported by its mass only, or not at all.
const SELDOM: f64 = 0.1;
/// Noise channel from which the effects are drawn.
const CHANNEL: u64 = 0x6566;

impl Effects {
    /// The effects of the machine with this seed.
    pub fn by_chance(seed: u64) -> Self {
        let mut draw = Draw(Noise::channel(seed, CHANNEL));
        let (speed_delay, brakes) = (draw.some(|e| e.speed_delay), draw.some(|e| e.brakes));
        let (steering, hinge) = (draw.some(|e| e.steering), draw.some(|e| e.hinge));
        let slope_follows = draw.some(|e| e.slope_follows);
        let slope_lag = draw.some(|e| e.slope_lag);
        let gear_delay = draw.some(|e| e.gear_delay);
        let stiffness_exponent = draw.some(|e| e.stiffness_exponent);
        let stiffness_difference = draw.either(|e| e.stiffness_difference);
        let radius_sensitivity = draw.either(|e| e.radius_sensitivity);
        let braking_stiffness = draw.either(|e| e.braking_stiffness);
        let torque_gain = draw.either(|e| e.torque_gain);
        let slope_bias = draw.either(|e| e.slope_bias);
        let mass_error = draw.either(|e| e.mass_error);
        let radius_error = draw.either(|e| e.radius_error);
        let roughness = draw.some(|e| e.roughness);
        let rolling_resistance = draw.some(|e| e.rolling_resistance);
        let torque_delay = draw.some(|e| e.torque_delay);
        let speed_period = draw.some(|e| e.speed_period);
        let jitter = draw.some(|e| e.jitter);
        let Draw(mut noise) = draw;
        let [brakes_reported, steering_reported] = [(); 2].map(|()| !noise.chance(EACH));
        let locked_drive = noise.chance(SELDOM);
        let payload_reported = if noise.chance(SELDOM) {
            PayloadReport::Nothing
        } else if noise.chance(SELDOM) {
            PayloadReport::Mass
        } else {
            PayloadReport::All
        };
        let reverses = noise.chance(EACH);
        let mut draw = Draw(noise);
        let rear_torque_gain = draw.either(|e| e.rear_torque_gain);
        Self {
            spins: false,
            speed_delay,
            brakes,
            brakes_reported,
            steering,
            steering_reported,
            hinge,
            locked_drive,
            slope_follows,
            slope_lag,
            gear_delay,
            stiffness_difference,
            stiffness_exponent,
            radius_sensitivity,
            payload_reported,
            braking_stiffness,
            roughness,
            rolling_resistance,
            reverses,
            rear_torque_gain,
            speed_gain: draw.broken(|e| e.speed_gain),
            front_speed_gain: draw.broken(|e| e.front_speed_gain),
            torque_gain,
            torque_delay,
            slope_bias,
            acceleration_offset: 0.0,
            speed_period,
            jitter,
            mass_error,
            radius_error,
        }
    }
}

/// Draws severities.
struct Draw(Noise);

impl Draw {
    /// Severity of an effect that is present or absent.
    fn some(&mut self, of: fn(&Effects) -> f64) -> f64 {
        let largest = CASES.iter().map(|c| of(&c.2)).fold(0.0, f64::max);
        let severity = self.0.uniform(0.0, largest);
        if self.0.chance(EACH) { severity } else { 0.0 }
    }

    /// Severity of a rare fault, of either sign.
    fn broken(&mut self, of: fn(&Effects) -> f64) -> f64 {
        let largest = CASES.iter().map(|c| of(&c.2).abs()).fold(0.0, f64::max);
        let gain = self.0.uniform(-largest, largest);
        if self.0.chance(SELDOM) { gain } else { 0.0 }
    }

    /// Severity of an effect of either sign.
    fn either(&mut self, of: fn(&Effects) -> f64) -> f64 {
        self.some(of) - self.some(of)
    }
}
