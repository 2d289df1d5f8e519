//! A scenario, integrated once and measured with any seed.

use crate::Error;
use sim::excavator::{Course, Exact, Instruments, Plant, Row, Scenario, Sensors, Truth};
use sim::fault::Fault;

/// Sampling rate of the evaluation [Hz].
const RATE: f64 = 100.0;

/// A scenario with one payload, sampled at 100 Hz without noise.
#[derive(Clone, Debug)]
pub struct Case {
    /// The scenario.
    pub scenario: Scenario,
    /// The plant with its solved torque.
    pub plant: Plant,
    exact: Vec<Exact>,
}

impl Case {
    /// Integrates a scenario; without `payload`, with the scenario's own.
    pub fn new(scenario: Scenario, payload: Option<f64>) -> Self {
        Self::of(scenario, scenario.plant(payload), scenario.start())
    }

    /// Integrates a scenario of another machine, with the payload for which its torque is solved.
    pub fn of(scenario: Scenario, plant: Plant, start: f64) -> Self {
        let duration = scenario.duration() + scenario.start() - start;
        let exact = Course::new(plant.clone(), start, RATE, duration).collect();
        Self {
            scenario,
            plant,
            exact,
        }
    }

    /// The same case with the record beginning at a later time \[s\].
    pub fn from(mut self, time: f64) -> Self {
        self.exact.retain(|sample| sample.time >= time - 1e-9);
        self
    }

    /// The samples of one seed.
    pub fn rows(&self, seed: u64, noise: Sensors, faults: &[Fault]) -> Result<Vec<Row>, Error> {
        let mut instruments = Instruments::new(noise, faults, seed).map_err(Error::refused)?;
        Ok(self
            .exact
            .iter()
            .filter_map(|exact| instruments.measure(exact, None))
            .collect())
    }

    /// The truth at a time \[s\].
    pub fn truth(&self, time: f64) -> Truth {
        let nearest = self
            .exact
            .iter()
            .min_by(|a, b| (a.time - time).abs().total_cmp(&(b.time - time).abs()));
        nearest.map(|sample| sample.truth).unwrap_or_default()
    }

    /// The exact samples.
    pub fn exact(&self) -> &[Exact] {
        &self.exact
    }
}

/// The loads of the paper's three cases [kg].
pub const PAYLOADS: [f64; 3] = [0.0, 288.0, 423.0];

/// The three loads of a scenario.
pub fn three(scenario: Scenario) -> [Case; 3] {
    PAYLOADS.map(|payload| Case::new(scenario, Some(payload)))
}
