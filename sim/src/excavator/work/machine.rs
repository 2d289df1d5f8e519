//! The machine: upper body, flexible boom, swinging load, dry friction, slope.

use super::super::geometry::Geometry;
use super::super::path::Posture;
use super::duty::Duty;
use super::effects::Effects;
use super::size::Size;
use crate::noise::Noise;
use std::f64::consts::TAU;

/// Integration step [s].
pub(super) const STEP: f64 = 1e-3;
/// Standard gravity [m/s^2].
const GRAVITY: f64 = 9.806_65;
/// Bandwidth of the joints, and of the drive [1/s].
const JOINTS: f64 = 4.5;
const DRIVE: f64 = 12.0;
/// Damping ratio of the boom's lateral mode, and of the swinging load.
const BOOM_DAMPING: f64 = 0.04;
const LOAD_DAMPING: f64 = 0.03;
/// Velocity scale of the sign change of friction, and of the Stribeck effect [rad/s].
const FRICTION_WIDTH: f64 = 0.003;
const STRIBECK: f64 = 0.04;

/// A body that turns about the swing axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Body {
    pub(super) angle: f64,
    pub(super) velocity: f64,
}

/// State of the machine.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    pub(super) size: Size,
    effects: Effects,
    direction: f64,
    pub(super) duty: Duty,
    /// Upper body, attachment, swinging load.
    pub(super) bodies: [Body; 3],
    pub(super) posture: Posture,
    pub(super) joint_rates: Posture,
    pub(super) joint_accelerations: Posture,
    /// Torque of the drive [N m].
    pub(super) torque: f64,
    /// Total inertia [kg m^2].
    pub(super) inertia: f64,
    pub(super) acceleration: f64,
}

impl Machine {
    pub(super) fn new(size: Size, effects: Effects, duty: Duty, seed: u64) -> Self {
        let posture = duty.posture(0.0);
        Self {
            direction: Noise::channel(seed, 100).uniform(0.0, TAU),
            size,
            effects,
            duty,
            bodies: [Body::default(); 3],
            posture,
            joint_rates: [0.0; 3],
            joint_accelerations: [0.0; 3],
            torque: 0.0,
            inertia: size.geometry.inertia(posture, [0.0; 3]).base,
            acceleration: 0.0,
        }
    }

    /// Pitch (nose up) and roll (left side low) of the upper body [rad].
    pub(super) fn inclination(&self) -> [f64; 2] {
        let turned = self.direction - self.bodies[0].angle;
        let slope = self.effects.slope;
        [-slope * turned.cos(), slope * turned.sin()]
    }

    /// Friction of the machine [N m].
    pub(super) fn friction(&self) -> f64 {
        self.effects.friction * self.size.friction
    }

    /// Viscous damping of the machine [N m s/rad].
    pub(super) fn damping(&self) -> f64 {
        self.effects.damping * self.size.damping
    }

    /// One integration step.
    pub(super) fn advance(&mut self) {
        let upper = self.bodies[0];
        let remaining = self.duty.goal() - upper.angle;
        self.duty
            .advance(STEP, upper.velocity, self.posture[2], remaining);
        self.joints(remaining);
        self.drive(remaining);
        self.turn();
    }

    fn joints(&mut self, remaining: f64) {
        let goal = self.duty.posture(remaining);
        let joints = self.posture.iter_mut().zip(&mut self.joint_rates);
        for (((angle, rate), goal), seen) in joints.zip(goal).zip(&mut self.joint_accelerations) {
            let before = *rate;
            let acceleration = JOINTS * JOINTS * (goal - *angle) - 2.0 * JOINTS * *rate;
            *rate = (*rate + STEP * acceleration).clamp(-1.6, 1.6);
            *seen = (*rate - before) / STEP;
            *angle += STEP * *rate;
        }
    }

    fn drive(&mut self, remaining: f64) {
        let limit = self.size.torque * self.duty.level;
        let velocity = self.bodies[0].velocity;
        let wanted = if !self.duty.swings() {
            // The remaining speed is braked.
            (-6.0 * self.inertia * velocity).clamp(-limit, limit)
        } else {
            let braking = 0.8 * limit / self.inertia;
            let approach = (2.0 * braking * (remaining.abs() - 0.005).max(0.0)).sqrt();
            let aim = approach.min(self.duty.speed()).copysign(remaining);
            let holding = self.damping() * velocity + self.friction() * velocity.signum();
            (6.0 * self.inertia * (aim - velocity) + holding).clamp(-limit, limit)
        };
        let relief = (1.0 - self.effects.relief) * self.size.torque;
        self.torque += STEP * DRIVE * (wanted.clamp(-relief, relief) - self.torque);
    }

    fn turn(&mut self) {
        let geometry = &self.size.geometry;
        let parts = geometry.inertia(self.posture, self.joint_rates);
        let payload = self.duty.payload;
        let swinging = self.effects.pendulum * payload * parts.factor;
        let flexible = self.effects.boom_mode > 0.0;
        self.inertia = parts.total(payload);
        let carried = self.inertia - geometry.upper_inertia - swinging;
        let own = geometry.upper_inertia + if flexible { 0.0 } else { carried };
        let rate = parts.posture_rate(payload);

        let before = self.bodies;
        let [upper, boom, load] = before;
        let mut torque = self.torques(&upper) - if flexible { 0.0 } else { rate * upper.velocity };
        let mut accelerations = [0.0; 3];
        let holder = if flexible {
            let spring = (TAU * self.effects.boom_mode).powi(2) * carried;
            let damper = 2.0 * BOOM_DAMPING * (spring * carried).sqrt();
            let between =
                spring * (upper.angle - boom.angle) + damper * (upper.velocity - boom.velocity);
            torque -= between;
            accelerations[1] = (between - rate * boom.velocity) / carried;
            1
        } else {
            0
        };
        if swinging > 1e-6 {
            let frequency = (GRAVITY / self.effects.pendulum_length).sqrt();
            let spring = frequency * frequency * swinging;
            let damper = 2.0 * LOAD_DAMPING * frequency * swinging;
            let holds = before[holder];
            let between =
                spring * (holds.angle - load.angle) + damper * (holds.velocity - load.velocity);
            accelerations[2] = between / swinging;
            if flexible {
                accelerations[1] -= between / carried;
            } else {
                torque -= between;
            }
        }
        accelerations[0] = torque / own;
        self.acceleration = accelerations[0];
        for (body, acceleration) in self.bodies.iter_mut().zip(accelerations) {
            body.velocity += STEP * acceleration;
        }
        self.stick(upper.velocity);
        if !flexible {
            self.bodies[1] = self.bodies[0];
        }
        if swinging <= 1e-6 {
            self.bodies[2] = self.bodies[holder];
        }
        for body in &mut self.bodies {
            body.angle += STEP * body.velocity;
        }
    }

    /// Stops the upper body by dry friction, or by the holding brake of a machine that does not swing.
    fn stick(&mut self, before: f64) {
        let upper = &mut self.bodies[0];
        let held = self.torque.abs() < self.effects.friction * self.size.friction;
        let crossed = before * upper.velocity < 0.0;
        let braked = !self.duty.swings() && upper.velocity.abs() < 0.01;
        if held && (crossed || upper.velocity.abs() < 2e-3) || braked {
            upper.velocity = 0.0;
            self.acceleration = 0.0;
        }
    }

    /// Torque on the upper body from outside and from its drive [N m].
    fn torques(&self, upper: &Body) -> f64 {
        let e = &self.effects;
        let w = upper.velocity;
        let driven = if self.torque * w >= 0.0 {
            self.torque * e.efficiency
        } else {
            self.torque / e.efficiency
        };
        let front = first_moment(&self.size.geometry, self.posture, self.duty.payload);
        let moment = self.size.upper_first_moment + front;
        let loaded = first_moment(&self.size.geometry, self.posture, self.size.rated);
        let overturning = (moment / (self.size.upper_first_moment + loaded))
            .abs()
            .min(2.0);
        let stribeck = 1.0 + (e.stribeck - 1.0) * (-(w / STRIBECK).powi(2)).exp();
        let friction = self.friction() * stribeck * (1.0 + e.overturning * overturning);
        let slope = GRAVITY * e.slope.sin() * moment * (self.direction - upper.angle).sin();
        driven - self.damping() * w - friction * (w / FRICTION_WIDTH).tanh() + slope
    }
}

/// First moment of boom, arm, bucket and payload about the swing axis [kg m].
fn first_moment(geometry: &Geometry, posture: Posture, payload: f64) -> f64 {
    let boom = posture[0].cos();
    let arm = (posture[0] + posture[1]).cos();
    let tool = (posture[0] + posture[1] + posture[2]).cos();
    let arm_pin = geometry.boom_pin + geometry.boom_length * boom;
    let tool_pin = arm_pin + geometry.arm_length * arm;
    let attachment = &geometry.attachment;
    geometry.boom.mass * (geometry.boom_pin + geometry.boom.centre * boom)
        + geometry.arm.mass * (arm_pin + geometry.arm.centre * arm)
        + attachment.link.mass * (tool_pin + attachment.link.centre * tool)
        + payload * (tool_pin + attachment.payload_centre * tool)
}
