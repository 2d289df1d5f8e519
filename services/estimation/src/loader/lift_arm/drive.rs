//! Specific force along the body, from the speed where there is no accelerometer, and detection of wheels that push against the ground.
//!
//! ```text
//! a = dv/dt + g sin(slope),   R = F/m - a       F: force of the wheels
//! ```
//! R is the resistance: rolling, and the ground where the bucket pushes. The mass is between that of the empty machine and that with a full
//! bucket: a push is a resistance that no load explains. Wheels push in their direction of motion, and brake against it. The model assumes
//! that wheels do not drive against a brake that is not reported.

use crate::GRAVITY;
use crate::loader::sample::Sample;
use crate::loader::settings::Settings;
use crate::math::sin_cos;

/// Time constant of smoothed speed, force and specific force [s].
const SMOOTH: f64 = 0.12;
/// Speed against the force of the wheels beyond which they brake [m/s].
const STANDS: f64 = 0.05;
/// Longest time without a speed [s].
const GAP: f64 = 0.5;
/// Resistance beyond rolling, as a share of the weight, that is a push: a curve or soft soil has half of it.
const PUSHES: f64 = 0.05;

/// State of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Drive {
    /// Force of the wheels over the mass of the empty machine, per torque [m/s^2/(N m)].
    per_torque: f64,
    /// Least resistance of a push, per mass [m/s^2].
    least: f64,
    /// Mass with a full bucket and the equivalent mass of the wheels, over that of the empty machine.
    full: f64,
    /// Mass of the empty machine with the equivalent mass of its wheels [kg], and the share of the machine in it.
    pub rolling: f64,
    rolls: f64,
    /// Time of the last row, and of the last speed [s].
    time: f64,
    told: f64,
    /// Smoothed speed [m/s], and its rate [m/s^2].
    speed: f64,
    rate: f64,
    /// Force over mass of the empty machine, and specific force, smoothed [m/s^2].
    force: f64,
    specific: f64,
    /// Specific force of the last row [m/s^2], and whether an accelerometer measured it.
    pub felt: f64,
    pub measured: bool,
}

impl Drive {
    /// State of a machine at rest; `capacity` of its bucket [kg].
    pub fn new(settings: &Settings, capacity: f64) -> Self {
        let machine = &settings.machine;
        let radius = machine.wheel_radius;
        let wheels = 2.0 * machine.axle_inertia / (radius * radius);
        Self {
            per_torque: 1.0 / (radius * machine.mass),
            least: (machine.rolling_resistance + PUSHES) * GRAVITY,
            full: 1.0 + (capacity + wheels) / machine.mass,
            rolling: machine.mass + wheels,
            rolls: machine.mass / (machine.mass + wheels),
            time: f64::NEG_INFINITY,
            told: f64::NEG_INFINITY,
            speed: 0.0,
            rate: 0.0,
            force: 0.0,
            specific: 0.0,
            felt: 0.0,
            measured: false,
        }
    }

    /// Updates with a row and the accelerometer's value, if any [m/s^2].
    pub fn take(&mut self, sample: &Sample, acceleration: Option<f64>) {
        if let Some(speed) = sample.speed {
            self.follow(speed, sample.time);
        }
        let slope = sample.slope.unwrap_or(0.0);
        self.measured = acceleration.is_some();
        self.felt = acceleration.unwrap_or_else(|| self.rate + GRAVITY * sin_cos(slope).0);
        let torque = |axle: Option<f64>| axle.unwrap_or(0.0);
        let pull = self.per_torque * (torque(sample.front_torque) + torque(sample.rear_torque));
        // Against a reported brake wheels may drive with any force: no push is detected.
        let [pull, felt] = if sample.brake {
            [0.0; 2]
        } else {
            [pull, self.felt]
        };
        // After a gap, or a clock that was set, the new values replace the smoothed ones.
        let dt = sample.time - core::mem::replace(&mut self.time, sample.time);
        let weight = if dt > 0.0 {
            (dt / SMOOTH).min(1.0)
        } else {
            1.0
        };
        self.force += weight * (pull - self.force);
        self.specific += weight * (felt - self.specific);
    }

    /// Updates the smoothed speed, and its rate, which is smoothed twice.
    fn follow(&mut self, speed: f64, time: f64) {
        let since = time - core::mem::replace(&mut self.told, time);
        if !(0.0..GAP).contains(&since) {
            (self.speed, self.rate) = (speed, 0.0);
            return;
        }
        let weight = (since / SMOOTH).min(1.0);
        let away = speed - self.speed;
        self.speed += weight * away;
        self.rate += weight * (away / SMOOTH.max(since) - self.rate);
    }

    /// Specific force, force of the wheels over `rolling` [m/s^2], and speed [m/s].
    pub fn pull(&self) -> [f64; 3] {
        [self.specific, self.force * self.rolls, self.speed]
    }

    /// The wheels push with more force than rolling and accelerating any load need.
    pub fn pushes(&self) -> bool {
        let sign = self.force.signum();
        let along = self.specific * sign;
        let resisted = self.force.abs() - (self.full * along).max(0.0);
        resisted > self.least && self.speed * sign > -STANDS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// State after two seconds with this force of the wheels [m/s^2 of the empty machine], acceleration and slope.
    fn driven(pull: f64, acceleration: f64, slope: f64, measured: bool) -> Drive {
        braked(false, pull, acceleration, slope, measured)
    }

    fn braked(brake: bool, pull: f64, acceleration: f64, slope: f64, measured: bool) -> Drive {
        let settings = Settings::default();
        let machine = &settings.machine;
        let mut drive = Drive::new(&settings, 0.3 * machine.mass);
        let specific = acceleration + GRAVITY * sin_cos(slope).0;
        for k in 0..200 {
            let time = 0.01 * f64::from(k);
            let sample = Sample {
                time,
                speed: Some(acceleration * time),
                slope: Some(slope),
                brake,
                front_torque: Some(0.5 * pull * machine.mass * machine.wheel_radius),
                rear_torque: Some(0.5 * pull * machine.mass * machine.wheel_radius),
                ..Sample::default()
            };
            drive.take(&sample, measured.then_some(specific));
        }
        drive
    }

    #[test]
    fn the_speed_determines_the_specific_force_where_there_is_no_accelerometer() {
        for (acceleration, slope) in [(1.2, 0.0), (-1.5, 0.0), (0.0, 0.1), (-0.8, -0.08)] {
            let shown = driven(0.0, acceleration, slope, false).felt;
            let true_one = acceleration + GRAVITY * f64::sin(slope);
            assert!((shown - true_one).abs() < 0.01, "{shown} {true_one}");
        }
    }

    #[test]
    fn a_push_is_what_neither_rolling_nor_any_load_on_any_slope_explains() {
        for measured in [true, false] {
            let pushes = |pull, a, slope| driven(pull, a, slope, measured).pushes();
            assert!(pushes(1.5, 0.0, 0.0) && pushes(-1.5, 0.0, 0.0));
            // Accelerated, empty and full; up a slope; moving against the wheels; braked by brakes alone.
            assert!(!pushes(1.2, 1.0, 0.0) && !pushes(1.5, 1.0, 0.0));
            assert!(!pushes(1.3, 0.0, 0.1));
            assert!(!pushes(1.0, -1.2, 0.0) && !pushes(0.0, -3.0, 0.0));
            assert!(!braked(true, 1.5, 0.0, 0.0, measured).pushes());
        }
    }
}
