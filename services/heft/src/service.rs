//! One service of a run, in a process of its own.

use config::{Description, Kind};
use messages::channels::{
    EXCAVATOR_INERTIA_RLS, EXCAVATOR_INERTIA_UKF, EXCAVATOR_MOTION, EXCAVATOR_SENSORS,
    EXCAVATOR_TRUTH, LOADER_CG_EKF, LOADER_CG_UKF, LOADER_SENSORS, LOADER_TRUTH, of_machine,
};
use messages::{ExcavatorEstimate, LoaderEstimate};
use runtime::{
    Domain, Identity, Pace, Setup, Wake, Worker, mark_estimate, mark_filter, run_probe, run_sink,
    run_source, run_stage,
};

use crate::failure::Failure;
use crate::pipeline::{
    excavator_estimator, excavator_filter, excavator_regression, loader_baseline, loader_estimator,
};
use crate::plan::Plan;
use crate::processes::{self, Process};
use crate::sources::{excavator_source, loader_source};

/// Is the service `name` of a run until the run ends.
pub fn serve(name: &str, domain: &str, restarts: u32) -> Result<(), Failure> {
    let domain = Domain::new(domain)?;
    let plan = Plan::read(&domain)?;
    domain.enter()?;
    let table = processes::of_machine(plan.kind());
    let Some(index) = table.iter().position(|p| p.name == name) else {
        let names: Vec<&str> = table.iter().map(|p| p.name).collect();
        return Err(Failure::input(
            format!("there is no service `{name}`"),
            "heft service",
            format!("one of {}", names.join(", ")),
        ));
    };
    let process = &table[index];
    let setup = Setup {
        identity: Identity {
            process: index as u32,
            restarts,
            name: process.name,
        },
        realtime: (plan.realtime && process.priority > 0)
            .then(|| (process.priority, core(plan.kind(), process, &plan.cores))),
        period_ns: (1e9 / plan.rate) as u64,
    };
    let worker = Worker::start(setup)?;
    match (plan.description()?, process.name) {
        (_, "logger") => serve_logger(worker, &plan),
        (_, "probe") => serve_probe(worker, &plan),
        (Description::Excavator(d), name) => serve_excavator(worker, &plan, &d, name),
        (Description::Loader(d), name) => serve_loader(worker, &plan, &d, name),
    }
}

/// The core of a process: they are taken in turn along the chain.
fn core(machine: Kind, process: &Process, cores: &[usize]) -> Option<usize> {
    let turn = processes::hops_before(machine, process) % cores.len().max(1);
    cores.get(turn).copied()
}

fn pace(plan: &Plan) -> Pace {
    if plan.lossless {
        Pace::Lossless
    } else {
        Pace::RealTime
    }
}

fn serve_excavator(
    worker: Worker,
    plan: &Plan,
    d: &config::Excavator,
    name: &str,
) -> Result<(), Failure> {
    let (first, second) = (&plan.first_method, &plan.second_method);
    Ok(match name {
        "sensor" => run_source(
            worker,
            &EXCAVATOR_SENSORS,
            &EXCAVATOR_TRUTH,
            pace(plan),
            excavator_source(plan)?,
        ),
        "kalman" => run_stage(
            worker,
            &EXCAVATOR_SENSORS,
            &EXCAVATOR_MOTION,
            mark_filter,
            excavator_filter(d)?,
        ),
        "rls" => run_stage(
            worker,
            &EXCAVATOR_MOTION,
            &EXCAVATOR_INERTIA_RLS,
            mark_estimate,
            excavator_regression(d, first)?,
        ),
        _ => run_stage(
            worker,
            &EXCAVATOR_SENSORS,
            &EXCAVATOR_INERTIA_UKF,
            mark_estimate,
            excavator_estimator(d, second)?,
        ),
    }?)
}

fn serve_loader(
    worker: Worker,
    plan: &Plan,
    d: &config::Loader,
    name: &str,
) -> Result<(), Failure> {
    Ok(match name {
        "sensor" => run_source(
            worker,
            &LOADER_SENSORS,
            &LOADER_TRUTH,
            pace(plan),
            loader_source(plan)?,
        ),
        "kalman" => run_stage(
            worker,
            &LOADER_SENSORS,
            &LOADER_CG_EKF,
            mark_estimate,
            loader_baseline(d)?,
        ),
        _ => run_stage(
            worker,
            &LOADER_SENSORS,
            &LOADER_CG_UKF,
            mark_estimate,
            loader_estimator(d, &plan.second_method)?,
        ),
    }?)
}

fn serve_logger(worker: Worker, plan: &Plan) -> Result<(), Failure> {
    let channels: Vec<_> = of_machine(&plan.machine).collect();
    let limits = logger::Limits::default();
    let logger = logger::Logger::create(&plan.recording, &plan.metadata(), limits)?;
    Ok(run_sink(worker, &channels, plan.lossless, logger)?)
}

fn serve_probe(worker: Worker, plan: &Plan) -> Result<(), Failure> {
    let Some(file) = &plan.probe else {
        return Ok(());
    };
    // As many as the run has samples, with some to spare; ten minutes where it has no end.
    let capacity = (plan.duration.unwrap_or(600.0) * plan.rate) as usize + 1000;
    let wake = if plan.probe_listens {
        Wake::Event
    } else {
        Wake::Bell
    };
    let arrivals = match plan.kind() {
        Kind::Excavator => {
            run_probe::<ExcavatorEstimate>(worker, &EXCAVATOR_INERTIA_RLS, capacity, wake)
        }
        Kind::Loader => run_probe::<LoaderEstimate>(worker, &LOADER_CG_UKF, capacity, wake),
    }?;
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
