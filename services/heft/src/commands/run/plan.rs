//! The plan that the arguments of `heft run` describe.

use std::path::{Path, PathBuf};

use config::Description;
use runtime::realtime;
use steps::stages::Pipeline;

use super::args::{Equipment, Pace, RunArgs};
use crate::args::{DescriptionArgs, description, tell_odd_keys};
use crate::failure::Failure;
use crate::fleet::Fleet;
use crate::fleet_run::FleetRun;
use crate::group;
use crate::machines;
use crate::outputs::CanOutput;
use crate::plan::Plan;
use crate::size;
use crate::sources::LiveInput;
use crate::spin::{self, Spinners};
use crate::target;

/// A folder for a run that has none of its own: `runs/MACHINE-TIME`.
fn default_folder(machine: &str) -> PathBuf {
    let seconds = runtime::since_1970().as_secs();
    PathBuf::from("runs").join(format!("{machine}-{seconds}-{}", std::process::id()))
}

/// Makes the folder of a run.
pub fn folder(out: Option<&Path>, machine: &str) -> Result<PathBuf, Failure> {
    let folder = out.map_or_else(|| default_folder(machine), Path::to_path_buf);
    std::fs::create_dir_all(&folder).map_err(|e| Failure::folder(&folder, &e))?;
    Ok(folder)
}

/// The plan of a pipeline that can be started, with a place for its recording.
pub(super) fn pipeline_plan(args: &RunArgs) -> Result<Plan, Failure> {
    let (mut plan, description) = Plan::of(args)?;
    check(&plan, &description)?;
    let methods: Vec<&str> = plan.methods.values().map(String::as_str).collect();
    tell_odd_keys(&description, &methods);
    size::tell_other_size(&plan, &description);
    let folder = absolute(&folder(args.out.as_deref(), args.machine.name())?)?;
    if let Some(group) = plan.group {
        group::share(&folder, group)?;
    }
    plan.recording = recording::reserve(&folder)?;
    Ok(plan)
}

/// Reports the assumed size of the machine whose data are the input.
pub(super) fn tell_size(args: &RunArgs, plan: &Plan) -> Result<(), Failure> {
    if let Some(input) = &args.input
        && let Some(note) = size::assumed(&plan.description()?, &args.description, input)?
    {
        eprintln!("{note}");
    }
    Ok(())
}

/// The description arguments of a run. Without a description, the true cylinders of a simulated machine are described.
pub(super) fn described(args: &RunArgs, pressures: bool) -> DescriptionArgs {
    let given = &args.description;
    let is_simulated = args.input.is_none() && given.config.is_none() && given.class.is_none();
    let mut with = given.clone();
    if is_simulated && pressures {
        with.set = (machines::entry(args.machine).simulated_cylinders)();
        with.set.extend(given.set.iter().cloned());
    }
    with
}

impl Plan {
    /// The plan that the arguments describe, without a place for its recording.
    pub(super) fn of(args: &RunArgs) -> Result<(Self, Description), Failure> {
        let machine = args.machine;
        let pressures = !args.without.contains(&Equipment::Pressure);
        let description = description(Some(machine), &described(args, pressures))?;
        if let Some(note) = target::doubt(args.target, &description)? {
            eprintln!("{note}");
        }
        let rate = args.rate.unwrap_or(description.rate());
        let methods = Pipeline::of(machine).methods(args.method.as_deref())?;
        let scenario = args.scenario.as_deref();
        let plan = Plan {
            machine,
            scenario: scenario
                .unwrap_or(machines::entry(machine).usual_scenario)
                .to_owned(),
            payload: args.payload,
            pressures,
            input: args.input.as_deref().map(input).transpose()?,
            map: args.map.as_deref().map(absolute).transpose()?,
            output: output(args)?,
            description: description.to_toml(),
            methods: methods
                .into_iter()
                .map(|(process, method)| (process.to_owned(), method))
                .collect(),
            duration: args.duration,
            rate,
            seed: args.seed,
            lossless: args.pace == Pace::Max,
            threads: args.threads,
            realtime: args.rt,
            cores: cores(args),
            spinners: args.spin.as_deref().map_or(Ok(Spinners::new()), |wanted| {
                spin::spinners(Pipeline::of(machine), wanted, args.probe.is_some())
            })?,
            restored: None,
            fleet: Fleet::of(&args.fleet)?,
            run: FleetRun::draw(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            recording: PathBuf::new(),
            limits: args.limits.clone(),
            group: args.group.as_deref().map(group::id).transpose()?,
            probe: args.probe.as_deref().map(absolute).transpose()?,
            probe_listens: args.probe_listens,
        };
        Ok((plan, description))
    }
}

/// Builds every part of the plan once, so that a mistake is reported before any process starts.
fn check(plan: &Plan, description: &Description) -> Result<(), Failure> {
    for (stage, row) in plan.pipeline().rows() {
        row.start(description, plan.method(stage.name))?;
    }
    if let Some(output) = &plan.output {
        output.outgoing(plan.machine)?;
    }
    (machines::entry(plan.machine).check_source)(plan)
}

/// The input of a run: a file, or a live source under its given name.
fn input(path: &Path) -> Result<PathBuf, Failure> {
    match LiveInput::of(path) {
        Some(_) => Ok(path.to_owned()),
        None => absolute(path),
    }
}

/// Where estimates are sent.
fn output(args: &RunArgs) -> Result<Option<CanOutput>, Failure> {
    let map = args.output_map.as_deref().map(absolute).transpose()?;
    let output = args.output.as_deref();
    output.map(|name| CanOutput::of(name, map)).transpose()
}

pub(super) fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    std::path::absolute(path).map_err(|e| Failure::file("find", path, &e))
}

/// Cores for the stages: the named ones, or the last one; none without `--rt`.
fn cores(args: &RunArgs) -> Vec<usize> {
    let mut cores: Vec<usize> = args.core.iter().chain(&args.spread).copied().collect();
    if args.rt && cores.is_empty() {
        cores.extend(realtime::cores().pop());
    }
    cores
}
