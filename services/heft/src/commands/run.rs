//! `heft run`: a pipeline of processes, from its first sample to its summary.

mod args;
mod many;
mod plan;

use std::path::{Path, PathBuf};

use messages::Machine;
use runtime::{Domain, realtime};
use steps::loads::{LoadCounter, Options};
use steps::stages::Pipeline;
use view::live::{Server, SharedLoads};

use self::args::Pace;
pub use self::args::RunArgs;
pub use self::plan::folder;
use self::plan::{absolute, pipeline_plan, tell_size};
use crate::doubts::AnyDoubts;
use crate::failure::Failure;
use crate::group;
use crate::machines;
use crate::parts::Reserved;
use crate::plan::Plan;
use crate::results;
use crate::signals::Signals;
use crate::sources;
use crate::spin;
use crate::state::Memory;
use crate::summary;
use crate::supervisor::{End, Supervisor};
use crate::watch::{Show, Watch};

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

/// Restricts this process, and those that it starts, to one core.
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

/// The watch of a run, and the server of its page, which ends when it is dropped.
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
    // The requested method is the headline, whichever process computes it.
    let pipeline = Pipeline::of(machine);
    let asked = args.method.as_deref().and_then(|m| pipeline.with_method(m));
    let headline = asked.and_then(|stage| stage.output());
    let mut watch = Watch::new(
        machine,
        headline.or(pipeline.main_output()),
        feed,
        show(args),
    );
    watch.count_loads(
        loads.clone(),
        args.target.is_some() || args.input.is_some() || args.live_lines,
    );
    Ok((watch, server))
}

/// `heft run`
pub fn run(args: &RunArgs) -> Result<(), Failure> {
    if args.scenario.as_deref() == Some("list") {
        let all = (machines::entry(args.machine).scenarios)();
        print!("{}", machines::scenario_lines(&all));
        return Ok(());
    }
    if !args.rt
        && let Some(core) = args.core
    {
        keep_to(core)?;
    }
    if let Some(count) = args.machines {
        return many::run(args, count as usize);
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
    results::check(vec![&plan.recording], &[(memory, &|_| true)])?;
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
    if plan.input.is_some() {
        let doubts = (machines::entry(machine).doubts)(&plan.description()?);
        watch.doubt(doubts);
    }
    let (recording, group) = (plan.recording.clone(), plan.group);
    if !(args.quiet || args.live_lines) || !sources::is_simulated(&plan) {
        eprintln!("{}", sources::words(&plan));
    }
    tell_size(args, &plan)?;
    let domain = domain(args.domain.as_deref(), "")?;
    let span = tracing::Span::current();
    span.record("process", "supervisor");
    span.record("machine", machine.name());
    span.record("domain", domain.name());
    // A run that is refused before it starts is not counted.
    if let (Some(site), Some(machine)) = (&args.fleet.site, &args.fleet.machine_id) {
        plan.run = plan.run.count(site, machine);
    }
    let supervisor = Supervisor::start(&domain, plan, watch, Signals::catch()?)?;
    let (end, watch) = supervisor.run()?;
    if let End::Refused(error) = end {
        return Err(Failure::reported(error));
    }
    let report = report(args, &recording, group)?;
    let detail = summary::Detail {
        is_story: args.live_lines,
        is_verbose: args.verbose,
    };
    print!(
        "{}",
        summary::text(machine, &watch, &recording, report.as_deref(), detail)
    );
    if !args.live_lines {
        tell_loads(&loads);
    }
    if let Some(doubts) = watch.doubts() {
        doubts.tell();
    }
    verdict(&end, &watch, args)
}

/// Makes the report, if it is wanted, and shares it with the group.
fn report(
    args: &RunArgs,
    recording: &Path,
    group: Option<u32>,
) -> Result<Option<PathBuf>, Failure> {
    if args.no_report {
        return Ok(None);
    }
    let report = summary::report(recording);
    if let (Some(report), Some(group)) = (&report, group) {
        group::share(report, group)?;
    }
    Ok(report)
}

/// Prints the loads, if any, and the times in which none was weighed.
fn tell_loads(loads: &SharedLoads) {
    let mut counter = loads.lock();
    let last = counter.finish().truck;
    for outage in view::loads::outages(&counter) {
        for line in view::words::wrapped(&outage, 79) {
            println!("{line}");
        }
    }
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
    if let Some(guessed) = counter.guessed() {
        println!("{guessed}");
    }
    if let Some(shown) = counter.shown_empty() {
        println!("{shown}");
    }
}

fn verdict(end: &End, watch: &Watch, args: &RunArgs) -> Result<(), Failure> {
    if let End::Failed(reason) = end {
        return Err(Failure::answer_is_no(format!(
            "the run ended early: {reason}\n  where: the supervisor\n  what to do: see the messages above; the recording holds what was seen"
        )));
    }
    let faults = watch.faults();
    let lost: Vec<String> = faults
        .iter()
        .filter(|fault| fault.costs_the_status())
        .map(|fault| watch.fault_words(fault))
        .collect();
    if !lost.is_empty() {
        let is_hurried =
            args.input.as_deref() == Some(Path::new("-")) && args.pace == Pace::Realtime;
        let remedy = if is_hurried {
            "standard input that comes faster than real time, such as a file, needs --pace max; "
        } else {
            ""
        };
        return Err(Failure::answer_is_no(format!(
            "the run lost something: {}\n  where: this run\n  what to do: {remedy}see `docs/reliability.md`; estimates and recording are good but for that",
            lost.join("; ")
        )));
    }
    if args.require_trust {
        summary::require_trust(summary::trust_age(watch))?;
    }
    watch.doubts().map_or(Ok(()), AnyDoubts::judge)
}
