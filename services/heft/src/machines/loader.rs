//! The wheel loader on the command line.

mod figures;

use messages::{LoaderSensors, LoaderTruth};
use runtime::Source;
use sim::loader::{Run, Scenario, Tier};

use super::{Figure, Typed, bad_run, no_scenario};
use crate::failure::Failure;
use crate::plan::Plan;

pub(super) struct Loader;

impl Typed for Loader {
    type Signals = recording::Loader;
    const ABOUT: &'static str = "Centre of gravity, slip stiffness, digging force";
    const USUAL: &'static str = "work-cycle";
    const SHOWN: &'static str = "work-cycle";
    const SCENARIOS: &'static [(&'static str, &'static str)] = Scenario::ALL;

    fn simulator(
        plan: &Plan,
    ) -> Result<impl Source<Sensors = LoaderSensors, Truth = LoaderTruth>, Failure> {
        let scenario = Scenario::parse(&plan.scenario)
            .ok_or_else(|| no_scenario(&plan.scenario, Scenario::ALL))?;
        let mut run = Run::new(scenario);
        (run.payload, run.rate, run.seed) = (plan.payload, plan.rate, plan.seed);
        (run.tier, run.duration) = (Tier::B, plan.duration);
        sensor::SimulatedLoader::new(&run).map_err(bad_run)
    }

    fn evaluate(options: &evaluate::Options) -> Result<evaluate::Report, evaluate::Error> {
        evaluate::loader(options)
    }

    fn figures() -> Result<Vec<Figure>, Failure> {
        figures::all()
    }
}
