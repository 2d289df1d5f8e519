//! `heft run`: a pipeline of processes, from its first sample to its summary.

mod args;
mod many;

use std::path::{Path, PathBuf};

use config::Description;
use messages::Machine;
use runtime::{Domain, realtime};
use steps::loads::{LoadCounter, Options};
use steps::stages::Pipeline;
use view::live::{Server, SharedLoads};

pub use self::args::RunArgs;
use self::args::{Equipment, Pace};
use crate::cli::DescriptionArgs;
use crate::failure::Failure;
use crate::fault::Fault;
use crate::fleet::Fleet;
use crate::fleet_run::FleetRun;
use crate::group;
use crate::machines;
use crate::outputs::CanOutput;
use crate::parts::Reserved;
use crate::plan::Plan;
use crate::signals::Signals;
use crate::small_file;
use crate::sources::{self, LiveInput};
use crate::spin::{self, Spinners};
use crate::state::Memory;
use crate::summary;
use crate::supervisor::{End, Supervisor};
use crate::watch::{Show, Watch};

/// Reads the description that `--config` and `--set` make.
pub fn description(machine: Machine, args: &DescriptionArgs) -> Result<Description, Failure> {
    let mut description = match &args.config {
        None => Description::default_of(machine),
        Some(path) => {
            let text = small_file::text(path).map_err(|e| Failure::file("read", path, &e))?;
            Description::parse(&text, &path.display().to_string(), Some(machine))?
        }
    };
    if description.machine() != machine {
        return Err(Failure::input(
            format!(
                "the description is for the {}, not for the {machine}",
                description.machine()
            ),
            args.config
                .as_deref()
                .unwrap_or(Path::new("--config"))
                .display(),
            "give the description of this machine, or name the other one",
        ));
    }
    let class = args.class.map(|mass| config::class(machine, mass));
    let sets: Vec<&String> = class.iter().flatten().chain(&args.set).collect();
    description.set_all(&sets)?;
    Ok(description)
}

/// A folder for a run that has none of its own: `runs/MACHINE-TIME`.
fn default_folder(machine: &str) -> PathBuf {
    let seconds = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |d| d.as_secs());
    PathBuf::from("runs").join(format!("{machine}-{seconds}-{}", std::process::id()))
}

fn now_ms() -> u64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    now.map_or(0, |d| d.as_millis() as u64)
}

/// Makes the folder of a run.
pub fn folder(out: Option<&Path>, machine: &str) -> Result<PathBuf, Failure> {
    let folder = out.map_or_else(|| default_folder(machine), Path::to_path_buf);
    std::fs::create_dir_all(&folder).map_err(|e| Failure::folder(&folder, &e))?;
    Ok(folder)
}

/// What describes the machine of a run. Where nobody describes a simulated one, its cylinders are described as they are.
fn described(args: &RunArgs, pressures: bool) -> DescriptionArgs {
    let given = &args.description;
    let is_simulated = args.input.is_none() && given.config.is_none() && given.class.is_none();
    let mut with = given.clone();
    if is_simulated && pressures {
        with.set = machines::entry(args.machine).simulated_cylinders();
        with.set.extend(given.set.iter().cloned());
    }
    with
}

/// The plan that the arguments describe, without a place for its recording.
fn plan(args: &RunArgs) -> Result<(Plan, Description), Failure> {
    let machine = args.machine;
    let pressures = !args.without.contains(&Equipment::Pressure);
    let description = description(machine, &described(args, pressures))?;
    let rate = args.rate.unwrap_or(description.rate());
    if let Some(duration) = args.duration
        && (duration.is_nan() || duration <= 0.0)
    {
        return Err(Failure::input(
            format!("a run cannot last {duration} s"),
            "--duration",
            "give a positive number of seconds",
        ));
    }
    let methods = Pipeline::of(machine).methods(args.method.as_deref())?;
    let scenario = args.scenario.as_deref();
    let plan = Plan {
        machine,
        scenario: scenario
            .unwrap_or(machines::entry(machine).usual_scenario())
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
        realtime: args.rt,
        cores: cores(args),
        spinners: args.spin.as_deref().map_or(Ok(Spinners::new()), |wanted| {
            spin::spinners(Pipeline::of(machine), wanted, args.probe.is_some())
        })?,
        restored: None,
        fleet: Fleet::of(&args.fleet)?,
        begun_ms: now_ms(),
        run: match (&args.fleet.site, &args.fleet.machine_id) {
            (Some(site), Some(machine)) => FleetRun::draw().count(site, machine),
            _ => FleetRun::draw(),
        },
        version: env!("CARGO_PKG_VERSION").to_owned(),
        recording: PathBuf::new(),
        limits: args.limits.clone(),
        group: args.group.as_deref().map(group::id).transpose()?,
        probe: args.probe.as_deref().map(absolute).transpose()?,
        probe_listens: args.probe_listens,
    };
    Ok((plan, description))
}

/// The plan of a pipeline that can be started, with a place for its recording.
fn pipeline_plan(args: &RunArgs) -> Result<Plan, Failure> {
    let (mut plan, description) = plan(args)?;
    check(&plan, &description)?;
    let methods: Vec<&str> = plan.methods.values().map(String::as_str).collect();
    tell_idle_keys(&description, &methods);
    let folder = absolute(&folder(args.out.as_deref(), args.machine.name())?)?;
    if let Some(group) = plan.group {
        group::share(&folder, group)?;
    }
    plan.recording = recording::reserve(&folder)?;
    Ok(plan)
}

/// Opens the memory of earlier runs, and puts what it restores into the plan.
fn remember(file: &Path, plan: &mut Plan) -> Result<Memory, Failure> {
    let file = absolute(file)?;
    let mut description = plan.description()?;
    let (memory, said) = Memory::open(&file, &mut description, &plan.methods)?;
    eprintln!("{said}");
    plan.description = description.to_toml();
    plan.restored = Some(said);
    Ok(memory)
}

/// Warns of keys that were set and do nothing.
pub fn tell_idle_keys(description: &Description, methods: &[&str]) {
    for idle in steps::idle_keys(description, methods) {
        eprintln!("warning: {idle}");
    }
}

/// Builds every part of the plan once, so that a mistake is told before any process starts.
fn check(plan: &Plan, description: &Description) -> Result<(), Failure> {
    for (stage, row) in plan.pipeline().rows() {
        row.start(description, plan.method(stage.name))?;
    }
    if let Some(output) = &plan.output {
        output.outgoing(plan.machine)?;
    }
    machines::entry(plan.machine).check_source(plan)
}

/// The input of a run: a file, or a live source as it was named.
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

fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    std::path::absolute(path).map_err(|e| Failure::file("find", path, &e))
}

/// Cores for the stages: those that were named, or the last one; none without `--rt`.
fn cores(args: &RunArgs) -> Vec<usize> {
    let mut cores: Vec<usize> = args.core.iter().chain(&args.spread).copied().collect();
    if args.rt && cores.is_empty() {
        cores.extend(realtime::cores().pop());
    }
    cores
}

/// Keeps this process, and those that it starts, to one core.
fn keep_to(core: usize) -> Result<(), Failure> {
    let cores = realtime::cores();
    let kept = if cores.contains(&core) {
        realtime::keep_to(&[core]).map_err(|error| error.to_string())
    } else {
        Err("this program may not run there".into())
    };
    kept.map_err(|error| {
        let cores: Vec<String> = cores.iter().map(usize::to_string).collect();
        Failure::input(
            format!("core {core}: {error}"),
            "--core",
            format!("one of {}", cores.join(", ")),
        )
    })
}

/// A domain of this name, or one of this process's own.
pub fn domain(name: Option<&str>, suffix: &str) -> Result<Domain, Failure> {
    Ok(match name {
        Some(name) => Domain::new(name)?,
        None => Domain::new(&format!("run-{}{suffix}", std::process::id()))?,
    })
}

/// Where the live line goes.
fn show(args: &RunArgs) -> Show {
    match (args.live_lines, args.quiet) {
        (true, _) => Show::Lines,
        (false, true) => Show::Nothing,
        (false, false) => Show::Terminal,
    }
}

/// What is watched of a run, and the server of its page, which ends when it is dropped.
fn watch(
    args: &RunArgs,
    machine: Machine,
    loads: &SharedLoads,
) -> Result<(Watch, Option<Server>), Failure> {
    let page = args
        .view
        .map(|addr| crate::live::start(addr, machine, loads.clone()))
        .transpose()?;
    let (feed, server) = page.unzip();
    // What the user asked for is told first, whichever process makes it.
    let pipeline = Pipeline::of(machine);
    let asked = args.method.as_deref().and_then(|m| pipeline.with_method(m));
    let told = asked.and_then(|stage| stage.output());
    let mut watch = Watch::new(machine, told.or(pipeline.main_output()), feed, show(args));
    watch.count_loads(
        loads.clone(),
        args.target.is_some() || args.input.is_some() || args.live_lines,
    );
    Ok((watch, server))
}

/// `heft run`
pub fn run(args: &RunArgs) -> Result<(), Failure> {
    if args.scenario.as_deref() == Some("list") {
        let all = machines::entry(args.machine).scenarios();
        print!("{}", machines::scenario_lines(&all));
        return Ok(());
    }
    if !args.rt
        && let Some(core) = args.core
    {
        keep_to(core)?;
    }
    if let Some(count) = args.machines {
        return many::run(args, count.get());
    }
    for name in Domain::remove_leftovers() {
        eprintln!("removed what the killed run `{name}` had left in shared memory");
    }
    let mut plan = pipeline_plan(args)?;
    let _reserved = Reserved(plan.recording.clone());
    if !plan.spinners.is_empty() {
        spin::keep_off(&plan.spinners);
    }
    let memory = args.state.as_deref();
    let memory = memory.map(|f| remember(f, &mut plan)).transpose()?;
    let machine = plan.machine;
    let loads = SharedLoads::new(LoadCounter::new(
        &plan.description()?,
        Options {
            target: args.target,
            ..Options::default()
        },
    ));
    let (mut watch, _server) = watch(args, machine, &loads)?;
    watch.remember(memory);
    let (recording, group) = (plan.recording.clone(), plan.group);
    if !(args.quiet || args.live_lines) || !sources::is_simulated(&plan) {
        eprintln!("{}", sources::words(&plan));
    }
    let domain = domain(args.domain.as_deref(), "")?;
    let span = tracing::Span::current();
    span.record("process", "supervisor");
    span.record("machine", machine.name());
    span.record("domain", domain.name());
    let supervisor = Supervisor::start(&domain, plan, watch, Signals::catch()?)?;
    let (end, watch) = supervisor.run()?;
    if let End::Refused(error) = end {
        return Err(Failure::told(error));
    }
    let report = (!args.no_report)
        .then(|| summary::report(&recording))
        .flatten();
    if let (Some(report), Some(group)) = (&report, group) {
        group::share(report, group)?;
    }
    let told = summary::Told {
        is_story: args.live_lines,
        is_verbose: args.verbose,
    };
    print!(
        "{}",
        summary::text(machine, &watch, &recording, report.as_deref(), told)
    );
    if !args.live_lines {
        tell_loads(&loads);
    }
    verdict(&end, &watch, args.require_trust)
}

/// What was carried, where anything was.
fn tell_loads(loads: &SharedLoads) {
    let mut counter = loads.lock();
    let last = counter.finish().truck;
    let (machine, all) = (counter.machine(), counter.ledger().all());
    if all.loads == 0 {
        return;
    }
    for load in counter.loads() {
        println!("{}", view::loads::line(machine, load));
    }
    if let Some(truck) = last {
        println!("{}", view::loads::truck_line(&truck));
    }
}

fn verdict(end: &End, watch: &Watch, require_trust: bool) -> Result<(), Failure> {
    if let End::Failed(reason) = end {
        return Err(Failure::answer_is_no(format!(
            "the run ended early: {reason}\n  where: the supervisor\n  what to do: see the messages above; the recording holds what was seen"
        )));
    }
    let faults = watch.faults();
    let lost: Vec<String> = faults
        .iter()
        .filter(|fault| fault.costs_the_status())
        .map(Fault::words)
        .collect();
    if !lost.is_empty() {
        return Err(Failure::answer_is_no(format!(
            "the run lost something: {}\n  where: this run\n  what to do: see `docs/reliability.md`; estimates and recording are good but for that",
            lost.join("; ")
        )));
    }
    if require_trust {
        summary::require_trust(summary::trust_age(watch))?;
    }
    Ok(())
}
