//! A run of the plant, sampled by its sensors.

use super::plant::{Motion, Plant, Point};
use super::scenario::Scenario;
use crate::fault::{Fault, Injector};
use crate::noise::Noise;
use std::fmt;

/// The longest integration step [s].
const LONGEST_STEP: f64 = 1e-3;
/// The sampling rates that can be simulated [Hz].
const RATES: std::ops::RangeInclusive<f64> = 10.0..=10_000.0;

/// The sensors, by the names that faults use; the order is that of the noise streams.
pub const CHANNELS: [&str; 6] = [
    "swing_velocity",
    "swing_angle",
    "swing_torque",
    "boom_angle",
    "arm_angle",
    "bucket_angle",
];

/// Standard deviations of the white noise per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    /// Of the swing velocity [rad/s].
    pub swing_velocity: f64,
    /// Of the swing angle, an encoder's [rad].
    pub swing_angle: f64,
    /// Of the swing torque [N m].
    pub swing_torque: f64,
    /// Of the joint angles [rad].
    pub joint_angle: f64,
}

impl Default for Sensors {
    fn default() -> Self {
        Self {
            swing_velocity: 0.005,
            swing_angle: 2e-4,
            swing_torque: 100.0,
            joint_angle: 0.0,
        }
    }
}

impl Sensors {
    /// Sensors without noise.
    pub const EXACT: Self = Self {
        swing_velocity: 0.0,
        swing_angle: 0.0,
        swing_torque: 0.0,
        joint_angle: 0.0,
    };
}

/// What to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The course of events.
    pub scenario: Scenario,
    /// Mass of a full bucket [kg]; the scenario's own if none.
    pub payload: Option<f64>,
    /// Sampling rate, 10 to 10000 [Hz].
    pub rate: f64,
    /// Seed of all noise.
    pub seed: u64,
    /// Noise of the sensors.
    pub noise: Sensors,
    /// What else they do wrong.
    pub faults: Vec<Fault>,
    /// Length of the record [s]; both ends are sampled. May be infinite.
    pub duration: f64,
}

impl Run {
    /// A scenario at 100 Hz with the standard noise and its own payload and duration.
    pub fn new(scenario: Scenario) -> Self {
        Self {
            scenario,
            payload: None,
            rate: 100.0,
            seed: 1,
            noise: Sensors::default(),
            faults: Vec::new(),
            duration: scenario.duration(),
        }
    }
}

/// What is really so at the time of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Total inertia about the swing axis [kg m^2].
    pub inertia: f64,
    /// Viscous damping [N m s/rad].
    pub damping: f64,
    /// Coulomb friction [N m].
    pub friction: f64,
    /// Swing torque [N m].
    pub torque: f64,
    /// Swing velocity [rad/s].
    pub velocity: f64,
    /// Swing acceleration [rad/s^2].
    pub acceleration: f64,
    /// Mass in the bucket [kg].
    pub payload: f64,
}

/// One sample of all sensors. None is a missing value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Time of the sample [s].
    pub time: f64,
    /// Swing velocity [rad/s].
    pub swing_velocity: Option<f64>,
    /// Swing angle since the beginning of the record [rad].
    pub swing_angle: Option<f64>,
    /// Swing torque [N m].
    pub swing_torque: Option<f64>,
    /// Angles of boom, arm and bucket [rad].
    pub posture: [Option<f64>; 3],
    /// What is really so.
    pub truth: Truth,
}

/// A run that cannot be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidRun(String);

impl fmt::Display for InvalidRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for InvalidRun {}

/// Yields the samples of a run, one after the other. A sample costs a few microseconds per millisecond of
/// its period and allocates nothing.
#[derive(Clone, Debug)]
pub struct Simulation {
    plant: Plant,
    start: f64,
    rate: f64,
    /// Integration steps per sample.
    steps: u32,
    /// Index of the next sample.
    next: u64,
    /// Samples in all.
    count: u64,
    motion: Motion,
    /// What acts at the time of the next sample.
    point: Point,
    noise: [Noise; 6],
    deviation: [f64; 6],
    injector: Injector,
}

impl Simulation {
    /// The simulation of a run.
    ///
    /// # Errors
    /// The rate is not within 10 Hz and 10 kHz, the duration is negative, the payload or a noise is negative
    /// or not finite, or a fault names an unknown channel.
    pub fn new(run: &Run) -> Result<Self, InvalidRun> {
        check(run)?;
        Self::of(run.scenario.plant(run.payload), run.scenario.start(), run)
    }

    /// The simulation of any plant, at rest at `start` [s], with rate, seed, noise, faults and duration of a run.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(plant: Plant, start: f64, run: &Run) -> Result<Self, InvalidRun> {
        check(run)?;
        let injector = Injector::new(&run.faults, &CHANNELS, run.seed);
        let Sensors {
            swing_velocity,
            swing_angle,
            swing_torque,
            joint_angle,
        } = run.noise;
        Ok(Self {
            start,
            rate: run.rate,
            steps: (1.0 / (run.rate * LONGEST_STEP) - 1e-9).ceil().max(1.0) as u32,
            next: 0,
            // Both ends are samples; a saturating cast makes an infinite run endless.
            count: ((run.duration * run.rate + 1e-6).floor() as u64).saturating_add(1),
            motion: Motion::default(),
            point: plant.point(start),
            noise: std::array::from_fn(|channel| Noise::channel(run.seed, channel as u64)),
            deviation: [
                swing_velocity,
                swing_angle,
                swing_torque,
                joint_angle,
                joint_angle,
                joint_angle,
            ],
            injector: injector.map_err(|e| InvalidRun(e.to_string()))?,
            plant,
        })
    }

    /// The plant that is simulated.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Time `steps` integration steps after the next sample [s].
    fn time(&self, steps: f64) -> f64 {
        self.start + (self.next as f64 + steps / f64::from(self.steps)) / self.rate
    }

    /// The sample at the current state, or none if it is lost as a whole.
    fn measure(&mut self) -> Option<Row> {
        let time = self.time(0.0);
        let [boom, arm, bucket] = self.plant.posture(time);
        let Motion { velocity, angle } = self.motion;
        let exact = [velocity, angle, self.point.torque, boom, arm, bucket];
        let lost = self.injector.loses_row(time);
        let mut seen = [None; 6];
        for (channel, value) in exact.into_iter().enumerate() {
            let noisy = value + self.deviation[channel] * self.noise[channel].normal();
            seen[channel] = self.injector.apply(channel, time, Some(noisy));
        }
        let row = Row {
            time,
            swing_velocity: seen[0],
            swing_angle: seen[1],
            swing_torque: seen[2],
            posture: [seen[3], seen[4], seen[5]],
            truth: self.truth(time),
        };
        (!lost).then_some(row)
    }

    fn truth(&self, time: f64) -> Truth {
        let machine = &self.plant.machine;
        Truth {
            inertia: self.point.inertia,
            damping: machine.damping,
            friction: machine.friction,
            torque: self.point.torque,
            velocity: self.motion.velocity,
            acceleration: machine.acceleration(&self.point, self.motion.velocity),
            payload: self.plant.payload(time),
        }
    }

    /// Integrates to the next sample.
    fn advance(&mut self) {
        let h = 1.0 / (self.rate * f64::from(self.steps));
        for i in 0..self.steps {
            let middle = self.plant.point(self.time(f64::from(i) + 0.5));
            let end = self.plant.point(self.time(f64::from(i) + 1.0));
            self.motion = self
                .plant
                .machine
                .advance(self.motion, h, &[self.point, middle, end]);
            self.point = end;
        }
        self.next += 1;
    }
}

impl Iterator for Simulation {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        while self.next < self.count {
            let row = self.measure();
            self.advance();
            if row.is_some() {
                return row;
            }
        }
        None
    }
}

fn check(run: &Run) -> Result<(), InvalidRun> {
    let Sensors {
        swing_velocity,
        swing_angle,
        swing_torque,
        joint_angle,
    } = run.noise;
    let noise = [swing_velocity, swing_angle, swing_torque, joint_angle];
    let sound = |v: f64| v.is_finite() && v >= 0.0;
    if !RATES.contains(&run.rate) {
        Err(InvalidRun(format!(
            "rate {} Hz: from 10 to 10000 Hz",
            run.rate
        )))
    } else if run.duration.is_nan() || run.duration < 0.0 {
        Err(InvalidRun(format!(
            "duration {} s: must not be negative",
            run.duration
        )))
    } else if !run.payload.is_none_or(sound) {
        Err(InvalidRun(
            "payload: must be a finite mass, not negative [kg]".into(),
        ))
    } else if !noise.into_iter().all(sound) {
        Err(InvalidRun(
            "noise: standard deviations must be finite and not negative".into(),
        ))
    } else {
        Ok(())
    }
}
