//! `heft run M --machines N`: runs many machines in few processes and writes one table of their estimates.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use recording::Output;
use steps::chain::{chain, method};

use super::args::RunArgs;
use super::plan::{absolute, described, folder};
use crate::args::tell_odd_keys;
use crate::commands::serve::{shard_arguments, usual_shards};
use crate::failure::Failure;
use crate::fault::counted;
use crate::machines;
use crate::many;
use crate::plan::Plan;
use crate::serve::{Machines, Out, Played, is_table};
use crate::signals::Signals;
use crate::sources::LiveInput;
use crate::{size, summary};

/// Name of the table in the folder of the run.
const TABLE: &str = "estimates.csv";

/// Runs `count` machines.
pub fn run(args: &RunArgs, count: usize) -> Result<(), Failure> {
    let (plan, description) = Plan::of(args)?;
    let (machine, entry) = (args.machine, machines::entry(args.machine));
    let method = method(machine, args.method.as_deref());
    chain(&description, method)?;
    tell_odd_keys(&description, &[method]);
    size::tell_other_size(&plan, &description);
    let inputs = args.input.as_deref().map(|input| inputs(input, count));
    let machines = Machines {
        plan: &plan,
        description: &description,
        inputs: inputs.transpose()?.unwrap_or_default(),
        count,
    };
    (entry.check_source)(&machines.plan(0))?;
    let folder = absolute(&folder(args.out.as_deref(), machine.name())?)?;
    let table = folder.join(TABLE);
    let out = Output::create("write the estimates", &table, &[], is_table)?;
    if !args.quiet {
        eprintln!("{}", words(&plan, count));
    }
    let given = described(args, plan.pressures);
    let arguments = shard_arguments(machine, method, &given, 0.0);
    let (signals, shards) = (Signals::catch()?, usual_shards().min(count));
    let played = (entry.play)(&machines, Out::File(out), shards, &arguments, &signals)?;
    println!("\n{machine}, {count} machines by {method} in {shards} processes");
    print!("{}", text(&(entry.quantities)(), &played, &table));
    let unanswered = played.samples.saturating_sub(played.served.answered);
    if unanswered > 0 {
        return Err(Failure::answer_is_no(format!(
            "{unanswered} of {} samples were not answered",
            played.samples
        )));
    }
    played.findings.report()
}

/// The recordings of the machines: the first `count` of the input.
fn inputs(input: &Path, count: usize) -> Result<Vec<PathBuf>, Failure> {
    let refused = |what: String, remedy: &str| Failure::input(what, "--machines, --input", remedy);
    if LiveInput::of(input).is_some() {
        let what = format!("{} is one machine, not {count}", input.display());
        let remedy = "leave --machines out, or give a folder of recordings; `heft serve` takes many machines from one table";
        return Err(refused(what, remedy));
    }
    let mut found = many::inputs(&[input.to_owned()], true)?;
    if found.len() < count {
        let recordings = if found.len() == 1 {
            "recording"
        } else {
            "recordings"
        };
        let what = format!(
            "{} holds {} {recordings}, not {count}",
            input.display(),
            found.len()
        );
        return Err(refused(what, "ask for fewer machines, or add recordings"));
    }
    found.truncate(count);
    found.iter().map(|f| absolute(f)).collect()
}

/// The source of the samples, in one line.
fn words(plan: &Plan, count: usize) -> String {
    match &plan.input {
        None => format!(
            "samples: simulated (scenario {}, seeds {} to {}): nothing is measured",
            plan.scenario,
            plan.seed,
            plan.seed.wrapping_add(count as u64 - 1)
        ),
        Some(folder) => format!("samples: {count} recordings in {}", folder.display()),
    }
}

/// The summary at the end.
fn text(quantities: &[&str], played: &Played, table: &Path) -> String {
    let mut out = String::new();
    let mut line = |text: String| {
        let _ = writeln!(out, "  {text}");
    };
    let Played {
        members,
        samples,
        late,
        served,
        ..
    } = played;
    let rows: u64 = members.iter().map(|m| m.rows).sum();
    line(format!(
        "{samples} samples in {:.1} s: {} refused, {} not answered, {late} sent later than a period; {} replaced",
        played.took.as_secs_f64(),
        served.answered.saturating_sub(rows),
        samples.saturating_sub(served.answered),
        counted(served.replaced.into(), "process", "processes"),
    ));
    for (at, quantity) in quantities.iter().enumerate() {
        let share = |flagged: u64, rows: u64| 100.0 * flagged as f64 / rows.max(1) as f64;
        let shares = members.iter().map(|m| share(m.flagged[at], m.rows));
        let (least, most) = shares.fold((100.0, 0.0), |(l, m): (f64, f64), s| (l.min(s), m.max(s)));
        let all = share(members.iter().map(|m| m.flagged[at]).sum(), rows);
        line(format!(
            "{quantity}: trusted in {all:.0} % of the rows, of a machine {least:.0} to {most:.0} %"
        ));
    }
    let each = |time: Duration| 1e6 * time.as_secs_f64() / (*samples).max(1) as f64;
    line(format!(
        "processor time a sample: {:.1} µs in those processes, {:.1} µs here (sources, sending, writing)",
        each(served.processor),
        each(played.own),
    ));
    line(format!("estimates  {}", summary::shown(table)));
    out
}
