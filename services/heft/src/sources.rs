//! Sources of samples: the simulator, a recording, a bus, standard input.

use std::cmp::Ordering;
use std::os::fd::OwnedFd;
use std::path::Path;

use recording::{Map, Sensors};
use runtime::{Begin, Pace, Source, Worker, now_ns, run_live, run_source};

use crate::failure::Failure;
use crate::plan::Plan;

/// Least gap in the time of the data after a restart of a live source \[ns\].
const AFTER_RESTART_NS: u64 = 100_000_000;

/// A live source: its samples come at their own times.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LiveInput {
    /// A CAN interface.
    Can(String),
    /// Standard input.
    Lines,
}

impl LiveInput {
    /// The live source that `--input` names: `can:INTERFACE` or `-`; none for a file.
    pub fn of(input: &Path) -> Option<Self> {
        match input.to_str()? {
            "-" => Some(Self::Lines),
            name => name.strip_prefix("can:").map(|i| Self::Can(i.to_owned())),
        }
    }
}

/// Whether the samples of a plan are the simulator's.
pub fn is_simulated(plan: &Plan) -> bool {
    plan.input.is_none()
}

/// The source of a plan's samples, as one line.
pub fn words(plan: &Plan) -> String {
    let Some(input) = &plan.input else {
        return format!(
            "samples: simulated (scenario {}, seed {}): nothing is measured",
            plan.scenario, plan.seed
        );
    };
    let map = plan.map.as_deref().map_or(String::new(), |map| {
        format!(" through the map {}", map.display())
    });
    match LiveInput::of(input) {
        Some(LiveInput::Can(interface)) => format!("samples: CAN interface {interface}, live{map}"),
        Some(LiveInput::Lines) => format!("samples: standard input, live{map}"),
        None => format!("samples: the recording {}{map}", input.display()),
    }
}

/// Longest name of an interface \[bytes\]: what the kernel has room for. No longer one ever comes, so it is not waited for.
const LONGEST_INTERFACE: usize = 15;

/// The frames of a CAN interface as samples.
fn can_bus<M: Sensors>(plan: &Plan, interface: &str) -> Result<sensor::CanBus<M>, Failure> {
    if interface.is_empty() {
        let remedy = "name a CAN interface: can:can0";
        return Err(Failure::input(
            "no CAN interface is named",
            "--input can:",
            remedy,
        ));
    }
    if interface.len() > LONGEST_INTERFACE {
        return Err(Failure::input(
            format!("no interface has a name of more than {LONGEST_INTERFACE} bytes"),
            format!("--input can:{interface}"),
            "`ip link` lists the interfaces of this computer",
        ));
    }
    let Some(map) = map(plan.map.as_deref())? else {
        return Err(Failure::input(
            "a CAN bus needs a signal map",
            "--input",
            "give one with --map; it names the DBC file and the signals (`heft map LOG --dbc FILE` writes a first one)",
        ));
    };
    Ok(sensor::CanBus::new(interface, &map)?)
}

/// The lines of the run's standard input as samples.
fn lines<M: Sensors>(plan: &Plan, input: OwnedFd) -> Result<sensor::Lines<M>, Failure> {
    let map = map(plan.map.as_deref())?;
    Ok(sensor::Lines::new(input, map, !plan.lossless)?)
}

/// Reads a signal map.
pub fn map(path: Option<&Path>) -> Result<Option<Map>, Failure> {
    Ok(path.map(Map::read).transpose()?)
}

/// A source of any kind.
pub type AnySource<M> = Box<dyn Source<Sensors = M, Truth = <M as Sensors>::Truth>>;

/// The source of a plan without a live one; `simulate` makes the simulator's.
pub fn not_live<M, S>(
    plan: &Plan,
    simulate: impl FnOnce() -> Result<S, Failure>,
) -> Result<AnySource<M>, Failure>
where
    M: Sensors,
    S: Source<Sensors = M, Truth = M::Truth> + 'static,
{
    match &plan.input {
        Some(input) => Ok(Box::new(recorded::<M>(plan, input)?)),
        None => Ok(Box::new(simulate()?)),
    }
}

/// The samples of a recording, read as they are played.
fn recorded<M: Sensors>(
    plan: &Plan,
    input: &Path,
) -> Result<sensor::Recorded<M, M::Truth>, Failure> {
    let map = map(plan.map.as_deref())?;
    // The process reads them until it ends: leaked on purpose.
    let samples = Box::leak(Box::new(recording::open::<M>(input, map.as_ref())?));
    let (mut end, duration) = (None, plan.duration.unwrap_or(f64::INFINITY));
    let is_within = move |(sample, _): &(M, M::Truth)| {
        let time = sample.stamp().time;
        if time.is_finite() {
            end.get_or_insert(time + duration);
        }
        end.is_none_or(|end| time.partial_cmp(&end) != Some(Ordering::Greater))
    };
    Ok(sensor::Recorded::new(samples.rows()?.take_while(is_within)))
}

/// Checks that a recording can be read to its end.
fn check_recorded<M: Sensors>(plan: &Plan, input: &Path) -> Result<(), Failure> {
    let map = map(plan.map.as_deref())?;
    let samples = recording::open::<M>(input, map.as_ref())?;
    samples.rows()?.for_each(drop);
    samples.check()?;
    let lacks = samples.lacks();
    for lack in lacks.all() {
        tracing::warn!("{lack}; the rest is played");
    }
    for empty in &lacks.empty {
        tracing::warn!("{empty}");
    }
    Ok(())
}

/// The live source of a plan, if it has one.
pub fn live(plan: &Plan) -> Option<LiveInput> {
    plan.input.as_deref().and_then(LiveInput::of)
}

/// Checks that the source of a plan can be made; `simulate` makes the simulator's.
pub fn check<M: Sensors, S>(
    plan: &Plan,
    simulate: impl FnOnce() -> Result<S, Failure>,
) -> Result<(), Failure> {
    let Some(input) = &plan.input else {
        return simulate().map(drop);
    };
    match LiveInput::of(input) {
        Some(LiveInput::Can(interface)) => can_bus::<M>(plan, &interface).map(drop),
        Some(LiveInput::Lines) => {
            recording::LineDecoder::<M>::new(map(plan.map.as_deref())?)?;
            Ok(())
        }
        None => check_recorded::<M>(plan, input),
    }
}

/// Runs the source of a plan until the run ends; `simulate` makes the simulator's.
pub fn serve<M, S>(
    mut worker: Worker,
    plan: &Plan,
    simulate: impl FnOnce() -> Result<S, Failure>,
) -> Result<(), Failure>
where
    M: Sensors,
    S: Source<Sensors = M, Truth = M::Truth>,
{
    let pace = if plan.lossless {
        Pace::Lossless
    } else {
        Pace::RealTime
    };
    let (sensors, truth) = (M::SENSORS, M::TRUTH);
    let Some(input) = &plan.input else {
        return Ok(run_source(worker, sensors, truth, pace, simulate()?)?);
    };
    // After a restart the time of the first live sample is the time since the run began. It is shortly after
    // the latest sample if the data were ahead of that.
    let start = |begin: Begin, restarts: u32| {
        let since = now_ns().saturating_sub(begin.start_ns);
        let first = since.max(begin.latest_ns + AFTER_RESTART_NS);
        if restarts == 0 {
            0.0
        } else {
            first as f64 / 1e9
        }
    };
    let duration = plan.duration;
    Ok(match LiveInput::of(input) {
        Some(LiveInput::Can(interface)) => {
            let mut bus = can_bus::<M>(plan, &interface)?;
            run_live(worker, sensors, truth, Pace::RealTime, duration, |b, r| {
                bus.begin_at(start(b, r));
                bus
            })
        }
        Some(LiveInput::Lines) => {
            let input = worker
                .take_input()
                .ok_or_else(|| Failure::internal("the supervisor handed over no standard input"))?;
            let mut lines = lines::<M>(plan, input)?;
            run_live(worker, sensors, truth, pace, duration, |b, r| {
                lines.begin_at(start(b, r));
                lines
            })
        }
        None => run_source(worker, sensors, truth, pace, recorded::<M>(plan, input)?),
    }?)
}
