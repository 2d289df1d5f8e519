//! Where samples come from: the simulator or a recording.

use std::cmp::Ordering;
use std::os::fd::OwnedFd;
use std::path::Path;

use messages::{ExcavatorSensors, ExcavatorTruth, LoaderSensors, LoaderTruth, Machine};
use recording::{Map, Samples};
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

/// A source that nobody paces.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LiveInput {
    /// A CAN interface.
    Can(String),
    /// Standard input.
    Lines,
}

impl LiveInput {
    /// The live source that `--input` names: `can:INTERFACE` or `-`; none for a file.
    pub fn of(input: &Path) -> Option<Self> {
        match input.to_str()? {
            "-" => Some(Self::Lines),
            name => name.strip_prefix("can:").map(|i| Self::Can(i.to_owned())),
        }
    }
}

/// Whether the samples of a plan are the simulator's.
pub fn is_simulated(plan: &Plan) -> bool {
    plan.input.is_none()
}

/// Where the samples of a plan come from, in a line.
pub fn words(plan: &Plan) -> String {
    let Some(input) = &plan.input else {
        return format!(
            "samples: simulated (scenario {}, seed {}): nothing is measured",
            plan.scenario, plan.seed
        );
    };
    let map = plan.map.as_deref().map_or(String::new(), |map| {
        format!(" through the map {}", map.display())
    });
    match LiveInput::of(input) {
        Some(LiveInput::Can(interface)) => format!("samples: CAN interface {interface}, live{map}"),
        Some(LiveInput::Lines) => format!("samples: standard input, live{map}"),
        None => format!("samples: the recording {}{map}", input.display()),
    }
}

/// The frames of a CAN interface as samples.
pub fn can_bus<M: recording::Machine>(
    plan: &Plan,
    interface: &str,
) -> Result<sensor::CanBus<M>, Failure> {
    let Some(map) = map(plan.map.as_deref())? else {
        return Err(Failure::input(
            "a CAN bus needs a signal map",
            "--input",
            "give one with --map; it names the DBC file and the signals (`heft map LOG --dbc FILE` writes a first one)",
        ));
    };
    Ok(sensor::CanBus::new(interface, &map)?)
}

/// The lines that the run is given on its standard input as samples.
pub fn lines<M: recording::Machine>(
    plan: &Plan,
    input: OwnedFd,
) -> Result<sensor::Lines<M>, Failure> {
    let map = map(plan.map.as_deref())?;
    Ok(sensor::Lines::new(input, map, !plan.lossless)?)
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
        let samples = recording::open_excavator(input, map.as_ref())?;
        return Ok(Either::Recorded(recorded(samples, plan.duration)?));
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
        let samples = recording::open_loader(input, map.as_ref())?;
        return Ok(Either::Recorded(recorded(samples, plan.duration)?));
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

/// The samples of the first `duration` seconds, read as they are played.
fn recorded<S: messages::Message, T: messages::Message>(
    samples: Samples<S, T>,
    duration: Option<f64>,
) -> Result<sensor::Recorded<S, T>, Failure> {
    // They are read until the process ends.
    let samples: &'static Samples<S, T> = Box::leak(Box::new(samples));
    let mut end = None;
    let is_within = move |(sample, _): &(S, T)| {
        let time = sample.stamp().time;
        let end = *end.get_or_insert(time + duration.unwrap_or(f64::INFINITY));
        time.partial_cmp(&end) != Some(Ordering::Greater)
    };
    Ok(sensor::Recorded::new(samples.rows()?.take_while(is_within)))
}

/// Whether a file of samples can be read to its end.
fn check_file<S: messages::Message, T: messages::Message>(
    samples: &Samples<S, T>,
) -> Result<(), Failure> {
    samples.rows()?.for_each(drop);
    Ok(samples.check()?)
}

/// Whether the source of a plan can be made.
pub fn check(plan: &Plan) -> Result<(), Failure> {
    if live(plan).is_some() {
        return match plan.machine {
            Machine::Excavator => check_live::<recording::Excavator>(plan),
            Machine::Loader => check_live::<recording::Loader>(plan),
        };
    }
    let map = map(plan.map.as_deref())?;
    match (&plan.input, plan.machine) {
        (Some(file), Machine::Excavator) => {
            check_file(&recording::open_excavator(file, map.as_ref())?)
        }
        (Some(file), Machine::Loader) => check_file(&recording::open_loader(file, map.as_ref())?),
        (None, Machine::Excavator) => excavator_source(plan).map(drop),
        (None, Machine::Loader) => loader_source(plan).map(drop),
    }
}

/// The live source of a plan, if it has one.
pub fn live(plan: &Plan) -> Option<LiveInput> {
    plan.input.as_deref().and_then(LiveInput::of)
}

fn check_live<M: recording::Machine>(plan: &Plan) -> Result<(), Failure> {
    match live(plan) {
        Some(LiveInput::Can(interface)) => can_bus::<M>(plan, &interface).map(drop),
        _ => {
            recording::LineDecoder::<M>::new(map(plan.map.as_deref())?)?;
            Ok(())
        }
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
    named(match machine {
        Machine::Excavator => sim::excavator::Scenario::ALL,
        Machine::Loader => sim::loader::Scenario::ALL,
    })
}

fn named(all: &[(&str, &str)]) -> String {
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
        format!("choose one of\n{}", named(all).trim_end()),
    )
}
