//! One service of a run, as a process or on a thread.

use clap::Args;
use messages::Message;
use messages::channels::{Channel, Visitor, of_machine};
use runtime::{Arrival, Control, Domain, Identity, Setup, Wake, Worker, run_probe, run_sink};
use steps::stages::{Role, Row, Stage};

use crate::failure::Failure;
use crate::machines;
use crate::plan::{Plan, state_identity};

/// `heft service`
#[derive(Debug, Args)]
pub struct ServiceArgs {
    /// Name in the table of processes
    pub name: String,
    /// Domain of the run
    #[arg(long)]
    pub domain: String,
    /// How often it was started before
    #[arg(long, default_value_t = 0)]
    pub restarts: u32,
}

/// Runs the service `name` in this process until the run ends.
pub fn serve(args: &ServiceArgs) -> Result<(), Failure> {
    let domain = Domain::new(&args.domain)?;
    let plan = Plan::read(&domain)?;
    domain.enter()?;
    let stages = plan.pipeline().stages;
    let Some(stage) = stages.iter().find(|p| p.name == args.name) else {
        let names: Vec<&str> = stages.iter().map(|p| p.name).collect();
        return Err(Failure::input(
            format!("there is no service `{}`", args.name),
            "heft service",
            format!("one of {}", names.join(", ")),
        ));
    };
    let span = tracing::Span::current();
    span.record("process", stage.name);
    span.record("machine", plan.machine.name());
    span.record("domain", &args.domain);
    span.record("restarts", args.restarts);
    run(stage, args.restarts, Control::of_worker()?, &domain, &plan)
}

/// Runs a stage on this thread until the run ends; the domain has been entered before.
pub fn run(
    stage: &'static Stage,
    restarts: u32,
    control: Control,
    domain: &Domain,
    plan: &Plan,
) -> Result<(), Failure> {
    let mut stages = plan.pipeline().stages.iter();
    let index = stages.position(|p| p.name == stage.name);
    let setup = Setup {
        identity: Identity {
            process: index.unwrap_or_default() as u32,
            restarts,
            name: stage.name,
        },
        realtime: (plan.realtime && stage.priority > 0)
            .then(|| (stage.priority, core(plan, stage))),
        spins_on: plan.spinners.get(stage.name).copied(),
        period_ns: (1e9 / plan.rate) as u64,
    };
    let worker = Worker::start(setup, control)?;
    match &stage.role {
        Role::Source { .. } => (machines::entry(plan.machine).serve_source)(worker, plan),
        Role::Step(row) => serve_step(worker, plan, stage, *row),
        Role::Sink => serve_logger(worker, plan, domain),
        Role::Probe(channel) => serve_probe(worker, plan, channel),
        Role::Sender => serve_sender(worker, plan),
    }
}

/// The core of a process: cores are taken in turn along the chain.
fn core(plan: &Plan, stage: &Stage) -> Option<usize> {
    let turn = plan.pipeline().hops_before(stage) % plan.cores.len().max(1);
    plan.cores.get(turn).copied()
}

fn serve_step(worker: Worker, plan: &Plan, stage: &Stage, row: &dyn Row) -> Result<(), Failure> {
    let method = plan.method(stage.name);
    let fits = state_identity(&plan.description, stage.name, method);
    let process = row.prepare(&plan.description()?, method, fits)?;
    Ok(process(worker)?)
}

fn serve_logger(worker: Worker, plan: &Plan, domain: &Domain) -> Result<(), Failure> {
    let channels: Vec<_> = of_machine(plan.machine).collect();
    let limits = logger::Limits {
        group: plan.group,
        ..plan.limits.of_logger()
    };
    let (metadata, mark) = (plan.metadata(), domain.mark_file());
    let logger = logger::Logger::create(&plan.recording, &metadata, limits, &mark)?;
    let logger = run_sink(worker, &channels, plan.lossless, logger)?;
    Ok(logger.finish()?)
}

/// Sends estimates to a CAN bus.
fn serve_sender(worker: Worker, plan: &Plan) -> Result<(), Failure> {
    let Some(output) = &plan.output else {
        return Ok(());
    };
    let outgoing = output.outgoing(plan.machine)?;
    let channels = outgoing.channels();
    let writer = logger::BusWriter::new(&output.interface, outgoing);
    run_sink(worker, &channels, false, writer)?;
    Ok(())
}

fn serve_probe(worker: Worker, plan: &Plan, channel: &'static Channel) -> Result<(), Failure> {
    let Some(file) = &plan.probe else {
        return Ok(());
    };
    let arrivals = channel.payload.visit(Probe {
        worker,
        channel,
        // Number of samples of the run with a margin; of ten minutes for an endless run.
        capacity: (plan.duration.unwrap_or(600.0) * plan.rate) as usize + 1000,
        wake: if plan.probe_listens {
            Wake::Event
        } else {
            Wake::Bell
        },
    })?;
    let mut text = String::from("sequence,sensor_ns,filter_ns,estimate_ns,received_ns\n");
    for a in arrivals {
        use std::fmt::Write;
        let _ = writeln!(
            text,
            "{},{},{},{},{}",
            a.sequence, a.sensor_ns, a.filter_ns, a.estimate_ns, a.received_ns
        );
    }
    std::fs::write(file, text).map_err(|e| Failure::file("write", file, &e))
}

struct Probe {
    worker: Worker,
    channel: &'static Channel,
    capacity: usize,
    wake: Wake,
}

impl Visitor for Probe {
    type Output = Result<Vec<Arrival>, runtime::Error>;

    fn visit<M: Message>(self) -> Self::Output {
        run_probe::<M>(self.worker, self.channel, self.capacity, self.wake)
    }
}
