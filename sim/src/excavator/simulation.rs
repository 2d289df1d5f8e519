//! A run of the plant, sampled by its sensors.

use super::course::Course;
use super::front::{Front, cylinders};
use super::plant::Plant;
use super::row::Row;
use super::scenario::Scenario;
use super::sensors::{Instruments, Sensors};
use crate::cylinder::{Cylinder, Gauges};
use crate::fault::Fault;
use crate::noise::Noise;
use std::fmt;

/// Supported sampling rates [Hz].
const RATES: std::ops::RangeInclusive<f64> = 10.0..=10_000.0;

/// Noise stream of the seals' friction, and its spread about the described one.
const SEALS: u64 = 203;
const SEALS_STD: f64 = 0.35;

/// Options of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The scenario.
    pub scenario: Scenario,
    /// Mass of a full bucket \[kg\]; `None` for the scenario's own.
    pub payload: Option<f64>,
    /// Sampling rate, 10 to 10000 \[Hz\].
    pub rate: f64,
    /// Seed of all noise.
    pub seed: u64,
    /// Noise of the sensors.
    pub noise: Sensors,
    /// Pressure sensors of boom and arm cylinders, if the machine has any.
    pub gauges: Option<Gauges>,
    /// Faults of the sensors.
    pub faults: Vec<Fault>,
    /// Length of the record \[s\]; both ends are sampled. May be infinite.
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
            gauges: None,
            faults: Vec::new(),
            duration: scenario.duration(),
        }
    }
}

/// Reason why a run is impossible.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidRun(String);

impl fmt::Display for InvalidRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for InvalidRun {}

/// The samples of a run in order. A sample costs a few microseconds per millisecond of its period and allocates nothing.
#[derive(Clone, Debug)]
pub struct Simulation {
    course: Course,
    instruments: Instruments,
    front: Option<Front>,
}

impl Simulation {
    /// The simulation of a run.
    ///
    /// # Errors
    /// The rate is not within 10 Hz and 10 kHz, or the duration is negative. The payload or a noise is negative
    /// or not finite. A fault names an unknown channel.
    pub fn new(run: &Run) -> Result<Self, InvalidRun> {
        check(run)?;
        Self::of(run.scenario.plant(run.payload), run.scenario.start(), run)
    }

    /// The simulation of any plant, at rest at `start` \[s\], with rate, seed, noise, faults and duration of a run.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(plant: Plant, start: f64, run: &Run) -> Result<Self, InvalidRun> {
        check(run)?;
        let instruments = Instruments::new(run.noise, &run.faults, run.seed);
        let geometry = plant.machine.geometry;
        let real = worn(cylinders(&geometry), run.seed);
        let front = |gauges| Front::new(geometry, real, gauges, run.seed);
        Ok(Self {
            front: run.gauges.map(front),
            course: Course::new(plant, start, run.rate, run.duration),
            instruments: instruments.map_err(|e| InvalidRun(e.to_string()))?,
        })
    }
}

impl Iterator for Simulation {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        loop {
            let exact = self.course.next()?;
            let pressures = self.front.as_mut().map(|front| {
                let pose = self.course.pose(&exact);
                front.show(exact.time, &pose)
            });
            if let Some(row) = self.instruments.measure(&exact, pressures) {
                return Some(row);
            }
        }
    }
}

/// Cylinders whose seal friction deviates from the described one: by a third of it, as a standard deviation.
fn worn(cylinders: [Cylinder; 2], seed: u64) -> [Cylinder; 2] {
    let mut noise = Noise::channel(seed, SEALS);
    cylinders.map(|c| Cylinder {
        friction: c.friction * (1.0 + SEALS_STD * noise.normal()).max(0.2),
        ..c
    })
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
