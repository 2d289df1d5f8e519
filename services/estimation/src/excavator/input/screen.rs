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
use crate::excavator::repeated::Repeated;
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
    angle_offsets: [f64; 3],
    torque_gain: f64,
    torque_offset: f64,
    refused: u64,
    repeated: Repeated,
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
            angle_offsets: sensors.angle_offsets,
            torque_gain: sensors.swing_torque_gain,
            torque_offset: sensors.swing_torque_offset,
            refused: 0,
            repeated: Repeated::default(),
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
        // A row that repeats the last one in spite of noise measures nothing.
        let again = self.repeated.again(sample) && self.is_noisy();
        let followed =
            self.swing_angle
                .pass(sample.angle.filter(|_| !again), period, self.velocity_limit);
        let (angle, is_elsewhere) = match followed {
            Followed::Yes(angle) => (angle, false),
            Followed::Elsewhere(angle) => (Some(angle), true),
        };
        (sample.time, sample.angle) = (self.clock.time(), angle);
        self.clean(sample, again, period);
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

    /// Whether a signal is noisy.
    fn is_noisy(&self) -> bool {
        let mut all = self.repetitions.iter().chain(&self.pressures);
        all.any(Repetition::is_noisy)
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

    /// `again`: the row repeats the last one, and only the detectors of repetitions and jumps see it.
    fn clean(&mut self, sample: &mut Sample, again: bool, period: f64) {
        // At the end of its range a sensor shows only a bound: missing.
        let within = |value: Option<f64>, limit: f64| value.filter(|v| v.abs() < limit);
        let [velocity, torque, joints @ ..] = &mut self.repetitions;
        sample.posture = joints::true_posture(sample.posture, self.angle_offsets);
        let checks = joints.iter_mut().zip(&mut self.jumps).zip(&mut self.angles);
        let possible = joints::possible(sample.posture.map(|angle| angle.unwrap_or(0.0)));
        let values = sample.posture.iter_mut().zip(possible);
        for ((value, possible), ((repetition, jump), angle)) in values.zip(checks) {
            let measured = within(*value, self.angle_limit).filter(|_| possible);
            let moving = repetition.pass(measured);
            // A displaced angle that repeats one value may come from a bus that dropped out, and is not reported as frozen.
            let joint = if jump.has_jumped() { measured } else { moving };
            let joint = jump.pass(joint, period).filter(|_| !again);
            *value = angle.pass(joint, period);
        }
        let velocity =
            within(velocity.pass(sample.velocity), self.velocity_limit).filter(|_| !again);
        let velocity = self.steady.velocity(velocity, self.velocity_std, period);
        let new = self.velocity.push(velocity);
        self.quantisation.push(velocity);
        // A held velocity carries no new information.
        sample.velocity = velocity.filter(|_| new || self.velocity.rows() == 1);
        let torque = within(torque.pass(sample.torque), TORQUE_LIMIT).filter(|_| !again);
        let torque = self.range.pass(torque, self.torque_std);
        let torque = self
            .steady
            .torque(torque, self.torque_std, period)
            .map(|t| (t - self.torque_offset) / self.torque_gain);
        sample.torque = self.torque.pass(torque);
        for angle in &mut sample.inclination {
            *angle = within(*angle, INCLINATION_LIMIT).filter(|_| !again);
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
            *pressure = within(*pressure, PRESSURE_LIMIT).filter(|_| !again);
        }
        sample.truck = within(sample.truck, f64::MAX);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;
    use crate::excavator::keys::Description;
    use crate::excavator::settings::Settings;

    /// Uniform white noise of standard deviation 1, another one for each signal.
    fn noise(k: u32, signal: u32) -> f64 {
        let mixed = (k * 8 + signal)
            .wrapping_mul(2_654_435_761)
            .rotate_left(13)
            .wrapping_mul(2_246_822_519);
        (f64::from(mixed >> 8) / f64::from(1u32 << 24) - 0.5) * 12_f64.sqrt()
    }

    /// A row of a machine that swings and moves its joints; noise of velocity, torque and angles in units of good sensors.
    fn row(k: u32, size: f64) -> Sample {
        let (sin, cos) = crate::math::sin_cos(0.01 * f64::from(k));
        let angle =
            |start: f64, signal: u32| Some(start + 0.1 * sin + 0.0005 * size * noise(k, signal));
        Sample {
            velocity: Some(0.5 * sin + 0.004 * size * noise(k, 0)),
            torque: Some(5000.0 * cos + 200.0 * size * noise(k, 1)),
            posture: [angle(0.6, 2), angle(-1.2, 3), angle(-0.4, 4)],
            ..Sample::default()
        }
    }

    /// Rows without any measurement, among rows at 100 Hz that a machine sends.
    fn unmeasured(sent: impl Fn(u32) -> Sample) -> (Vec<u32>, Screen) {
        let settings = Settings::of(&Description::default());
        let mut screen = Screen::new(&settings.sensors);
        let rows = (0..3000).filter(|&k| {
            let time = 0.01 * f64::from(k);
            let mut sample = Sample { time, ..sent(k) };
            screen.accept(&mut sample);
            sample
                == Sample {
                    time: sample.time,
                    ..Sample::default()
                }
        });
        (rows.collect(), screen)
    }

    #[test]
    fn a_row_that_a_logger_repeats_is_no_measurement_and_the_machine_is_measured_after_it() {
        for rows in [1, 10, 20, 200] {
            let held = 2000..2000 + rows;
            let (found, screen) =
                unmeasured(|k| row(if held.contains(&k) { 1999 } else { k }, 1.0));
            assert_eq!(found, held.collect::<Vec<_>>());
            assert!(!screen.is_frozen() && !screen.has_jumped());
        }
    }

    #[test]
    fn a_controller_that_sends_zeros_for_a_while_measures_nothing_meanwhile_and_everything_after_it()
     {
        for rows in [5, 30, 100, 500] {
            let off = 2000..2000 + rows;
            let (found, screen) = unmeasured(|k| {
                let zero = Some(0.0);
                let zeros = Sample {
                    velocity: zero,
                    torque: zero,
                    posture: [zero; 3],
                    ..Sample::default()
                };
                if off.contains(&k) { zeros } else { row(k, 1.0) }
            });
            // Its first row may be a torque.
            let rest: Vec<_> = off.skip(1).collect();
            assert!(
                found.ends_with(&rest) && found.len() <= rest.len() + 1,
                "{found:?}"
            );
            assert!(!screen.has_jumped(), "{rows}");
        }
    }

    #[test]
    fn equal_rows_of_a_slow_bus_of_a_coarse_sensor_and_of_a_machine_without_noise_count() {
        // Sent twenty or fifty times a second, written a hundred times.
        for rows in [5, 2] {
            let (found, _) = unmeasured(|k| row(k / rows * rows, 1.0));
            assert!(found.is_empty(), "{rows}: {found:?}");
        }
        // Without noise, or hidden by steps, until it stands.
        let steps = |value: Option<f64>, step: f64| value.map(|v| (v / step).round() * step);
        for (size, coarse) in [(0.0, 1e-9), (1.0, 1.0)] {
            let (found, screen) = unmeasured(|k| {
                let row = row(k.min(2000), size);
                Sample {
                    velocity: steps(row.velocity, 0.04 * coarse),
                    torque: steps(row.torque, 2000.0 * coarse),
                    posture: row.posture.map(|angle| steps(angle, 0.01 * coarse)),
                    ..row
                }
            });
            // Without noise each signal is reported as frozen after half a second, as ever.
            let first = found.first().copied().unwrap_or(3000);
            assert!(first >= 2050, "{size}: {first} {}", screen.is_frozen());
        }
    }
}
