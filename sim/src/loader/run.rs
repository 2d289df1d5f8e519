//! Options of a simulation.

use std::fmt;

use super::effects::{Effects, PayloadReport};
use super::scenario::Scenario;
use super::sensors::Grade;
use super::tier::{Size, Tier};
use crate::cylinder::Gauges;
use crate::fault::{Fault, InvalidFault};

/// Options of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The manoeuvre.
    pub scenario: Scenario,
    /// Payload that a load cycle picks up and every other scenario carries from the start \[kg\]. `None` is the scenario's own
    /// (1500 kg in a load cycle, otherwise 0).
    pub payload: Option<f64>,
    /// Sampling rate \[Hz\].
    pub rate: f64,
    /// Seed of the machine, the road, the driver and the noise.
    pub seed: u64,
    /// Separate seed of the machine, so that one machine can do several runs.
    pub machine_seed: Option<u64>,
    /// Seed of another machine whose tyres this one has: slip stiffness, radii, relaxation.
    pub tyres_seed: Option<u64>,
    /// Separate seed of the road, so that several runs use the same one.
    pub road_seed: Option<u64>,
    /// Position on the road from which the machine drives back \[m\]; `None` for the forward direction.
    pub turned_at: Option<f64>,
    /// The sensors.
    pub grade: Grade,
    /// Knowledge of the machine.
    pub tier: Tier,
    /// The machine's size.
    pub size: Size,
    /// Pressure sensors of the lift cylinders, with lift and tilt angle; `None` if the machine has none.
    pub gauges: Option<Gauges>,
    /// Effects that the reference plant omits.
    pub effects: Effects,
    /// Faults of the sensors.
    pub faults: Vec<Fault>,
    /// Duration \[s\]; `None` is the scenario's own. A longer run continues as a work cycle (a cruise continues as a cruise).
    pub duration: Option<f64>,
}

impl Run {
    /// A scenario at 100 Hz with resolver-grade sensors on an exactly known machine.
    pub fn new(scenario: Scenario) -> Self {
        Self {
            scenario,
            payload: None,
            rate: 100.0,
            seed: 0,
            machine_seed: None,
            tyres_seed: None,
            road_seed: None,
            turned_at: None,
            grade: Grade::Resolver,
            tier: Tier::A,
            size: Size::Reference,
            gauges: None,
            effects: Effects::default(),
            faults: Vec::new(),
            duration: None,
        }
    }

    /// A working machine with these effects; it has loads unless all payloads are reported.
    pub fn at_work(effects: Effects) -> Self {
        let reported = effects.payload_reported == PayloadReport::All;
        Self {
            effects,
            ..Self::new(if reported {
                Scenario::WorkCycle
            } else {
                Scenario::LoadCycle
            })
        }
    }

    pub(super) fn check(&self) -> Result<(), InvalidRun> {
        let duration = self.duration.unwrap_or(0.0);
        let payload = self.payload.unwrap_or(0.0);
        if !(1.0..=10_000.0).contains(&self.rate) {
            Err(InvalidRun(format!(
                "rate {} Hz: expected 1 to 10000",
                self.rate
            )))
        } else if !(0.0..1e9).contains(&duration) {
            Err(InvalidRun(format!(
                "duration {duration} s: expected a number that is not negative"
            )))
        } else if !(0.0..=0.64 * self.size.machine().mass).contains(&payload) {
            Err(InvalidRun(format!(
                "payload {payload} kg: expected 0 to {:.0} (the machine tips beyond)",
                0.64 * self.size.machine().mass
            )))
        } else {
            Ok(())
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

impl From<InvalidFault> for InvalidRun {
    fn from(fault: InvalidFault) -> Self {
        Self(fault.to_string())
    }
}
