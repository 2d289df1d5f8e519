//! One service of a run, in a process of its own.

use messages::channels::{
    Channel, ChannelOf, EXCAVATOR_SENSORS, EXCAVATOR_TRUTH, LOADER_SENSORS, LOADER_TRUTH, Visitor,
    of_machine,
};
use messages::{Machine, Message};
use runtime::{
    Arrival, Begin, Domain, Identity, Pace, Setup, Wake, Worker, now_ns, run_live, run_probe,
    run_sink, run_source,
};
use steps::stages::{Role, Row, Stage};

use crate::failure::Failure;
use crate::plan::Plan;
use crate::sources::{self, LiveInput, can_bus, excavator_source, loader_source};

/// A live source that was started again leaves at least this gap in the time of the data [ns].
const AFTER_RESTART_NS: u64 = 100_000_000;

/// Is the service `name` of a run until the run ends.
pub fn serve(name: &str, domain: &str, restarts: u32) -> Result<(), Failure> {
    let domain = Domain::new(domain)?;
    let plan = Plan::read(&domain)?;
    domain.enter()?;
    let stages = plan.pipeline().stages;
    let Some(index) = stages.iter().position(|p| p.name == name) else {
        let names: Vec<&str> = stages.iter().map(|p| p.name).collect();
        return Err(Failure::input(
            format!("there is no service `{name}`"),
            "heft service",
            format!("one of {}", names.join(", ")),
        ));
    };
    let stage = &stages[index];
    let setup = Setup {
        identity: Identity {
            process: index as u32,
            restarts,
            name: stage.name,
        },
        realtime: (plan.realtime && stage.priority > 0)
            .then(|| (stage.priority, core(&plan, stage))),
        period_ns: (1e9 / plan.rate) as u64,
    };
    let worker = Worker::start(setup)?;
    match &stage.role {
        Role::Source { .. } => serve_source(worker, &plan),
        Role::Step(row) => serve_step(worker, &plan, stage, *row),
        Role::Sink => serve_logger(worker, &plan),
        Role::Probe(channel) => serve_probe(worker, &plan, channel),
        Role::Sender => serve_sender(worker, &plan),
    }
}

/// The core of a process: they are taken in turn along the chain.
fn core(plan: &Plan, stage: &Stage) -> Option<usize> {
    let turn = plan.pipeline().hops_before(stage) % plan.cores.len().max(1);
    plan.cores.get(turn).copied()
}

fn pace(plan: &Plan) -> Pace {
    if plan.lossless {
        Pace::Lossless
    } else {
        Pace::RealTime
    }
}

fn serve_source(worker: Worker, plan: &Plan) -> Result<(), Failure> {
    let pace = pace(plan);
    if let Some(live) = sources::live(plan) {
        return match plan.machine {
            Machine::Excavator => serve_live::<recording::Excavator>(
                worker,
                plan,
                &live,
                &EXCAVATOR_SENSORS,
                &EXCAVATOR_TRUTH,
            ),
            Machine::Loader => {
                serve_live::<recording::Loader>(worker, plan, &live, &LOADER_SENSORS, &LOADER_TRUTH)
            }
        };
    }
    Ok(match plan.machine {
        Machine::Excavator => run_source(
            worker,
            &EXCAVATOR_SENSORS,
            &EXCAVATOR_TRUTH,
            pace,
            excavator_source(plan)?,
        ),
        Machine::Loader => run_source(
            worker,
            &LOADER_SENSORS,
            &LOADER_TRUTH,
            pace,
            loader_source(plan)?,
        ),
    }?)
}

/// A live source. After a restart its first sample gets the time since the run began, or comes
/// shortly after the latest if the data were ahead of that.
fn serve_live<M: recording::Machine>(
    mut worker: Worker,
    plan: &Plan,
    live: &LiveInput,
    sensors: &ChannelOf<M::Sensors>,
    truth: &ChannelOf<M::Truth>,
) -> Result<(), Failure> {
    let pace = pace(plan);
    let start = |begin: Begin, restarts: u32| {
        let since = now_ns().saturating_sub(begin.start_ns);
        let latest = begin.latest_ns + AFTER_RESTART_NS;
        if restarts == 0 {
            0.0
        } else {
            since.max(latest) as f64 / 1e9
        }
    };
    Ok(match live {
        LiveInput::Can(interface) => {
            let mut bus = can_bus::<M>(plan, interface)?;
            run_live(
                worker,
                sensors,
                truth,
                Pace::RealTime,
                plan.duration,
                |b, r| {
                    bus.begin_at(start(b, r));
                    bus
                },
            )
        }
        LiveInput::Lines => {
            let input = worker
                .take_input()
                .ok_or_else(|| Failure::internal("the supervisor handed over no standard input"))?;
            let mut lines = sources::lines::<M>(plan, input)?;
            run_live(worker, sensors, truth, pace, plan.duration, |b, r| {
                lines.begin_at(start(b, r));
                lines
            })
        }
    }?)
}

fn serve_step(worker: Worker, plan: &Plan, stage: &Stage, row: &dyn Row) -> Result<(), Failure> {
    let process = row.prepare(&plan.description()?, plan.method(stage.name))?;
    Ok(process(worker)?)
}

fn serve_logger(worker: Worker, plan: &Plan) -> Result<(), Failure> {
    let channels: Vec<_> = of_machine(plan.machine).collect();
    let limits = plan.limits.of_logger();
    let logger = logger::Logger::create(&plan.recording, &plan.metadata(), limits)?;
    Ok(run_sink(worker, &channels, plan.lossless, logger)?)
}

/// Sends estimates to a CAN bus.
fn serve_sender(worker: Worker, plan: &Plan) -> Result<(), Failure> {
    let Some(output) = &plan.output else {
        return Ok(());
    };
    let outgoing = output.outgoing(plan.machine)?;
    let channels = [outgoing.channel];
    let writer = logger::BusWriter::new(&output.interface, outgoing);
    Ok(run_sink(worker, &channels, false, writer)?)
}

fn serve_probe(worker: Worker, plan: &Plan, channel: &'static Channel) -> Result<(), Failure> {
    let Some(file) = &plan.probe else {
        return Ok(());
    };
    let arrivals = channel.payload.visit(Probe {
        worker,
        channel,
        // As many as the run has samples, with some to spare; ten minutes where it has no end.
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
