//! Where samples come from: the simulator or a recording.

use std::path::Path;

use messages::{ExcavatorSensors, ExcavatorTruth, LoaderSensors, LoaderTruth, Machine};
use recording::Map;
use runtime::Source;

use crate::failure::Failure;
use crate::plan::Plan;

/// A source of either kind.
pub enum Either<A, B> {
    /// From the simulator.
    Simulated(A),
    /// From a recording.
    Recorded(B),
}

impl<S, T, A, B> Source for Either<A, B>
where
    S: messages::Message,
    T: messages::Message,
    A: Source<Sensors = S, Truth = T>,
    B: Source<Sensors = S, Truth = T>,
{
    type Sensors = S;
    type Truth = T;

    fn next(&mut self) -> Option<(S, T)> {
        match self {
            Self::Simulated(source) => source.next(),
            Self::Recorded(source) => source.next(),
        }
    }
}

/// Reads a signal map.
pub fn map(path: Option<&Path>) -> Result<Option<Map>, Failure> {
    Ok(path.map(Map::read).transpose()?)
}

/// The excavator's samples.
pub fn excavator_source(
    plan: &Plan,
) -> Result<impl Source<Sensors = ExcavatorSensors, Truth = ExcavatorTruth>, Failure> {
    use sim::excavator::{Run, Scenario};
    if let Some(input) = &plan.input {
        let map = map(plan.map.as_deref())?;
        let rows = recording::load_excavator(input, map.as_ref())?;
        return Ok(Either::Recorded(sensor::Recorded::new(limited(
            rows,
            plan.duration,
        ))));
    }
    let scenario = Scenario::parse(&plan.scenario)
        .ok_or_else(|| no_scenario(&plan.scenario, Scenario::ALL))?;
    let mut run = Run::new(scenario);
    (run.payload, run.rate, run.seed) = (plan.payload, plan.rate, plan.seed);
    run.duration = plan.duration.unwrap_or(run.duration);
    Ok(Either::Simulated(
        sensor::SimulatedExcavator::new(&run).map_err(bad_run)?,
    ))
}

/// The loader's samples.
pub fn loader_source(
    plan: &Plan,
) -> Result<impl Source<Sensors = LoaderSensors, Truth = LoaderTruth>, Failure> {
    use sim::loader::{Run, Scenario, Tier};
    if let Some(input) = &plan.input {
        let map = map(plan.map.as_deref())?;
        let rows = recording::load_loader(input, map.as_ref())?;
        return Ok(Either::Recorded(sensor::Recorded::new(limited(
            rows,
            plan.duration,
        ))));
    }
    let scenario = Scenario::parse(&plan.scenario)
        .ok_or_else(|| no_scenario(&plan.scenario, Scenario::ALL))?;
    let mut run = Run::new(scenario);
    (run.payload, run.rate, run.seed) = (plan.payload, plan.rate, plan.seed);
    (run.tier, run.duration) = (Tier::B, plan.duration);
    Ok(Either::Simulated(
        sensor::SimulatedLoader::new(&run).map_err(bad_run)?,
    ))
}

/// The rows of the first `duration` seconds.
fn limited<S: messages::Message, T>(mut rows: Vec<(S, T)>, duration: Option<f64>) -> Vec<(S, T)> {
    if let (Some(duration), Some((first, _))) = (duration, rows.first()) {
        let end = first.stamp().time + duration;
        let keep = rows
            .iter()
            .position(|(s, _)| s.stamp().time > end)
            .unwrap_or(rows.len());
        rows.truncate(keep);
    }
    rows
}

/// Whether the source of a plan can be made.
pub fn check(plan: &Plan) -> Result<(), Failure> {
    match plan.machine {
        Machine::Excavator => excavator_source(plan).map(drop),
        Machine::Loader => loader_source(plan).map(drop),
    }
}

fn bad_run(error: impl std::fmt::Display) -> Failure {
    Failure::input(
        error,
        "the simulator",
        "choose another --rate, --duration or --payload",
    )
}

/// The scenario of a run that names none.
pub fn usual(machine: Machine) -> &'static str {
    match machine {
        Machine::Excavator => "base",
        Machine::Loader => "work-cycle",
    }
}

/// The scenario of the demonstration.
pub fn shown(machine: Machine) -> &'static str {
    match machine {
        Machine::Excavator => "cycle",
        Machine::Loader => "work-cycle",
    }
}

/// The scenarios of a machine, a line each.
pub fn scenarios(machine: Machine) -> String {
    lines(match machine {
        Machine::Excavator => sim::excavator::Scenario::ALL,
        Machine::Loader => sim::loader::Scenario::ALL,
    })
}

fn lines(all: &[(&str, &str)]) -> String {
    all.iter()
        .map(|(name, text)| format!("    {name:<20} {text}\n"))
        .collect()
}

fn no_scenario(name: &str, all: &[(&str, &str)]) -> Failure {
    let nearest = config::nearest(name, all.iter().map(|(n, _)| *n));
    let hint = nearest.map_or(String::new(), |n| format!(" (did you mean `{n}`?)"));
    Failure::input(
        format!("there is no scenario `{name}`{hint}"),
        "--scenario",
        format!("choose one of\n{}", lines(all).trim_end()),
    )
}
