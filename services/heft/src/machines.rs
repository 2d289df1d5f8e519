//! What the command line needs of each machine beyond the tables of the libraries, one entry per machine.

mod excavator;
mod loader;

use std::ffi::OsString;
use std::path::Path;

use checks::Look;
use config::Description;
use messages::{Envelope, Machine, Message};
use recording::Sensors;
use recording::csv::{self, EstimateRows};
use runtime::{Source, Worker};
use steps::chain::{chain, last_answer, method};
use view::estimate::Estimate;

use crate::args::EstimationArgs;
use crate::commands::calibrate::args::CalibrateArgs;
use crate::commands::estimate::args::EstimateArgs;
use crate::commands::estimate::one;
use crate::doubts::{AnyDoubts, Doubts, Seen};
use crate::failure::Failure;
use crate::limits;
use crate::plan::Plan;
use crate::serve::{self, Common, Form, Input, Machines, Out, Played, Rows};
use crate::signals::Signals;
use crate::sources;

/// A figure: its name and the SVG.
pub type Figure = (String, String);

/// Seed of the simulated runs in figures.
const SEED: u64 = 1;

macro_rules! entries {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The entry of a machine.
        pub fn entry(machine: Machine) -> &'static Entry {
            match machine {
                $( Machine::$machine => const { &Entry::of::<$module::$machine>() }, )*
            }
        }
    };
}

messages::machines!(entries);

/// Result of a function of an [`Entry`].
type Outcome<T = ()> = Result<T, Failure>;
/// Receives each truth, each sample and each estimate.
type See<'a> = &'a mut dyn FnMut(&Envelope);

/// A machine as the command line sees it: constants and functions. Each failure carries its message.
pub struct Entry {
    /// The default scenario of a run.
    pub usual_scenario: &'static str,
    /// The scenario of the demonstration.
    pub shown_scenario: &'static str,
    /// Settings of the demonstration beyond the defaults, as `KEY=VALUE`.
    pub shown_settings: &'static [&'static str],
    /// Key of the machine's mass, and the mass of the simulated reference machine \[kg\].
    pub simulated_mass: (&'static str, f64),
    /// Cylinder settings of the simulated machine, as `KEY=VALUE` of its description.
    pub simulated_cylinders: fn() -> Vec<String>,
    /// Names and texts of the scenarios.
    pub scenarios: fn() -> Vec<(String, String)>,
    /// Labels of the quantities with a verdict of their own.
    pub quantities: fn() -> Vec<&'static str>,
    /// Checks whether the source of a plan can be created.
    pub check_source: fn(&Plan) -> Outcome,
    /// Runs as the source of a plan until the run ends.
    pub serve_source: fn(Worker, &Plan) -> Outcome,
    /// Distributes the samples of many machines among shards.
    pub route: fn(Input, Form, Common<'_>) -> Outcome,
    /// Plays the machines of a run to this number of shards, started with these arguments, and writes a table of the estimates.
    pub play: fn(&Machines, Out, usize, &[OsString], &Signals) -> Outcome<Played>,
    /// Runs as a shard: description, method, least time between rows \[s\], form.
    pub serve_shard: fn(&Description, &str, f64, Form) -> Outcome,
    /// `heft estimate` of one input: arguments, input, output, description.
    pub estimate: fn(&EstimateArgs, &Path, &Path, &Description) -> Outcome,
    /// Runs the steps of a method over an input, and passes each truth, its sample and the estimate to the callback.
    pub follow: fn(&EstimationArgs, &Path, &Description, See<'_>) -> Outcome,
    /// What limits the intervals on an input with a signal map, under a description.
    pub limits: fn(&Path, Option<&Path>, &Description) -> Outcome<String>,
    /// Checks of the samples of a described machine.
    pub doubts: fn(&Description) -> Box<dyn AnyDoubts>,
    /// `heft calibrate`.
    pub calibrate: fn(&CalibrateArgs, &Description) -> Outcome,
    /// The tables of `heft evaluate`.
    pub evaluate: fn(&evaluate::Options) -> Result<evaluate::Report, evaluate::Error>,
    /// The figures of the paper.
    pub figures: fn() -> Outcome<Vec<Figure>>,
}

impl Entry {
    const fn of<M: MachineKind>() -> Self {
        Self {
            usual_scenario: M::USUAL,
            shown_scenario: M::SHOWN,
            shown_settings: M::SHOWN_SETTINGS,
            simulated_mass: M::SIMULATED_MASS,
            simulated_cylinders: M::SIMULATED_CYLINDERS,
            scenarios: M::scenarios,
            quantities: || M::Estimate::headlines().map(|p| p.label).collect(),
            check_source: |plan| sources::check::<M::Sensors, _>(plan, || M::simulator(plan)),
            serve_source: |worker, plan| {
                sources::serve::<M::Sensors, _>(worker, plan, || M::simulator(plan))
            },
            route: route::<M>,
            play: play::<M>,
            serve_shard: serve::serve_shard::<M::Sensors, M::Estimate>,
            estimate: estimate::<M>,
            follow: follow::<M>,
            limits: limits::<M>,
            doubts: |description| Box::new(Seen::<M::Look, M::Estimate>::of(description)),
            calibrate: M::calibrate,
            evaluate: M::EVALUATE,
            figures: M::FIGURES,
        }
    }
}

/// Replaces the estimate of a row by its smoothed estimate, which includes later rows.
type Later<E> = Box<dyn Fn(usize, &mut E)>;

/// A machine with its types, from which its [`Entry`] is built.
trait MachineKind {
    /// Message of its sensors.
    type Sensors: Sensors;
    /// Message of its estimates.
    type Estimate: Estimate;
    const USUAL: &'static str;
    const SHOWN: &'static str;
    /// Settings of the demonstration beyond the defaults.
    const SHOWN_SETTINGS: &'static [&'static str];
    /// Key of its mass, and the mass of the simulated machine \[kg\].
    const SIMULATED_MASS: (&'static str, f64);
    /// Checks of its samples.
    type Look: Look<Sensors = Self::Sensors> + Send + 'static;

    /// Cylinder settings of the simulated machine, as `KEY=VALUE` of its description.
    const SIMULATED_CYLINDERS: fn() -> Vec<String>;
    /// The tables of `heft evaluate`.
    const EVALUATE: fn(&evaluate::Options) -> Result<evaluate::Report, evaluate::Error>;
    /// The figures of the paper.
    const FIGURES: fn() -> Outcome<Vec<Figure>>;

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
    /// Smoother of the rows, if the method has one.
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
    /// Identifies the parameters of the machine from recordings, if heft can.
    fn calibrate(_args: &CalibrateArgs, _description: &Description) -> Result<(), Failure> {
        Err(Failure::input(
            format!("heft cannot calibrate the {}", Self::Sensors::MACHINE),
            "heft calibrate",
            "describe the machine by hand",
        ))
    }
}

fn route<M: MachineKind>(input: Input, form: Form, common: Common<'_>) -> Result<(), Failure> {
    let header = EstimateRows::<M::Estimate>::default().header();
    let rows = Rows::begin(Out::standard(), form, &header, Vec::new())?;
    serve::route::<M::Look>(input, form, common, rows)
}

fn play<M: MachineKind>(
    machines: &Machines,
    out: Out,
    shards: usize,
    arguments: &[OsString],
    signals: &Signals,
) -> Result<Played, Failure> {
    let header = EstimateRows::<M::Estimate>::default().header();
    let flags = M::Estimate::headlines().map(|p| p.trusted).collect();
    let rows = Rows::begin(out, Form::Table, &header, flags)?;
    let make = |plan: &Plan| sources::not_live::<M::Sensors, _>(plan, || M::simulator(plan));
    serve::play::<M::Look>(machines, make, rows, shards, arguments, signals)
}

fn estimate<M: MachineKind>(
    args: &EstimateArgs,
    file: &Path,
    output: &Path,
    description: &Description,
) -> Result<(), Failure> {
    let (samples, method) = opened::<M>(
        args.with.map.as_deref(),
        args.with.method.as_deref(),
        file,
        description,
    )?;
    samples.check()?;
    let map = sources::map(args.with.map.as_deref())?;
    let doubts = Doubts::<M::Look>::of(description).mapped(map);
    if !args.smooth {
        let put = |_, _: &mut M::Estimate| {};
        return one::run(args, output, description, samples, doubts, put);
    }
    let put = M::past(description, method, samples.rows()?.map(|(row, _)| row))?;
    one::run(args, output, description, samples, doubts, put)
}

fn follow<M: MachineKind>(
    with: &EstimationArgs,
    file: &Path,
    description: &Description,
    see: See<'_>,
) -> Result<(), Failure> {
    let (samples, method) = opened::<M>(
        with.map.as_deref(),
        with.method.as_deref(),
        file,
        description,
    )?;
    let mut chain = chain(description, method)?;
    let map = sources::map(with.map.as_deref())?;
    let mut doubts = Doubts::<M::Look>::of(description).mapped(map);
    for (sample, truth) in samples.rows()? {
        see(&truth.envelope());
        let message = sample.envelope();
        see(&message);
        let message = last_answer(&mut chain, message);
        message.iter().for_each(&mut *see);
        let estimate = message.as_ref().and_then(M::Estimate::inside);
        doubts.add(&sample, estimate.is_some_and(csv::Estimate::is_refused));
    }
    samples.check()?;
    doubts.tell();
    doubts.has_rows()?;
    doubts.judge(&samples.lacks())
}

fn limits<M: MachineKind>(
    file: &Path,
    map: Option<&Path>,
    description: &Description,
) -> Outcome<String> {
    let (samples, method) = opened::<M>(map, None, file, description)?;
    let rows = samples.rows()?.map(|(sample, _)| sample.envelope());
    let mut rows: Vec<Envelope> = rows.take(limits::ROWS + 1).collect();
    let part = if rows.len() > limits::ROWS {
        rows.pop();
        format!("the first {} rows of {}", limits::ROWS, file.display())
    } else {
        samples.check()?;
        file.display().to_string()
    };
    limits::table::<M::Estimate>(description, method, &rows, &part)
}

/// The samples of an input, checked for the method, and the method.
fn opened<'a, M: MachineKind>(
    map: Option<&Path>,
    asked: Option<&'a str>,
    file: &Path,
    description: &Description,
) -> Result<(SamplesOf<M::Sensors>, &'a str), Failure> {
    let map = sources::map(map)?;
    let samples = recording::open::<M::Sensors>(file, map.as_ref())?;
    hint_at_names::<M::Sensors>(file, map.as_ref());
    let method = method(description.machine(), asked);
    if let Some((first, _)) = samples.rows()?.next() {
        M::check(description, method, &first)?;
    }
    Ok((samples, method))
}

type SamplesOf<S> = recording::Samples<S, <S as Sensors>::Truth>;

/// Reports unused columns of a table whose names resemble signals that it lacks.
fn hint_at_names<S: Sensors>(file: &Path, map: Option<&recording::Map>) {
    let is_table = recording::Kind::by_name(file) == Some(recording::Kind::Table);
    if map.is_some() || !is_table {
        return;
    }
    for (column, signal) in recording::csv::misspelt::<S>(file) {
        let column = recording::OneLine(column);
        eprintln!("the column {column} is not used; did you mean {signal}?");
    }
}

/// The scenarios of a machine, one per line.
pub fn scenario_lines(all: &[(String, String)]) -> String {
    let width = all.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    all.iter()
        .map(|(name, text)| format!("    {name:<width$} {text}\n"))
        .collect()
}

/// All scenarios: the special courses, then a machine at work with each effect and severity.
fn all_scenarios<'a>(
    work: &str,
    courses: &[(&str, &str)],
    cases: impl Iterator<Item = (&'a str, &'a str)>,
) -> Vec<(String, String)> {
    let courses = courses
        .iter()
        .map(|(name, text)| ((*name).to_owned(), (*text).to_owned()));
    let cases = cases.map(|(effect, severity)| {
        let text = if effect == "none" {
            format!("{work}; the machine is as its machine file says")
        } else {
            format!("the same with {effect} {severity}")
                .trim_end()
                .to_owned()
        };
        (sim::named::scenario(effect, severity), text)
    });
    courses.chain(cases).collect()
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
