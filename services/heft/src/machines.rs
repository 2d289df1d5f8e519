//! What the command line needs of a machine beyond the tables of the libraries: a row each.

mod excavator;
mod loader;

use std::ffi::OsString;
use std::io::Read;
use std::path::Path;

use config::Description;
use messages::{Envelope, Machine, Message};
use recording::csv::{self, EstimateRows};
use recording::{Map, Sensors};
use runtime::{Source, Worker};
use view::estimate::Estimate;

use crate::args::EstimationArgs;
use crate::commands::calibrate::args::CalibrateArgs;
use crate::commands::estimate::args::EstimateArgs;
use crate::commands::estimate::look::Look;
use crate::commands::estimate::one;
use crate::failure::Failure;
use crate::plan::Plan;
use crate::serve::{self, Form, Machines, Out, Played, Rows};
use crate::signals::Signals;
use crate::sources;
use crate::way::{method, way};

/// A cylinder as the keys of a table of a description.
fn cylinder_settings(table: &str, c: &sim::cylinder::Cylinder) -> Vec<String> {
    [
        ("count", c.count),
        ("head_area", c.head_area),
        ("rod_area", c.rod_area),
        ("base_distance", c.base_distance),
        ("rod_distance", c.rod_distance),
        ("angle", c.angle),
        ("friction", c.friction),
        // A maker's data: the simulated seals differ by a third.
        ("friction_std", 0.5 * c.friction),
    ]
    .map(|(key, value)| format!("{table}.{key}={value:?}"))
    .into()
}

/// A figure: its name and the SVG.
pub type Figure = (String, String);

/// Seed of every run that is drawn.
const SEED: u64 = 1;

macro_rules! entries {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// Everything that the command line asks of a machine.
        pub fn entry(machine: Machine) -> &'static dyn Entry {
            match machine {
                $( Machine::$machine => &$module::$machine, )*
            }
        }
    };
}

messages::machines!(entries);

/// A machine as the command line sees it.
pub trait Entry: Sync {
    /// The scenario of a run that names none.
    fn usual_scenario(&self) -> &'static str;
    /// The scenario of the demonstration.
    fn shown_scenario(&self) -> &'static str;
    /// What the demonstration states of the simulated machine beside the defaults, as `KEY=VALUE`.
    fn shown_settings(&self) -> &'static [&'static str];
    /// The cylinders of the simulated machine, as `KEY=VALUE` of its description.
    fn simulated_cylinders(&self) -> Vec<String>;
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
    /// Shares the samples of many machines among shards started with these arguments.
    ///
    /// # Errors
    /// The input cannot be read, or a shard cannot go on.
    fn route(
        &self,
        input: Box<dyn Read>,
        form: Form,
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
        form: Form,
    ) -> Result<(), Failure>;
    /// `heft estimate` of one input.
    ///
    /// # Errors
    /// The input cannot be read, or the output not written.
    fn estimate(
        &self,
        args: &EstimateArgs,
        file: &Path,
        output: &Path,
        description: &Description,
    ) -> Result<(), Failure>;
    /// Takes an input through the steps of a method, and shows each sample and its estimate.
    ///
    /// # Errors
    /// The input cannot be read, or does not fit the method.
    fn follow(
        &self,
        with: &EstimationArgs,
        file: &Path,
        description: &Description,
        see: &mut dyn FnMut(&Envelope),
    ) -> Result<(), Failure>;
    /// `heft calibrate`.
    ///
    /// # Errors
    /// The recordings cannot be read, or do not tell the parameters.
    fn calibrate(&self, args: &CalibrateArgs, description: &Description) -> Result<(), Failure>;
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

/// Says of the estimate of a row what later rows know.
type Later<E> = Box<dyn Fn(usize, &mut E)>;

/// A machine with its types: what [`Entry`] is made of.
trait Typed: Sync {
    /// What its sensors measure.
    type Sensors: Sensors;
    /// What is estimated of it.
    type Estimate: Estimate + csv::Estimate;
    const USUAL: &'static str;
    const SHOWN: &'static str;
    /// What the demonstration states beside the defaults.
    const SHOWN_SETTINGS: &'static [&'static str];
    /// What looks at its samples.
    type Look: Look<Self::Sensors>;

    /// The cylinders of the simulated machine, as `KEY=VALUE` of its description.
    fn simulated_cylinders() -> Vec<String> {
        Vec::new()
    }
    /// Names and texts of the scenarios.
    fn scenarios() -> Vec<(String, String)>;
    /// The simulator of a plan.
    fn simulator(
        plan: &Plan,
    ) -> Result<
        impl Source<Sensors = Self::Sensors, Truth = <Self::Sensors as Sensors>::Truth> + 'static,
        Failure,
    >;
    /// Refuses samples that the method cannot use.
    fn check(
        _description: &Description,
        _method: &str,
        _first: &Self::Sensors,
    ) -> Result<(), Failure> {
        Ok(())
    }
    /// What later rows know of each row, where the method can tell.
    fn past(
        _description: &Description,
        _method: &str,
        _rows: impl Iterator<Item = Self::Sensors>,
    ) -> Result<Later<Self::Estimate>, Failure> {
        Err(Failure::input(
            format!(
                "the {}'s estimators have no smoother",
                Self::Sensors::MACHINE
            ),
            "--smooth",
            "leave it out",
        ))
    }
    /// Finds the machine's own parameters in recordings, where heft can.
    fn calibrate(_args: &CalibrateArgs, _description: &Description) -> Result<(), Failure> {
        Err(Failure::input(
            format!("heft cannot calibrate the {}", Self::Sensors::MACHINE),
            "heft calibrate",
            "describe the machine by hand",
        ))
    }
    fn evaluate(options: &evaluate::Options) -> Result<evaluate::Report, evaluate::Error>;
    fn figures() -> Result<Vec<Figure>, Failure>;
}

impl<M: Typed> Entry for M {
    fn usual_scenario(&self) -> &'static str {
        M::USUAL
    }

    fn shown_scenario(&self) -> &'static str {
        M::SHOWN
    }

    fn shown_settings(&self) -> &'static [&'static str] {
        M::SHOWN_SETTINGS
    }

    fn simulated_cylinders(&self) -> Vec<String> {
        M::simulated_cylinders()
    }

    fn scenarios(&self) -> Vec<(String, String)> {
        M::scenarios()
    }

    fn check_source(&self, plan: &Plan) -> Result<(), Failure> {
        sources::check::<M::Sensors, _>(plan, || M::simulator(plan))
    }

    fn serve_source(&self, worker: Worker, plan: &Plan) -> Result<(), Failure> {
        sources::serve::<M::Sensors, _>(worker, plan, || M::simulator(plan))
    }

    fn route(
        &self,
        input: Box<dyn Read>,
        form: Form,
        map: Option<&Map>,
        shards: usize,
        arguments: &[OsString],
    ) -> Result<(), Failure> {
        let header = EstimateRows::<M::Estimate>::new(u32::MAX).header();
        let rows = Rows::begin(Out::standard(), form, &header, Vec::new())?;
        serve::route::<M::Sensors>(input, form, map, shards, arguments, rows)
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
        let rows = Rows::begin(out, Form::Table, &header, flags)?;
        let make = |plan: &Plan| sources::not_live::<M::Sensors, _>(plan, || M::simulator(plan));
        serve::play::<M::Sensors>(machines, make, rows, shards, arguments, signals)
    }

    fn quantities(&self) -> Vec<&'static str> {
        headlines::<M::Estimate>().map(|p| p.label).collect()
    }

    fn serve_shard(
        &self,
        description: &Description,
        method: &str,
        every: f64,
        form: Form,
    ) -> Result<(), Failure> {
        serve::serve_shard::<M::Sensors, M::Estimate>(description, method, every, form)
    }

    fn estimate(
        &self,
        args: &EstimateArgs,
        file: &Path,
        output: &Path,
        description: &Description,
    ) -> Result<(), Failure> {
        let map = sources::map(args.with.map.as_deref())?;
        let samples = recording::open::<M::Sensors>(file, map.as_ref())?;
        hint_at_names::<M::Sensors>(file, map.as_ref());
        let method = method(description.machine(), args.with.method.as_deref());
        if let Some((first, _)) = samples.rows()?.next() {
            M::check(description, method, &first)?;
        }
        samples.check()?;
        let look = M::Look::of(description);
        if !args.smooth {
            let put = |_, _: &mut M::Estimate| {};
            return one::run(args, output, description, samples, look, put);
        }
        let put = M::past(description, method, samples.rows()?.map(|(row, _)| row))?;
        one::run(args, output, description, samples, look, put)
    }

    fn follow(
        &self,
        with: &EstimationArgs,
        file: &Path,
        description: &Description,
        see: &mut dyn FnMut(&Envelope),
    ) -> Result<(), Failure> {
        let map = sources::map(with.map.as_deref())?;
        let samples = recording::open::<M::Sensors>(file, map.as_ref())?;
        let method = method(description.machine(), with.method.as_deref());
        if let Some((first, _)) = samples.rows()?.next() {
            M::check(description, method, &first)?;
        }
        let mut stages = way(description, method)?;
        for (sample, _) in samples.rows()? {
            let sample = sample.envelope();
            see(&sample);
            let mut message = Some(sample);
            for (_, step) in &mut stages {
                message = message.and_then(|m| step.answer(&m));
            }
            if let Some(estimate) = message {
                see(&estimate);
            }
        }
        samples.check()?;
        crate::parts::tell_lacks(&samples.lacks())
    }

    fn calibrate(&self, args: &CalibrateArgs, description: &Description) -> Result<(), Failure> {
        M::calibrate(args, description)
    }

    fn evaluate(&self, options: &evaluate::Options) -> Result<evaluate::Report, evaluate::Error> {
        M::evaluate(options)
    }

    fn figures(&self) -> Result<Vec<Figure>, Failure> {
        M::figures()
    }
}

/// Speaks of columns of a table that are left out and look like signals that it lacks.
fn hint_at_names<S: Sensors>(file: &Path, map: Option<&recording::Map>) {
    let is_table = recording::Kind::by_name(file) == Some(recording::Kind::Table);
    if map.is_some() || !is_table {
        return;
    }
    for (column, signal) in recording::csv::misspelt::<S>(file) {
        eprintln!("the column {column} is not used; did you mean {signal}?");
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
            "dig, lift, swing, dump, return; the machine is as its machine file says".to_owned()
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
