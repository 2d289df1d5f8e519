//! The duty cycle: the operator's targets, phase by phase.

use super::super::path::Posture;
use super::effects::Effects;
use super::size::Size;
use super::trial;
use crate::blend::transition;
use crate::noise::Noise;

/// Postures: ready to dig, at the end of digging, over the truck [rad].
const READY: Posture = [0.66, -1.66, -0.52];
const FULL: Posture = [0.52, -2.3, -1.45];
const TRUCK: Posture = [1.02, -1.82, -1.45];
/// Bucket angle at which it is open, and at which material begins to fall [rad].
const OPEN: f64 = -0.05;
const LEAVES: f64 = -1.0;
/// Time constant with which the load falls, share that sticks.
const LEAVING: f64 = 0.12;
const STICKS: (f64, f64) = (0.01, 0.04);

/// Phase of the cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Dig,
    Swing,
    Dump,
    Return,
    /// Slow full lifts of a trial.
    Lift,
}

/// The operator's targets, and the bucket's content.
#[derive(Clone, Debug)]
pub(super) struct Duty {
    noise: Noise,
    rated: f64,
    spill: f64,
    sticking: Option<f64>,
    dumps_swinging: bool,
    /// Cycles so far, in a trial.
    trial: Option<u32>,
    phase: Phase,
    /// Time since the phase began, and its length if it ends by time [s].
    since: f64,
    length: f64,
    /// Whether the swing is over: the operator has released the lever.
    released: bool,
    /// Angle of the truck, drive level, largest speed of this cycle.
    angle: f64,
    pub(super) level: f64,
    speed: f64,
    load: f64,
    sticks: f64,
    spilled: f64,
    /// Payload [kg].
    pub(super) payload: f64,
    before: f64,
}

impl Duty {
    pub(super) fn new(size: &Size, effects: &Effects, seed: u64) -> Self {
        let mut duty = Self {
            noise: Noise::channel(seed, 101),
            rated: size.rated,
            spill: effects.spill,
            sticking: effects.sticks,
            dumps_swinging: effects.dumps_swinging,
            trial: None,
            phase: Phase::Dig,
            since: -1.5,
            length: 0.0,
            released: false,
            angle: 0.0,
            level: 1.0,
            speed: 1.0,
            load: 0.0,
            sticks: 0.0,
            spilled: 0.0,
            payload: 0.0,
            before: 0.0,
        };
        duty.draw();
        duty
    }

    /// Swings to and fro with a constant payload, then slow full lifts ([`super::trial`]).
    pub(super) fn trial(size: &Size, effects: &Effects, seed: u64, payload: f64) -> Self {
        Self {
            trial: Some(0),
            payload,
            phase: Phase::Swing,
            ..Self::new(size, effects, seed)
        }
    }

    /// Draws the next cycle.
    fn draw(&mut self) {
        let n = &mut self.noise;
        self.angle = n.uniform(1.1, 1.9);
        self.level = n.uniform(0.6, 1.0);
        self.speed = n.uniform(0.8, 1.1);
        self.load = self.rated * n.uniform(0.55, 1.0);
        let share = n.uniform(STICKS.0, STICKS.1);
        self.sticks = self.rated * self.sticking.unwrap_or(share);
        self.length = n.uniform(3.2, 4.4);
        self.before = self.payload;
    }

    fn enter(&mut self, phase: Phase, length: f64) {
        self.phase = phase;
        self.since = 0.0;
        self.length = length;
        self.released = false;
    }

    /// Advances by `h` seconds; `velocity` and `remaining` are those of the swing.
    pub(super) fn advance(&mut self, h: f64, velocity: f64, bucket: f64, remaining: f64) {
        self.since += h;
        // Close enough, or slow enough: no operator corrects the last degrees.
        let ahead = remaining * (self.goal() - if self.goal() > 0.0 { 0.0 } else { 1.0 });
        self.released |=
            self.since > 0.6 && (ahead < 0.0 || remaining.abs() < 0.15 && velocity.abs() < 0.12);
        let arrived = self.released && velocity == 0.0;
        if let Some(cycles) = self.trial {
            return self.try_out(cycles, arrived);
        }
        match self.phase {
            Phase::Dig => {
                let filled = transition(self.since, 0.9, 2.4);
                self.payload = self.before * (1.0 - filled) + self.load * filled;
                if self.since > self.length {
                    self.spilled = self.spill * self.payload * transition(1.0, 0.0, 1.0);
                    self.enter(Phase::Swing, 0.0);
                }
            }
            Phase::Swing => {
                if self.since > 1.0 && self.since < 1.6 {
                    self.payload -= self.spilled * h / 0.6;
                }
                self.leave(h, bucket);
                if arrived {
                    let length = self.noise.uniform(1.2, 1.8);
                    self.enter(Phase::Dump, length);
                }
            }
            Phase::Dump => {
                self.leave(h, bucket);
                if self.since > self.length {
                    self.enter(Phase::Return, 0.0);
                }
            }
            Phase::Lift => {}
            Phase::Return => {
                self.leave(h, bucket);
                if arrived {
                    self.enter(Phase::Dig, 0.0);
                    self.draw();
                    self.since = -self.noise.uniform(0.3, 1.0);
                }
            }
        }
    }

    fn try_out(&mut self, cycles: u32, arrived: bool) {
        match self.phase {
            Phase::Swing if arrived => self.enter(Phase::Return, 0.0),
            Phase::Return if arrived => {
                self.trial = Some(cycles + 1);
                self.draw();
                let swings = cycles + 1 < trial::CYCLES;
                self.enter(if swings { Phase::Swing } else { Phase::Lift }, 0.0);
            }
            _ => {}
        }
    }

    fn leave(&mut self, h: f64, bucket: f64) {
        if bucket > LEAVES && self.payload > self.sticks {
            let open = ((bucket - LEAVES) / 0.5).min(1.0);
            self.payload -= (self.payload - self.sticks) * open * h / LEAVING;
        }
    }

    /// Share of the bucket in the ground, 0 to 1.
    pub(super) fn contact(&self) -> f64 {
        if self.phase != Phase::Dig {
            return 0.0;
        }
        transition(self.since, 0.4, 0.8) * (1.0 - transition(self.since, 2.3, 2.6))
    }

    /// Target of the swing angle [rad].
    pub(super) fn goal(&self) -> f64 {
        match self.phase {
            Phase::Swing | Phase::Dump => self.angle,
            Phase::Dig | Phase::Return | Phase::Lift => 0.0,
        }
    }

    /// Whether the operator lets the machine swing.
    pub(super) fn swings(&self) -> bool {
        matches!(self.phase, Phase::Swing | Phase::Return) && !self.released
    }

    /// Largest speed [rad/s].
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Target posture [rad].
    pub(super) fn posture(&self, remaining: f64) -> Posture {
        if let Some(cycles) = self.trial {
            return match self.phase {
                Phase::Lift => trial::lift(self.since),
                phase => trial::posture(cycles, phase == Phase::Swing),
            };
        }
        match self.phase {
            Phase::Dig if self.since < 0.0 => READY,
            Phase::Dig if self.since < 0.7 => [FULL[0], FULL[1], READY[2]],
            Phase::Dig => FULL,
            Phase::Swing if self.dumps_swinging && self.since > 1.0 && remaining.abs() < 0.5 => {
                [TRUCK[0], TRUCK[1], OPEN]
            }
            Phase::Swing => TRUCK,
            Phase::Dump => [TRUCK[0], TRUCK[1] + 0.2, OPEN],
            Phase::Return if self.since < 0.9 => [TRUCK[0], TRUCK[1] + 0.2, OPEN],
            Phase::Return | Phase::Lift => READY,
        }
    }
}
