//! What the command line needs of a machine beyond the tables of the libraries: a row each.

mod excavator;
mod loader;

use std::ffi::OsString;
use std::io::Read;

use config::Description;
use messages::Machine;
use recording::Map;
use recording::csv::EstimateRows;
use runtime::{Source, Worker};

use crate::failure::Failure;
use crate::plan::Plan;
use crate::serve::{self, Machines, Out, Played, Rows};
use crate::signals::Signals;
use crate::sources;

/// A figure: its name and the SVG.
pub type Figure = (String, String);

/// Seed of every run that is drawn.
const SEED: u64 = 1;

/// Everything that the command line asks of a machine.
pub fn entry(machine: Machine) -> &'static dyn Entry {
    match machine {
        Machine::Excavator => &excavator::Excavator,
        Machine::Loader => &loader::Loader,
    }
}

/// A machine as the command line sees it.
pub trait Entry: Sync {
    /// What is estimated, for the help.
    fn about(&self) -> &'static str;
    /// The scenario of a run that names none.
    fn usual_scenario(&self) -> &'static str;
    /// The scenario of the demonstration.
    fn shown_scenario(&self) -> &'static str;
    /// Names and texts of the scenarios.
    fn scenarios(&self) -> Vec<(String, String)>;
    /// Whether the source of a plan can be made.
    ///
    /// # Errors
    /// It cannot; says why.
    fn check_source(&self, plan: &Plan) -> Result<(), Failure>;
    /// Is the source of a plan until the run ends.
    ///
    /// # Errors
    /// The source or a channel cannot be opened.
    fn serve_source(&self, worker: Worker, plan: &Plan) -> Result<(), Failure>;
    /// Shares the rows of a table among shards started with these arguments.
    ///
    /// # Errors
    /// The table cannot be read, or a shard cannot go on.
    fn route(
        &self,
        input: Box<dyn Read>,
        map: Option<&Map>,
        shards: usize,
        arguments: &[OsString],
    ) -> Result<(), Failure>;
    /// Plays the machines of a run to shards started with these arguments; a table of the estimates goes to `out`.
    ///
    /// # Errors
    /// A source cannot be made, or a shard cannot go on.
    fn play(
        &self,
        machines: &Machines,
        out: Out,
        shards: usize,
        arguments: &[OsString],
        signals: &Signals,
    ) -> Result<Played, Failure>;
    /// Names of the quantities that have a verdict.
    fn quantities(&self) -> Vec<&'static str>;
    /// Is such a shard.
    ///
    /// # Errors
    /// The description does not fit, or the router is gone.
    fn serve_shard(
        &self,
        description: &Description,
        method: &str,
        every: f64,
    ) -> Result<(), Failure>;
    /// The tables of `heft evaluate`.
    ///
    /// # Errors
    /// The table is unknown.
    fn evaluate(&self, options: &evaluate::Options) -> Result<evaluate::Report, evaluate::Error>;
    /// The figures of the paper.
    ///
    /// # Errors
    /// A run cannot be simulated.
    fn figures(&self) -> Result<Vec<Figure>, Failure>;
}

/// A machine with its types: what [`Entry`] is made of.
trait Typed: Sync {
    /// How its samples are read.
    type Signals: recording::Machine;
    /// What is estimated of it.
    type Estimate: recording::csv::Estimate + view::estimate::Estimate;
    const ABOUT: &'static str;
    const USUAL: &'static str;
    const SHOWN: &'static str;

    /// Names and texts of the scenarios.
    fn scenarios() -> Vec<(String, String)>;
    /// The simulator of a plan.
    fn simulator(
        plan: &Plan,
    ) -> Result<
        impl Source<
            Sensors = <Self::Signals as recording::Machine>::Sensors,
            Truth = <Self::Signals as recording::Machine>::Truth,
        > + 'static,
        Failure,
    >;
    fn evaluate(options: &evaluate::Options) -> Result<evaluate::Report, evaluate::Error>;
    fn figures() -> Result<Vec<Figure>, Failure>;
}

impl<M: Typed> Entry for M {
    fn about(&self) -> &'static str {
        M::ABOUT
    }

    fn usual_scenario(&self) -> &'static str {
        M::USUAL
    }

    fn shown_scenario(&self) -> &'static str {
        M::SHOWN
    }

    fn scenarios(&self) -> Vec<(String, String)> {
        M::scenarios()
    }

    fn check_source(&self, plan: &Plan) -> Result<(), Failure> {
        sources::check::<M::Signals, _>(plan, || M::simulator(plan))
    }

    fn serve_source(&self, worker: Worker, plan: &Plan) -> Result<(), Failure> {
        sources::serve::<M::Signals, _>(worker, plan, || M::simulator(plan))
    }

    fn route(
        &self,
        input: Box<dyn Read>,
        map: Option<&Map>,
        shards: usize,
        arguments: &[OsString],
    ) -> Result<(), Failure> {
        let header = EstimateRows::<M::Estimate>::new(u32::MAX).header();
        serve::route::<M::Signals>(input, map, shards, arguments, &header)
    }

    fn play(
        &self,
        machines: &Machines,
        out: Out,
        shards: usize,
        arguments: &[OsString],
        signals: &Signals,
    ) -> Result<Played, Failure> {
        let header = EstimateRows::<M::Estimate>::new(u32::MAX).header();
        let flags = headlines::<M::Estimate>().map(|p| p.trusted).collect();
        let rows = Rows::begin(out, &header, flags)?;
        let make = |plan: &Plan| sources::not_live::<M::Signals, _>(plan, || M::simulator(plan));
        serve::play::<M::Signals>(machines, make, rows, shards, arguments, signals)
    }

    fn quantities(&self) -> Vec<&'static str> {
        headlines::<M::Estimate>().map(|p| p.label).collect()
    }

    fn serve_shard(
        &self,
        description: &Description,
        method: &str,
        every: f64,
    ) -> Result<(), Failure> {
        type Sensors<M> = <<M as Typed>::Signals as recording::Machine>::Sensors;
        serve::serve_shard::<Sensors<M>, M::Estimate>(description, method, every)
    }

    fn evaluate(&self, options: &evaluate::Options) -> Result<evaluate::Report, evaluate::Error> {
        M::evaluate(options)
    }

    fn figures(&self) -> Result<Vec<Figure>, Failure> {
        M::figures()
    }
}

/// The parameters of an estimate that have a verdict.
fn headlines<E: view::estimate::Estimate>()
-> impl Iterator<Item = &'static view::estimate::Parameter<E, E::Truth>> {
    E::PARAMETERS.iter().filter(|p| p.headline())
}

/// The scenarios of a machine, a line each.
pub fn scenario_lines(all: &[(String, String)]) -> String {
    let width = all.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    all.iter()
        .map(|(name, text)| format!("    {name:<width$} {text}\n"))
        .collect()
}

/// The scenarios that have courses of their own, then the machines at work.
fn all_scenarios<'a>(
    courses: &[(&str, &str)],
    cases: impl Iterator<Item = (&'a str, &'a str)>,
) -> Vec<(String, String)> {
    let courses = courses
        .iter()
        .map(|(name, text)| ((*name).to_owned(), (*text).to_owned()));
    let work = cases.map(|(effect, severity)| {
        let text = if effect == "none" {
            "dig, lift, swing, dump, return; a machine that is what its description says".to_owned()
        } else {
            format!("the same with {effect} {severity}")
                .trim_end()
                .to_owned()
        };
        (sim::named::scenario(effect, severity), text)
    });
    courses.chain(work).collect()
}

fn no_scenario(name: &str, all: &[(String, String)]) -> Failure {
    let nearest = config::nearest(name, all.iter().map(|(n, _)| n.as_str()));
    let hint = nearest.map_or(String::new(), |n| format!(" (did you mean `{n}`?)"));
    Failure::input(
        format!("there is no scenario `{name}`{hint}"),
        "--scenario",
        format!("choose one of\n{}", scenario_lines(all).trim_end()),
    )
}

fn bad_run(error: impl std::fmt::Display) -> Failure {
    Failure::input(
        error,
        "the simulator",
        "choose another --rate, --duration or --payload",
    )
}
