//! The swing dynamics and their integration.

use super::geometry::{Geometry, Inertia};
use super::path::{Path, Posture};
use super::payload::{Load, payload};
use super::torque::Swing;
use crate::rk4::{self, Stage};

/// Width of the smooth sign function of friction [rad/s].
const FRICTION_WIDTH: f64 = 0.005;
/// Velocity below which friction holds the machine, if the torque is less than the friction [rad/s].
const STICTION_VELOCITY: f64 = 2e-3;

/// The equation of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dynamics {
    /// d/dt (J w) due to posture = torques: the physics.
    Momentum,
    /// J dw/dt = torques: Eq. 11 of the paper, which leaves out J' w.
    Paper,
}

/// The machine itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// Dimensions and masses.
    pub geometry: Geometry,
    /// Viscous damping b [N m s/rad].
    pub damping: f64,
    /// Coulomb friction T_f [N m].
    pub friction: f64,
    /// Its equation of motion.
    pub dynamics: Dynamics,
}

/// The machine with its inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// The machine.
    pub machine: Machine,
    /// Motion of the joints.
    pub path: Path,
    /// Contents of the bucket.
    pub loads: Vec<Load>,
    /// Torques of the swing drive; the swings do not overlap.
    pub swings: Vec<Swing>,
    /// Period after which everything repeats \[s\]; infinite if nothing repeats. The joint paths and the loads must end as they
    /// begin.
    pub period: f64,
}

/// Inertia and torque of the swing at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Inertia J [kg m^2].
    pub inertia: f64,
    /// Its rate J' due to posture [kg m^2/s].
    pub inertia_rate: f64,
    /// Swing torque T_sw [N m].
    pub torque: f64,
}

/// Velocity and angle of the swing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Swing velocity w [rad/s].
    pub velocity: f64,
    /// Swing angle, 0 at the beginning \[rad\].
    pub angle: f64,
}

impl Machine {
    /// dw/dt = (T_sw - b w - T_f tanh(w/0.005) - J' w)/J, the last term in the momentum form only [rad/s^2].
    pub fn rate(&self, point: &Point, velocity: f64) -> f64 {
        let gyration = match self.dynamics {
            Dynamics::Momentum => point.inertia_rate,
            Dynamics::Paper => 0.0,
        };
        let friction = self.friction * (velocity / FRICTION_WIDTH).tanh();
        (point.torque - friction - (self.damping + gyration) * velocity) / point.inertia
    }

    /// The acceleration of a sample: zero while friction holds the machine.
    pub fn acceleration(&self, point: &Point, velocity: f64) -> f64 {
        if velocity.abs() < 1e-9 && point.torque.abs() < self.friction {
            0.0
        } else {
            self.rate(point, velocity)
        }
    }

    /// The motion `h` later, given inertia and torque at the start, in the middle and at the end of the step.
    pub fn advance(&self, motion: Motion, h: f64, [start, middle, end]: &[Point; 3]) -> Motion {
        let [mut velocity] = rk4::step([motion.velocity], h, |stage, [w]| match stage {
            Stage::Start => [self.rate(start, w)],
            Stage::Middle => [self.rate(middle, w)],
            Stage::End => [self.rate(end, w)],
        });
        if motion.velocity.abs() < STICTION_VELOCITY && end.torque.abs() < self.friction {
            velocity = 0.0;
        }
        Motion {
            velocity,
            angle: motion.angle + 0.5 * h * (motion.velocity + velocity),
        }
    }
}

impl Plant {
    /// Time within the repeated cycle.
    fn phase(&self, time: f64) -> f64 {
        if self.period.is_finite() {
            time.rem_euclid(self.period)
        } else {
            time
        }
    }

    /// The posture at a time \[rad\].
    pub fn posture(&self, time: f64) -> Posture {
        self.path.posture(self.phase(time))
    }

    /// The rates of the joints at a time [rad/s].
    pub fn rate(&self, time: f64) -> Posture {
        self.path.rate(self.phase(time))
    }

    /// The payload at a time \[kg\].
    pub fn payload(&self, time: f64) -> f64 {
        payload(&self.loads, self.phase(time))
    }

    /// The inertia at a time, separately for machine and payload.
    pub fn inertia(&self, time: f64) -> Inertia {
        let time = self.phase(time);
        self.machine
            .geometry
            .inertia(self.path.posture(time), self.path.rate(time))
    }

    /// Share of the bucket in the ground around its filling, 0 to 1.
    pub fn contact(&self, time: f64) -> f64 {
        let time = self.phase(time);
        let contact = self.loads.iter().map(|load| load.contact(time));
        contact.fold(0.0, f64::max)
    }

    /// The swing torque at a time [N m].
    pub fn torque(&self, time: f64) -> f64 {
        let time = self.phase(time);
        self.swings.iter().map(|swing| swing.torque(time)).sum()
    }

    /// Inertia and torque at a time.
    pub fn point(&self, time: f64) -> Point {
        let (inertia, mass) = (self.inertia(time), self.payload(time));
        Point {
            inertia: inertia.total(mass),
            inertia_rate: inertia.posture_rate(mass),
            torque: self.torque(time),
        }
    }
}
