//! Machines per core: a shard that steps many machines in one process, compared with processes for each.
//!
//! A shard costs the steps and fetching each machine's state. Processes also cost their wake-ups, and the simulation, recording
//! and supervision of their machine ([`crate::pipelines`]). A fully used core serves `period / cost` machines.

use crate::measure::{Contender, custom, interleaved};
use crate::pipelines::{self, Cost};
use crate::problem::Filter;
use crate::real;
use serde_json::{Value, json};
use std::rc::Rc;

/// Numbers of machines.
pub const MACHINES: [usize; 4] = [1, 10, 100, 1000];
/// Machine steps in a block: a minute of one machine's rows.
const STEPS: usize = 6000;
/// Sampling period [ns]: 100 Hz.
const PERIOD_NS: f64 = 1e7;

/// Cost of one machine's sample [ns] for each of [`MACHINES`].
struct Curve {
    name: &'static str,
    state_bytes: usize,
    cost_ns: Vec<f64>,
}

/// A shard of some estimators, all with the same rows.
fn shard<F, Z: 'static, const N: usize>(name: &'static str, rows: Rc<Vec<Z>>) -> Curve
where
    F: Filter<Z, N> + Default + 'static,
{
    let mut shards: Vec<Contender> = MACHINES
        .iter()
        .map(|machines| {
            let mut shard: Vec<F> = (0..*machines).map(|_| F::default()).collect();
            let (rows, mut next) = (rows.clone(), 0);
            let block = move || {
                // Every machine is at another row of its cycle.
                let ticks = (STEPS / shard.len()).max(1);
                for _ in 0..ticks {
                    for (i, machine) in shard.iter_mut().enumerate() {
                        machine.step(&rows[(next + 37 * i) % rows.len()]);
                    }
                    next = (next + 1) % rows.len();
                }
                std::hint::black_box(shard[0].state());
                (ticks * shard.len()) as u64
            };
            custom(name, block, || ())
        })
        .collect();
    let cost_ns = interleaved(&mut shards, 15, 1.0)
        .into_iter()
        .map(|time| time.min)
        .collect();
    Curve {
        name,
        state_bytes: std::mem::size_of::<F>(),
        cost_ns,
    }
}

/// Measures, prints, and returns the JSON.
pub fn run() -> std::io::Result<Value> {
    let (rows, work) = (
        Rc::new(real::excavator_rows()),
        Rc::new(real::loader_rows()),
    );
    let curves = [
        shard::<real::Swing<3>, _, 1>("excavator, posture-torque", rows),
        shard::<real::Loader<2>, _, 2>("loader, isr-ukf, 6 states", work.clone()),
        shard::<real::Loader<0>, _, 2>("loader, full, 12 states", work.clone()),
        shard::<real::Loader<4>, _, 2>("loader, full-ekf, 12 states", work),
    ];
    print(&curves);
    let pipelines = pipelines()?;
    let shards: serde_json::Map<String, Value> = curves
        .iter()
        .map(|curve| {
            let points: Vec<Value> = MACHINES
                .iter()
                .zip(&curve.cost_ns)
                .map(|(n, cost)| json!({ "machines": n, "ns": cost, "machines_per_core": PERIOD_NS / cost }))
                .collect();
            (curve.name.to_string(), json!({ "state_bytes": curve.state_bytes, "shard": points }))
        })
        .collect();
    Ok(json!({ "rate_hz": 1e9 / PERIOD_NS, "steps": shards, "pipelines": to_json(&pipelines) }))
}

/// Real pipelines, by the program `heft` beside this one.
fn pipelines() -> std::io::Result<Vec<Cost>> {
    let heft = std::env::current_exe()?.with_file_name("heft");
    if !heft.exists() {
        println!(
            "no pipelines measured: {} is missing; build it with `cargo build --release`",
            heft.display()
        );
        return Ok(Vec::new());
    }
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    println!("\nheft run, excavator at 100 Hz, six processes a machine, on {cores} cores");
    println!(
        "{:>9} {:>22} {:>18} {:>18} {:>18} {:>6}",
        "machines",
        "us of processor/sample",
        "bare futexes",
        "machines per core",
        "MB a machine",
        "lost"
    );
    let measured = |machines| match pipelines::measure(&heft, machines) {
        Ok(cost) => {
            print_cost(&cost);
            Some(cost)
        }
        Err(error) => {
            println!("{machines:9} not measured: {error}");
            None
        }
    };
    Ok(pipelines::MACHINES
        .into_iter()
        .filter_map(measured)
        .collect())
}

fn print_cost(cost: &Cost) {
    println!(
        "{:9} {:22.0} {:18.0} {:18.0} {:18.1} {:6}",
        cost.machines,
        cost.sample_ns / 1e3,
        cost.bare_ns / 1e3,
        PERIOD_NS / cost.sample_ns,
        cost.bytes / 1e6,
        cost.lost
    );
}

fn to_json(pipelines: &[Cost]) -> Value {
    pipelines
        .iter()
        .map(|cost| json!({ "machines": cost.machines, "ns": cost.sample_ns, "bare_ns": cost.bare_ns, "machines_per_core": PERIOD_NS / cost.sample_ns, "bytes": cost.bytes, "lost": cost.lost }))
        .collect()
}

fn print(curves: &[Curve]) {
    println!("ns a machine and sample, and machines per core at 100 Hz");
    println!(
        "{:28} {:>8}  {}",
        "",
        "bytes",
        MACHINES
            .map(|n| format!("{:>17}", format!("N = {n}")))
            .join("")
    );
    for curve in curves {
        let cells = curve
            .cost_ns
            .iter()
            .map(|cost| format!("{cost:9.0} {:>7.0}", PERIOD_NS / cost));
        println!(
            "{:28} {:8}  {}",
            curve.name,
            curve.state_bytes,
            cells.collect::<String>()
        );
    }
    let cache = second_level_cache();
    for curve in curves {
        let (first, last) = (curve.cost_ns[0], curve.cost_ns[MACHINES.len() - 1]);
        println!(
            "{}: a step at N = 1000 costs {:.2} x that at N = 1",
            curve.name,
            last / first
        );
        if let Some(cache) = cache {
            println!(
                "  it bends at N = {}, where the states fill the second-level cache of {} kB; before that the step itself is all",
                cache / curve.state_bytes,
                cache / 1024
            );
        }
    }
}

/// Size of the first core's second-level cache [bytes], if the system reports it.
fn second_level_cache() -> Option<usize> {
    let text = std::fs::read_to_string("/sys/devices/system/cpu/cpu0/cache/index2/size").ok()?;
    Some(text.trim().strip_suffix('K')?.parse::<usize>().ok()? * 1024)
}
