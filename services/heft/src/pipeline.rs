//! Which Rust value stands behind which process: the same sources and steps for `heft run`,
//! `heft estimate`, `heft replay` and the tests.

use std::path::Path;

use config::{Description, Kind};
use messages::channels::{
    EXCAVATOR_INERTIA_RLS, EXCAVATOR_INERTIA_UKF, EXCAVATOR_SENSORS, EXCAVATOR_TRUTH,
    LOADER_CG_UKF, LOADER_SENSORS, LOADER_TRUTH, of_machine,
};
use messages::{ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, LoaderEstimate};
use messages::{LoaderSensors, LoaderTruth, SwingMotion};
use recording::Map;
use runtime::{
    Domain, Identity, Pace, Setup, Source, Step, Wake, Worker, mark_estimate, mark_filter,
    run_probe, run_sink, run_source, run_stage,
};

use crate::failure::Failure;
use crate::plan::Plan;
use crate::processes::{self, Process};

/// Methods that the `rls` process offers, the first by default.
pub const REGRESSIONS: [&str; 2] = ["svf-rls", "multi-forgetting-rls"];

/// Filter stage of the excavator.
pub fn excavator_filter(
    d: &config::Excavator,
) -> Result<impl Step<Input = ExcavatorSensors, Output = SwingMotion>, Failure> {
    kalman::Excavator::new(d).map_err(refused)
}

/// Regression of the excavator.
pub fn excavator_regression(
    d: &config::Excavator,
    method: &str,
) -> Result<impl Step<Input = SwingMotion, Output = ExcavatorEstimate>, Failure> {
    rls::Excavator::new(d, method).map_err(refused)
}

/// State-space estimator of the excavator.
pub fn excavator_estimator(
    d: &config::Excavator,
    method: &str,
) -> Result<impl Step<Input = ExcavatorSensors, Output = ExcavatorEstimate>, Failure> {
    ukf::Excavator::new(d, method).map_err(refused)
}

/// Whether a method can work with a source that has these columns.
pub fn check_columns(
    d: &config::Excavator,
    method: &str,
    first: &ExcavatorSensors,
) -> Result<(), Failure> {
    use estimation::excavator::{Method, SwingEstimator};
    use messages::excavator_bits::{SWING_ANGLE, SWING_TORQUE, SWING_VELOCITY};
    let columns = first.columns;
    let missing = |column: &str| {
        Failure::input(
            format!("the method {method} needs the column {column}, which the input does not have"),
            "--method",
            "choose another method, or name the column in a signal map (--map)",
        )
    };
    if columns & (SWING_VELOCITY | SWING_ANGLE) == 0 {
        return Err(missing("swing_velocity or swing_angle"));
    }
    match method {
        "svf-rls" if columns & SWING_TORQUE == 0 => Err(missing("swing_torque")),
        m if REGRESSIONS.contains(&m) => Ok(()),
        m => {
            // An unknown name is told by the estimator itself.
            let method = Method::parse(m).unwrap_or_default();
            let columns = kalman::excavator_columns(first);
            let estimator = SwingEstimator::new(&kalman::excavator_settings(d), method, columns);
            estimator.map(drop).map_err(refused)
        }
    }
}

/// Extended Kalman filter of the loader.
pub fn loader_baseline(
    d: &config::Loader,
) -> Result<impl Step<Input = LoaderSensors, Output = LoaderEstimate>, Failure> {
    kalman::Loader::new(d).map_err(refused)
}

/// Unscented Kalman filter of the loader.
pub fn loader_estimator(
    d: &config::Loader,
    method: &str,
) -> Result<impl Step<Input = LoaderSensors, Output = LoaderEstimate>, Failure> {
    ukf::Loader::new(d, method).map_err(refused)
}

fn refused(error: impl std::fmt::Display) -> Failure {
    Failure::input(
        error,
        "the description or --method",
        "`heft check FILE --print` shows every key with its range; the README lists the methods",
    )
}

/// A source of either kind.
pub enum Either<A, B> {
    /// From the simulator.
    Simulated(A),
    /// From a recording.
    Recorded(B),
}

impl<S, T, A, B> Source for Either<A, B>
where
    S: messages::Message,
    T: messages::Message,
    A: Source<Sensors = S, Truth = T>,
    B: Source<Sensors = S, Truth = T>,
{
    type Sensors = S;
    type Truth = T;

    fn next(&mut self) -> Option<(S, T)> {
        match self {
            Self::Simulated(source) => source.next(),
            Self::Recorded(source) => source.next(),
        }
    }
}

/// Reads a signal map.
pub fn map(path: Option<&Path>) -> Result<Option<Map>, Failure> {
    Ok(path.map(Map::read).transpose()?)
}

/// The excavator's samples.
pub fn excavator_source(
    plan: &Plan,
) -> Result<impl Source<Sensors = ExcavatorSensors, Truth = ExcavatorTruth>, Failure> {
    use sim::excavator::{Run, Scenario};
    if let Some(input) = &plan.input {
        let map = map(plan.map.as_deref())?;
        let rows = recording::load_excavator(input, map.as_ref())?;
        return Ok(Either::Recorded(sensor::Recorded::new(limited(
            rows,
            plan.duration,
        ))));
    }
    let scenario = Scenario::parse(&plan.scenario)
        .ok_or_else(|| no_scenario(&plan.scenario, Scenario::ALL))?;
    let mut run = Run::new(scenario);
    (run.payload, run.rate, run.seed) = (plan.payload, plan.rate, plan.seed);
    run.duration = plan.duration.unwrap_or(run.duration);
    Ok(Either::Simulated(
        sensor::SimulatedExcavator::new(&run).map_err(bad_run)?,
    ))
}

/// The loader's samples.
pub fn loader_source(
    plan: &Plan,
) -> Result<impl Source<Sensors = LoaderSensors, Truth = LoaderTruth>, Failure> {
    use sim::loader::{Run, Scenario, Tier};
    if let Some(input) = &plan.input {
        let map = map(plan.map.as_deref())?;
        let rows = recording::load_loader(input, map.as_ref())?;
        return Ok(Either::Recorded(sensor::Recorded::new(limited(
            rows,
            plan.duration,
        ))));
    }
    let scenario = Scenario::parse(&plan.scenario)
        .ok_or_else(|| no_scenario(&plan.scenario, Scenario::ALL))?;
    let mut run = Run::new(scenario);
    (run.payload, run.rate, run.seed) = (plan.payload, plan.rate, plan.seed);
    (run.tier, run.duration) = (Tier::B, plan.duration);
    Ok(Either::Simulated(
        sensor::SimulatedLoader::new(&run).map_err(bad_run)?,
    ))
}

/// The rows of the first `duration` seconds.
fn limited<S: messages::Message, T>(mut rows: Vec<(S, T)>, duration: Option<f64>) -> Vec<(S, T)> {
    if let (Some(duration), Some((first, _))) = (duration, rows.first()) {
        let end = first.stamp().time + duration;
        let keep = rows
            .iter()
            .position(|(s, _)| s.stamp().time > end)
            .unwrap_or(rows.len());
        rows.truncate(keep);
    }
    rows
}

fn bad_run(error: impl std::fmt::Display) -> Failure {
    Failure::input(
        error,
        "the simulator",
        "choose another --rate, --duration or --payload",
    )
}

/// The scenarios of a machine, a line each.
pub fn scenarios(machine: Kind) -> String {
    lines(match machine {
        Kind::Excavator => sim::excavator::Scenario::ALL,
        Kind::Loader => sim::loader::Scenario::ALL,
    })
}

fn lines(all: &[(&str, &str)]) -> String {
    all.iter()
        .map(|(name, text)| format!("    {name:<20} {text}\n"))
        .collect()
}

fn no_scenario(name: &str, all: &[(&str, &str)]) -> Failure {
    let nearest = config::nearest(name, all.iter().map(|(n, _)| *n));
    let hint = nearest.map_or(String::new(), |n| format!(" (did you mean `{n}`?)"));
    Failure::input(
        format!("there is no scenario `{name}`{hint}"),
        "--scenario",
        format!("choose one of\n{}", lines(all).trim_end()),
    )
}

/// Builds every part of the plan once, so that a mistake is told before any process starts.
pub fn check(plan: &Plan) -> Result<(), Failure> {
    match plan.description()? {
        Description::Excavator(d) => {
            excavator_filter(&d)?;
            excavator_regression(&d, &plan.first_method)?;
            excavator_estimator(&d, &plan.second_method)?;
            excavator_source(plan).map(drop)
        }
        Description::Loader(d) => {
            loader_baseline(&d)?;
            loader_estimator(&d, &plan.second_method)?;
            loader_source(plan).map(drop)
        }
    }
}

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
        (_, "logger") => serve_logger(worker, &plan, restarts),
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
    use messages::channels::EXCAVATOR_MOTION;
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
    use messages::channels::LOADER_CG_EKF;
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

fn serve_logger(worker: Worker, plan: &Plan, restarts: u32) -> Result<(), Failure> {
    crate::parts::put_aside(&plan.recording, restarts)?;
    let channels: Vec<_> = of_machine(&plan.machine).collect();
    let logger = logger::Logger::create(&plan.recording, &plan.metadata())?;
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
