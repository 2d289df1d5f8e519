//! The excavator on the command line.

mod calibrate;
mod figures;

use config::Description;
use messages::{ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth};
use runtime::Source;
use sensor::excavator::Simulator;
use sim::cylinder::Gauges;
use sim::excavator::{Effects, Run, Scenario, Size, Work, cases};
use sim::named;
use steps::described;

use super::{Figure, Later, MachineKind, all_scenarios, bad_run, no_scenario};
use crate::commands::calibrate::args::CalibrateArgs;
use crate::failure::Failure;
use crate::plan::Plan;

pub(super) struct Excavator;

impl MachineKind for Excavator {
    type Sensors = ExcavatorSensors;
    type Estimate = ExcavatorEstimate;
    type Look = checks::excavator::Fits;
    const USUAL: &'static str = "base";
    const SHOWN: &'static str = "cycle";
    const SHOWN_SETTINGS: &'static [&'static str] = &[];
    const SIMULATED_MASS: (&'static str, f64) = ("machine.operating_mass", 5500.0);
    const SIMULATED_CYLINDERS: fn() -> Vec<String> = sensor::excavator::drawing;
    const EVALUATE: fn(&evaluate::Options) -> Result<evaluate::Report, evaluate::Error> =
        evaluate::excavator::evaluate;
    const FIGURES: fn() -> Result<Vec<Figure>, Failure> = figures::all;

    fn scenarios() -> Vec<(String, String)> {
        let cases = cases();
        let work = "dig, lift, swing, dump, return";
        all_scenarios(work, Scenario::ALL, cases.iter().map(|c| (c.0, c.1)))
    }

    fn simulator(
        plan: &Plan,
    ) -> Result<impl Source<Sensors = ExcavatorSensors, Truth = ExcavatorTruth> + 'static, Failure>
    {
        let mut at_work = cases().into_iter();
        if let Some((_, _, effects)) = at_work.find(|c| named::scenario(c.0, c.1) == plan.scenario)
        {
            return work(plan, effects);
        }
        let scenario = Scenario::parse(&plan.scenario)
            .ok_or_else(|| no_scenario(&plan.scenario, &Self::scenarios()))?;
        let mut run = Run::new(scenario);
        (run.payload, run.rate, run.seed) = (plan.payload, plan.rate, plan.seed);
        run.gauges = plan.pressures.then(Gauges::default);
        run.duration = plan.duration.unwrap_or(run.duration);
        Ok(Simulated {
            rows: Simulator::new(&run).map_err(bad_run)?,
            duration: f64::INFINITY,
        })
    }

    fn check(
        description: &Description,
        method: &str,
        first: &ExcavatorSensors,
    ) -> Result<(), Failure> {
        Ok(steps::excavator::check_columns(
            described(description)?,
            method,
            first,
        )?)
    }

    fn past(
        description: &Description,
        method: &str,
        rows: impl Iterator<Item = ExcavatorSensors>,
    ) -> Result<Later<ExcavatorEstimate>, Failure> {
        let past = steps::excavator::past(described(description)?, method, rows)?;
        Ok(Box::new(move |row, estimate| {
            if let Some(Some(moment)) = past.get(row) {
                moment.put(estimate);
            }
        }))
    }

    fn calibrate(args: &CalibrateArgs, description: &Description) -> Result<(), Failure> {
        calibrate::calibrate(args, described(description)?)
    }
}

/// Sampling rate of the machines at work \[Hz\], and default duration of their runs \[s\].
const WORK_RATE: f64 = 100.0;
const WORK_DURATION: f64 = 60.0;

/// The reference machine at work with these effects.
fn work(plan: &Plan, effects: Effects) -> Result<Simulated, Failure> {
    if plan.rate != WORK_RATE {
        return Err(bad_run(format!(
            "a machine at work is sampled at {WORK_RATE} Hz"
        )));
    }
    if plan.payload.is_some() {
        return Err(bad_run("a machine at work has its own loads"));
    }
    let mut work = Work::new(Size::reference(), effects, plan.seed);
    if plan.pressures {
        work = work.with_gauges(plan.seed);
    }
    Ok(Simulated {
        rows: Simulator::at_work(work),
        duration: plan.duration.unwrap_or(WORK_DURATION),
    })
}

/// A simulated machine, for some time.
struct Simulated {
    rows: Simulator,
    duration: f64,
}

impl Source for Simulated {
    type Sensors = ExcavatorSensors;
    type Truth = ExcavatorTruth;

    fn next(&mut self) -> Option<(ExcavatorSensors, ExcavatorTruth)> {
        let next = self.rows.next()?;
        (next.0.stamp.time <= self.duration).then_some(next)
    }
}
