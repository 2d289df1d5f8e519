//! The wheel loader on the command line.

mod figures;

use messages::{LoaderSensors, LoaderTruth};
use runtime::Source;
use sim::loader::{CASES, Run, Scenario, Tier};
use sim::named;

use super::{Figure, Typed, all_scenarios, bad_run, no_scenario};
use crate::failure::Failure;
use crate::plan::Plan;

pub(super) struct Loader;

impl Typed for Loader {
    type Signals = recording::Loader;
    type Estimate = messages::LoaderEstimate;
    const ABOUT: &'static str = "Centre of gravity, slip stiffness, digging force";
    const USUAL: &'static str = "work-cycle";
    const SHOWN: &'static str = "work-cycle";

    fn scenarios() -> Vec<(String, String)> {
        all_scenarios(Scenario::ALL, CASES.iter().map(|c| (c.0, c.1)))
    }

    fn simulator(
        plan: &Plan,
    ) -> Result<impl Source<Sensors = LoaderSensors, Truth = LoaderTruth> + 'static, Failure> {
        let mut at_work = CASES.iter();
        let mut run = match at_work.find(|c| named::scenario(c.0, c.1) == plan.scenario) {
            Some((_, _, effects)) => Run::at_work(*effects),
            None => Run::new(
                Scenario::parse(&plan.scenario)
                    .ok_or_else(|| no_scenario(&plan.scenario, &Self::scenarios()))?,
            ),
        };
        run.payload = plan.payload.or(run.payload);
        (run.rate, run.seed) = (plan.rate, plan.seed);
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
