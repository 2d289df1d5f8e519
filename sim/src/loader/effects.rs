//! Effects that the reference plant omits, one at a time or together.
//!
//! | effect | what |
//! |---|---|
//! | late speed | a satellite receiver or radar filters: the speed is later than the other signals |
//! | brakes | friction brakes take a share of the braking, 55 % of it in front; their torque is not measured |
//! | steering | the machine articulates and drives curves: front and rear axle run at different speeds |
//! | locked drive | the centre drive is locked: both axles turn at the same speed, and the torques are not those of the split |
//! | slope sensor | an inclinometer follows the acceleration by a share of a/g, and lags |
//! | gear changes | the torque drops for 0.3 s at every change of gear, and is reported later than it acts |
//! | tyres | the stiffness of the axles differs, and that of braking from that of driving; it falls with the load as (F_z/F_0)^-p; the radius deflects more than stated |
//! | ground | the road is rougher; every other 15 m roll harder |
//! | reversing | every other run is driven backwards, as a loader does |
//! | sensors | torques with a gain, or late; a bias of the slope, a zero of the accelerometer; a speed with a long period; jitter of the time stamps |
//! | spin | no control prevents a wheel from spinning or locking if its torque exceeds the tyre's limit |
//! | data sheet | errors of the mass and the radii |
//! | payload | the mass is reported without the boom, or neither |

use std::collections::VecDeque;

use super::plant::{GRAVITY, Machine};

/// Share of the front axle in the braking of the friction brakes.
const FRONT_BRAKES: f64 = 0.55;
/// Wheel speed below which the friction brakes fade out [rad/s].
const BRAKE_FADE: f64 = 0.2;
/// Duration of a curve, left and right [s].
const CURVE: f64 = 9.0;
/// Share of the time in curves.
const CURVES: f64 = 0.5;
/// Speed at which the gear changes [m/s].
const GEAR_SPEED: f64 = 2.5;
/// Duration of a gear change [s], and share of the torque at its minimum.
const GEAR_CHANGE: (f64, f64) = (0.3, 0.3);

/// Contents of a payload report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PayloadReport {
    /// The mass, and the times of boom motion.
    #[default]
    All,
    /// The mass only.
    Mass,
    /// Nothing.
    Nothing,
}

/// The effects; the default is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effects {
    /// Delay of the speed \[s\].
    pub speed_delay: f64,
    /// Whether there is no traction control that reduces the torque of a spinning or locking wheel (scenario `loading`).
    pub spins: bool,
    /// Share of the braking by friction brakes.
    pub brakes: f64,
    /// Whether their activity is reported.
    pub brakes_reported: bool,
    /// Largest articulation \[rad\].
    pub steering: f64,
    /// Whether articulation and yaw rate are measured.
    pub steering_reported: bool,
    /// Distance of the hinge from the middle of the wheelbase, in wheelbases, forward positive.
    pub hinge: f64,
    /// Whether the centre drive is locked.
    pub locked_drive: bool,
    /// Share of a/g in the reading of the slope sensor.
    pub slope_follows: f64,
    /// Time constant of the slope sensor \[s\].
    pub slope_lag: f64,
    /// Delay of the reported torque in a gear change \[s\]; 0 for a machine without gears.
    pub gear_delay: f64,
    /// Slip stiffness of the front axle over that of the rear, less one.
    pub stiffness_difference: f64,
    /// Exponent p of a stiffness that falls with the load.
    pub stiffness_exponent: f64,
    /// Load sensitivity of the radius in addition to the stated one.
    pub radius_sensitivity: f64,
    /// Slip stiffness in braking over that in driving, less one.
    pub braking_stiffness: f64,
    /// Unevenness of the road at 0.1 periods per metre, G_d(n_0) of ISO 8608 [m^3]; 0 is the scenario's own.
    pub roughness: f64,
    /// Additional rolling resistance on every other 15 m.
    pub rolling_resistance: f64,
    /// Whether every other run is driven backwards.
    pub reverses: bool,
    /// Measured over true torque, less one.
    pub torque_gain: f64,
    /// Additional gain error of the rear axle.
    pub rear_torque_gain: f64,
    /// Measured over true speed, less one.
    pub speed_gain: f64,
    /// Gain error of the front wheels' speed.
    pub front_speed_gain: f64,
    /// Delay of the torques \[s\].
    pub torque_delay: f64,
    /// Bias of the slope sensor \[rad\].
    pub slope_bias: f64,
    /// Zero of the accelerometer [m/s^2].
    pub acceleration_offset: f64,
    /// Period of new speed values \[s\]; 0 for every row.
    pub speed_period: f64,
    /// Standard deviation of the time stamps \[s\].
    pub jitter: f64,
    /// Stated over true mass, less one.
    pub mass_error: f64,
    /// Stated over true rolling radius of both axles, less one.
    pub radius_error: f64,
    /// Contents of a payload report.
    pub payload_reported: PayloadReport,
}

/// Articulation of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bend {
    /// Articulation, positive turning left \[rad\].
    pub angle: f64,
    /// Its rate [rad/s].
    pub rate: f64,
}

/// Slip at which the traction control begins to reduce the torque of an axle, and slip at which none is left.
const SLIPPING: (f64, f64) = (0.25, 0.5);
/// Least speed in the denominator of a slip [m/s].
const LEAST_SPEED: f64 = 0.5;

/// Torque of an axle after the traction control, for a speed over ground and a wheel speed [m/s, rad/s].
pub(super) fn held(machine: &Machine, torque: f64, speed: f64, wheel_speed: f64) -> f64 {
    let slip = (machine.wheel_radius * wheel_speed - speed) / speed.abs().max(LEAST_SPEED);
    let beyond = (slip * torque.signum() - SLIPPING.0) / (SLIPPING.1 - SLIPPING.0);
    torque * (1.0 - beyond.clamp(0.0, 1.0))
}

impl Effects {
    /// Applies the tyres and axles of these effects to a machine.
    pub(super) fn apply(&self, machine: &mut Machine) {
        machine.stiffness_difference = self.stiffness_difference;
        machine.stiffness_exponent = self.stiffness_exponent;
        machine.radius_load_sensitivity += self.radius_sensitivity;
        machine.braking_stiffness = self.braking_stiffness;
        machine.rough_rolling = self.rolling_resistance;
        machine.locked_drive = self.locked_drive;
        machine.hinge = self.hinge;
    }

    /// Torque of the friction brakes on both axles [N m], against the rolling direction, and the remaining drive torque.
    ///
    /// The brakes take their share of a braking axle torque.
    pub(super) fn brake(&self, torques: [f64; 2], wheel_speed: f64) -> ([f64; 2], [f64; 2]) {
        let braking = (torques[0] + torques[1]) * wheel_speed < 0.0 && self.brakes > 0.0;
        if !braking {
            return ([0.0; 2], torques);
        }
        let taken = self.brakes * (torques[0] + torques[1]);
        // The brakes fade out at rest, because a brake does not push.
        let grip = (wheel_speed.abs() / BRAKE_FADE).min(1.0);
        (
            [
                FRONT_BRAKES * taken * grip,
                (1.0 - FRONT_BRAKES) * taken * grip,
            ],
            torques.map(|t| (1.0 - self.brakes) * t),
        )
    }

    /// The articulation at time `t`.
    pub(super) fn bend(&self, t: f64) -> Bend {
        if self.steering == 0.0 {
            return Bend::default();
        }
        let phase = (t / CURVE).fract() / CURVES;
        if phase >= 1.0 {
            return Bend::default();
        }
        let side = if ((t / CURVE) as u64).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        let progress = std::f64::consts::PI * phase;
        let rate = std::f64::consts::PI / (CURVE * CURVES);
        // In and out during the curve, smooth at both ends.
        Bend {
            angle: side * self.steering * progress.sin() * progress.sin(),
            rate: side * self.steering * (2.0 * progress).sin() * rate,
        }
    }
}

/// Speed of the front axle over that of the rear: slope and offset, v_front = slope v + offset, for an articulated machine.
///
/// With l_f, l_r from the hinge to the axles: the rear body moves at v along its axis, the hinge follows, and the front axle
/// rolls without side slip.
pub(super) fn front_speed(machine: &Machine, bend: &Bend) -> (f64, f64) {
    let front = (0.5 - machine.hinge) * machine.wheelbase;
    let rear = machine.wheelbase - front;
    let (sin, cos) = bend.angle.sin_cos();
    let turn = front + rear * cos;
    // Yaw rate of the rear body: (v sin - front rate)/(front + rear cos); v_front = v cos + rear yaw sin.
    (
        cos + rear * sin * sin / turn,
        -rear * sin * front * bend.rate / turn,
    )
}

/// Yaw rate of the rear body [rad/s], positive turning left.
pub(super) fn yaw_rate(machine: &Machine, bend: &Bend, speed: f64) -> f64 {
    let front = (0.5 - machine.hinge) * machine.wheelbase;
    let rear = machine.wheelbase - front;
    let (sin, cos) = bend.angle.sin_cos();
    (speed * sin - front * bend.rate) / (front + rear * cos)
}

/// The gears: times of their changes, and the remaining torque.
#[derive(Clone, Debug, Default)]
pub(super) struct Gears {
    high: bool,
    /// Times of the last changes.
    changes: VecDeque<f64>,
}

impl Gears {
    /// Follows the speed at time `t`.
    pub fn follow(&mut self, t: f64, speed: f64) {
        let limit = if self.high {
            0.9 * GEAR_SPEED
        } else {
            GEAR_SPEED
        };
        if (speed > limit) != self.high {
            self.high = !self.high;
            self.changes.push_back(t);
            if self.changes.len() > 8 {
                self.changes.pop_front();
            }
        }
    }

    /// Share of the transmitted torque at time `t`.
    pub fn share(&self, t: f64) -> f64 {
        let (time, least) = GEAR_CHANGE;
        let during = |from: &f64| (0.0..time).contains(&(t - from));
        match self.changes.iter().rev().find(|from| during(from)) {
            Some(from) => {
                let x = (2.0 * (t - from) / time - 1.0).abs();
                least + (1.0 - least) * x * x
            }
            None => 1.0,
        }
    }
}

/// A delayed signal: its values of the last second.
#[derive(Clone, Debug, Default)]
pub(super) struct Late {
    values: VecDeque<(f64, f64)>,
}

impl Late {
    /// Takes the value at `t` and returns that of `delay` earlier, interpolated linearly between rows.
    pub fn pass(&mut self, t: f64, value: f64, delay: f64) -> f64 {
        if delay <= 0.0 {
            return value;
        }
        self.values.push_back((t, value));
        let wanted = t - delay;
        while self.values.len() > 2 && self.values[1].0 <= wanted {
            self.values.pop_front();
        }
        let (a, b) = (self.values[0], self.values[self.values.len().min(2) - 1]);
        if b.0 <= a.0 || wanted <= a.0 {
            return a.1;
        }
        a.1 + (b.1 - a.1) * ((wanted - a.0) / (b.0 - a.0)).min(1.0)
    }
}

/// An inclinometer that follows the acceleration and lags.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Inclinometer {
    shown: Option<f64>,
}

impl Inclinometer {
    /// Reading on a slope [rad] under an acceleration [m/s^2], `dt` after the last call.
    pub fn show(&mut self, effects: &Effects, slope: f64, acceleration: f64, dt: f64) -> f64 {
        let seen = slope + effects.slope_follows * acceleration / GRAVITY;
        let shown = self.shown.get_or_insert(seen);
        // A ramp is late by exactly the time constant, at any step length.
        *shown += dt / (dt + effects.slope_lag) * (seen - *shown);
        *shown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hinge_in_the_middle_of_a_steady_curve_moves_both_axles_equally() {
        let bend = Bend {
            angle: 0.3,
            rate: 0.0,
        };
        let speed = |hinge: f64| {
            let machine = Machine {
                hinge,
                ..Machine::NOMINAL
            };
            front_speed(&machine, &bend).0
        };
        assert!((speed(0.0) - 1.0).abs() < 1e-12);
        // With the hinge closer to the front, the front axle's circle is the larger one, by some gamma^2 per wheelbase.
        assert!(speed(0.1) > 1.005 && speed(-0.1) < 0.995, "{}", speed(0.1));
    }

    #[test]
    fn a_late_signal_is_what_it_was() {
        let mut late = Late::default();
        let last = (0..100).fold(0.0, |_, k| {
            let t = f64::from(k) * 0.01;
            late.pass(t, 3.0 * t, 0.085)
        });
        assert!((last - 3.0 * (0.99 - 0.085)).abs() < 1e-9, "{last}");
    }
}
