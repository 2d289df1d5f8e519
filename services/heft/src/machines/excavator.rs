//! The excavator on the command line.

mod figures;

use messages::{ExcavatorSensors, ExcavatorTruth};
use runtime::Source;
use sim::excavator::{Run, Scenario};

use super::{Figure, Typed, bad_run, no_scenario};
use crate::failure::Failure;
use crate::plan::Plan;

pub(super) struct Excavator;

impl Typed for Excavator {
    type Signals = recording::Excavator;
    const ABOUT: &'static str = "Swing inertia, damping, torque, payload";
    const USUAL: &'static str = "base";
    const SHOWN: &'static str = "cycle";
    const SCENARIOS: &'static [(&'static str, &'static str)] = Scenario::ALL;

    fn simulator(
        plan: &Plan,
    ) -> Result<impl Source<Sensors = ExcavatorSensors, Truth = ExcavatorTruth>, Failure> {
        let scenario = Scenario::parse(&plan.scenario)
            .ok_or_else(|| no_scenario(&plan.scenario, Scenario::ALL))?;
        let mut run = Run::new(scenario);
        (run.payload, run.rate, run.seed) = (plan.payload, plan.rate, plan.seed);
        run.duration = plan.duration.unwrap_or(run.duration);
        sensor::SimulatedExcavator::new(&run).map_err(bad_run)
    }

    fn evaluate(options: &evaluate::Options) -> Result<evaluate::Report, evaluate::Error> {
        evaluate::excavator(options)
    }

    fn figures() -> Result<Vec<Figure>, Failure> {
        figures::all()
    }
}
