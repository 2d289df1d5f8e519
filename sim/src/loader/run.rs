//! What to simulate.

use std::fmt;

use super::effects::{Effects, PayloadReport};
use super::scenario::Scenario;
use super::sensors::Grade;
use super::tier::{Size, Tier};
use crate::cylinder::Gauges;
use crate::fault::{Fault, InvalidFault};

/// What to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The manoeuvre.
    pub scenario: Scenario,
    /// Payload that a load cycle picks up and every other scenario carries from the start \[kg\]; none is
    /// the scenario's own (1500 kg in a load cycle, otherwise none).
    pub payload: Option<f64>,
    /// Samples per second \[Hz\].
    pub rate: f64,
    /// Determines the machine, the road, the driver and the noise.
    pub seed: u64,
    /// Determines the machine instead, so that one machine can do several runs.
    pub machine_seed: Option<u64>,
    /// Determines a machine whose tyres are on this one: slip stiffness, radii, relaxation.
    pub tyres_seed: Option<u64>,
    /// Determines the road instead, so that several runs go the same way.
    pub road_seed: Option<u64>,
    /// So far along the road the machine is turned round and drives back \[m\]; none drives there.
    pub turned_at: Option<f64>,
    /// The sensors.
    pub grade: Grade,
    /// How well the machine is known.
    pub tier: Tier,
    /// The machine's size.
    pub size: Size,
    /// Pressure sensors of the lift cylinders, with lift and tilt angle; none if the machine has none.
    pub gauges: Option<Gauges>,
    /// What the machine does that the reference plant leaves out.
    pub effects: Effects,
    /// What goes wrong.
    pub faults: Vec<Fault>,
    /// How long \[s\]; none is the scenario's own. A longer run goes on as a work cycle (a cruise goes on
    /// as a cruise).
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

    /// A machine at work with these effects: with loads, where they are not all reported.
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

/// A run that cannot be simulated.
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
