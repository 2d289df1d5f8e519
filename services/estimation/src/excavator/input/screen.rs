//! Screens a row: checks its time, and marks invalid values as missing. It also removes the calibrated gain and offset of the torque, so
//! that all later stages use the true torque.

use crate::excavator::angle::Angle;
use crate::excavator::estimate::Sample;
use crate::excavator::frozen::Repetition;
use crate::excavator::grid::LONG_GAP;
use crate::excavator::hold::{Hold, Joined};
use crate::excavator::joints;
use crate::excavator::jump::Jump;
use crate::excavator::keys::Description;
use crate::excavator::quantisation::Quantisation;
use crate::excavator::range::Range;
use crate::excavator::settings::Sensors;
use crate::excavator::steady::Steady;
use crate::excavator::swing_angle::{Followed, SwingAngle};
use crate::time_base::{Tick, TimeBase};

/// Pitch or roll beyond which no machine works [rad].
const INCLINATION_LIMIT: f64 = 0.8;
/// Torque that is no measurement [N m]: four times that of the largest machines (800 t).
const TORQUE_LIMIT: f64 = 2e7;
/// Pressure that is no measurement [Pa]: five times that of mobile hydraulics (40 MPa).
const PRESSURE_LIMIT: f64 = 2e8;

/// Limit of a signal: values of this size or more count as missing. `None` for a signal without limit.
#[must_use]
pub fn largest(signal: &str, described: &Description) -> Option<f64> {
    match signal {
        "swing_velocity" => Some(described.sensors.swing_velocity_limit),
        "swing_torque" => Some(TORQUE_LIMIT),
        "boom_angle" | "arm_angle" | "bucket_angle" => Some(described.sensors.angle_limit),
        "pitch" | "roll" => Some(INCLINATION_LIMIT),
        pressure if pressure.ends_with("_pressure") => Some(PRESSURE_LIMIT),
        _ => None,
    }
}

/// Result for an accepted row.
#[derive(Debug, Clone, Copy)]
pub(in crate::excavator) struct Accepted {
    /// Time since the row before [s].
    pub(in crate::excavator) period: f64,
    /// The clock went back, or the encoder has another zero: stored values belong to another time.
    pub(in crate::excavator) set_back: bool,
}

/// Refuses rows whose time does not increase, and marks impossible values as missing.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Screen {
    clock: TimeBase,
    first_period: f64,
    velocity_limit: f64,
    velocity_std: f64,
    torque_std: f64,
    angle_limit: f64,
    torque_gain: f64,
    torque_offset: f64,
    refused: u64,
    /// Velocity, torque, boom, arm, bucket.
    repetitions: [Repetition; 5],
    /// Head and rod pressure of the boom.
    pressures: [Repetition; 2],
    jumps: [Jump; 3],
    angles: [Angle; 3],
    steady: Steady,
    velocity: Hold,
    quantisation: Quantisation,
    range: Range,
    torque: Joined,
    swing_angle: SwingAngle,
}

impl Screen {
    pub(in crate::excavator) fn new(sensors: &Sensors) -> Self {
        Self {
            clock: TimeBase::default(),
            first_period: 1.0 / sensors.rate,
            velocity_limit: sensors.swing_velocity_limit,
            velocity_std: sensors.swing_velocity_std,
            torque_std: sensors.swing_torque_std,
            angle_limit: sensors.angle_limit,
            torque_gain: sensors.swing_torque_gain,
            torque_offset: sensors.swing_torque_offset,
            refused: 0,
            repetitions: [Repetition::default(); 5],
            pressures: [Repetition::default(); 2],
            jumps: [Jump::default(); 3],
            angles: [Angle::new(sensors.angle_std); 3],
            steady: Steady::default(),
            velocity: Hold::default(),
            quantisation: Quantisation::default(),
            range: Range::default(),
            torque: Joined::default(),
            swing_angle: SwingAngle::default(),
        }
    }

    /// Removes impossible values from a row; `None` if it is refused.
    pub(in crate::excavator) fn accept(&mut self, sample: &mut Sample) -> Option<Accepted> {
        let tick = self.clock.tick(sample.time, LONG_GAP);
        let period = match tick {
            Tick::First | Tick::SetBack => self.first_period,
            Tick::Later(period) => period,
            Tick::Refused => {
                self.refused += 1;
                return None;
            }
        };
        let set_back = tick == Tick::SetBack;
        if set_back {
            self.swing_angle = SwingAngle::default();
            // The joints may have moved anywhere meanwhile.
            self.jumps = [Jump::default(); 3];
        }
        let followed = self
            .swing_angle
            .pass(sample.angle, period, self.velocity_limit);
        let (angle, is_elsewhere) = match followed {
            Followed::Yes(angle) => (angle, false),
            Followed::Elsewhere(angle) => (Some(angle), true),
        };
        (sample.time, sample.angle) = (self.clock.time(), angle);
        self.clean(sample, period);
        Some(Accepted {
            period,
            set_back: set_back || is_elsewhere,
        })
    }

    /// Rows refused so far.
    pub(in crate::excavator) fn refused(&self) -> u64 {
        self.refused
    }

    /// Whether a sensor repeats one value in spite of its noise.
    pub(in crate::excavator) fn is_frozen(&self) -> bool {
        let mut all = self.repetitions.iter().chain(&self.pressures);
        all.any(Repetition::is_frozen)
    }

    /// Whether a joint angle has jumped further than a joint moves, and does not count.
    pub(in crate::excavator) fn has_jumped(&self) -> bool {
        self.jumps.iter().any(Jump::has_jumped)
    }

    /// Whether a joint angle has jumped and not jumped back, counted or not.
    pub(in crate::excavator) fn is_displaced(&self) -> bool {
        self.jumps.iter().any(|jump| jump.by() != 0.0)
    }

    /// Displacements of the joint angles [rad], if some do not count and all of these stay as they are.
    pub(in crate::excavator) fn jumps_that_stay(&self) -> Option<[f64; 3]> {
        let mut jumped = self.jumps.iter().filter(|jump| jump.has_jumped());
        let stay = self.has_jumped() && jumped.all(Jump::stays);
        stay.then(|| self.jumps.map(|jump| jump.by()))
    }

    /// Lets displaced joint angles count.
    pub(in crate::excavator) fn admit_jumps(&mut self) {
        self.jumps.iter_mut().for_each(Jump::admit);
    }

    /// Revokes [`Self::admit_jumps`].
    pub(in crate::excavator) fn refuse_jumps(&mut self) {
        self.jumps.iter_mut().for_each(Jump::refuse);
    }

    /// Confirms the admitted joint angles.
    pub(in crate::excavator) fn believe_jumps(&mut self) {
        self.jumps.iter_mut().for_each(Jump::believe);
    }

    /// Variance that the quantisation of the velocity adds to its noise [(rad/s)^2].
    pub(in crate::excavator) fn velocity_steps(&self) -> f64 {
        self.quantisation.variance(self.velocity_std)
    }

    /// Variance of the noise of the noisiest joint angle [rad^2].
    pub(in crate::excavator) fn posture_noise(&self) -> f64 {
        self.angles.iter().map(Angle::variance).fold(0.0, f64::max)
    }

    /// Length of the hold of a torque [rows].
    pub(in crate::excavator) fn torque_held(&self) -> usize {
        self.torque.rows()
    }

    fn clean(&mut self, sample: &mut Sample, period: f64) {
        // At the end of its range a sensor shows only a bound: missing.
        let within = |value: Option<f64>, limit: f64| value.filter(|v| v.abs() < limit);
        let [velocity, torque, joints @ ..] = &mut self.repetitions;
        sample.posture = sample.posture.map(|angle| angle.map(joints::joint));
        let checks = joints.iter_mut().zip(&mut self.jumps).zip(&mut self.angles);
        let possible = joints::possible(sample.posture.map(|angle| angle.unwrap_or(0.0)));
        let values = sample.posture.iter_mut().zip(possible);
        for ((value, possible), ((repetition, jump), angle)) in values.zip(checks) {
            let measured = within(*value, self.angle_limit).filter(|_| possible);
            let moving = repetition.pass(measured);
            // A displaced angle that repeats one value may come from a bus that dropped out, and is not reported as frozen.
            let joint = if jump.has_jumped() { measured } else { moving };
            *value = angle.pass(jump.pass(joint, period), period);
        }
        let velocity = within(velocity.pass(sample.velocity), self.velocity_limit);
        let velocity = self.steady.velocity(velocity, self.velocity_std, period);
        let new = self.velocity.push(velocity);
        self.quantisation.push(velocity);
        // A held velocity carries no new information.
        sample.velocity = velocity.filter(|_| new || self.velocity.rows() == 1);
        let torque = within(torque.pass(sample.torque), TORQUE_LIMIT);
        let torque = self.range.pass(torque, self.torque_std);
        let torque = self
            .steady
            .torque(torque, self.torque_std, period)
            .map(|t| (t - self.torque_offset) / self.torque_gain);
        sample.torque = self.torque.pass(torque);
        for angle in &mut sample.inclination {
            *angle = within(*angle, INCLINATION_LIMIT);
        }
        let [head, rod] = &mut self.pressures;
        sample.boom_head_pressure = head.pass(sample.boom_head_pressure);
        sample.boom_rod_pressure = rod.pass(sample.boom_rod_pressure);
        for pressure in [
            &mut sample.boom_head_pressure,
            &mut sample.boom_rod_pressure,
            &mut sample.arm_head_pressure,
            &mut sample.arm_rod_pressure,
        ] {
            *pressure = within(*pressure, PRESSURE_LIMIT);
        }
        sample.truck = within(sample.truck, f64::MAX);
    }
}
