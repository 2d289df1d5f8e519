//! `cargo run --release -p bench`: cost of a step, beside the peers and the limits of the machine.

use bench::bounds::Host;
use bench::{counts, groups, measure, real, report, scale as shards};
use serde_json::{Map, Value, json};
use std::process::ExitCode;

const USAGE: &str = "\
usage: bench [--json FILE]          steps of ours and of the peers, interleaved
       bench counts                 instructions a step, against the budgets (needs valgrind)
       bench scale [--json FILE]    machines on one host";

/// Laps over the rows of the real steps.
const LAPS: usize = 7;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    match words[..] {
        [] => compare(None),
        ["--json", file] => compare(Some(file)),
        ["counts"] => count(),
        ["scale"] => scale(None),
        ["scale", "--json", file] => scale(Some(file)),
        [counts::SUBCOMMAND, key, index, passes] => block(key, index, passes),
        [limits::SUBCOMMAND, ..] => worker(&args[1..]),
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

fn compare(file: Option<&str>) -> ExitCode {
    let machine = Host::measure();
    println!(
        "one operation of many {:.2} ns, waiting for the one before {:.2} ns, division {:.1} ns, root {:.1} ns",
        machine.throughput, machine.arithmetic, machine.division, machine.root
    );
    println!(
        "minimum and median of {} blocks, contenders in turn; * does another thing",
        report::BLOCKS
    );
    let mut document = Map::new();
    for mut group in groups::all() {
        let measured = report::measure(&mut group);
        report::print(&group, &measured, &machine);
        document.insert(
            group.key.to_string(),
            report::to_json(&group, &measured, &machine),
        );
    }
    document.insert("batch8_srukf".to_string(), batches());
    document.insert("real".to_string(), Value::Object(real_steps()));
    document.insert("machine".to_string(), describe(&machine));
    write(file, &format!("{:#}\n", Value::Object(document)))
}

fn batches() -> Value {
    let mut contenders = groups::batches();
    let times = measure::interleaved(&mut contenders, report::BLOCKS, report::BLOCK_US);
    let single = times[0].min;
    let Some(best) = times[1..].iter().map(|time| time.min).reduce(f64::min) else {
        return Value::Null;
    };
    let verdict = if best / single <= groups::BATCH_TARGET {
        "met"
    } else {
        "MISSED"
    };
    println!(
        "\nSquare-root UKF 6/3, eight machines at once: {:.2} x a single step per machine, target {} {verdict}",
        best / single,
        groups::BATCH_TARGET
    );
    let mut all = Map::new();
    for (contender, time) in contenders.iter().zip(&times) {
        println!(
            "  {:34} {:9.1} {:9.1} {:10.2}",
            contender.name,
            time.min,
            time.median,
            time.min / single
        );
        all.insert(
            contender.name.to_string(),
            json!({ "ns_per_machine": time.min, "median_ns_per_machine": time.median }),
        );
    }
    json!({ "ns_per_machine": best, "single_ns": single, "ratio": best / single, "target": groups::BATCH_TARGET, "all": all })
}

fn real_steps() -> Map<String, Value> {
    println!(
        "\nThe steps of the product, ns: each row of a minute, the quickest of {LAPS} laps; then all single calls"
    );
    println!(
        "  {:34} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "", "mean row", "worst row", "call p50", "p99", "p99.9", "max"
    );
    let mut document = Map::new();
    for (key, make) in real::STEPS {
        let mut step = make();
        let rows = measure::rows(&mut step, real::ROWS, LAPS);
        let tail = measure::tail(&mut step, report::CALLS);
        println!(
            "  {:34} {:9.0} {:9.0} {:9.0} {:9.0} {:9.0} {:9.0}",
            step.name, rows.mean, rows.worst, tail.p50, tail.p99, tail.p999, tail.max
        );
        document.insert(
            key.to_string(),
            json!({ "ns": rows.mean, "worst_row_ns": rows.worst, "call_ns": report::tail_json(&tail) }),
        );
    }
    document
}

fn scale(file: Option<&str>) -> ExitCode {
    match shards::run() {
        Ok(results) => write(file, &format!("{results:#}\n")),
        Err(error) => {
            eprintln!("bench scale: {error}");
            ExitCode::from(2)
        }
    }
}

fn count() -> ExitCode {
    if !counts::available() {
        println!("bench counts: skipped, valgrind is not installed");
        return ExitCode::SUCCESS;
    }
    match counts::check() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("bench counts: {error}");
            ExitCode::from(2)
        }
    }
}

fn block(key: &str, index: &str, passes: &str) -> ExitCode {
    let done = match (index.parse(), passes.parse()) {
        (Ok(index), Ok(passes)) => counts::run_block(key, index, passes),
        _ => false,
    };
    if done {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(2)
    }
}

/// A process of the bare chain beside the pipelines.
fn worker(args: &[String]) -> ExitCode {
    ExitCode::from(u8::try_from(limits::worker_main(args)).unwrap_or(2))
}

fn describe(machine: &Host) -> Value {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu
        .lines()
        .find_map(|line| line.strip_prefix("model name"))
        .map(|rest| rest.trim_start_matches([' ', '\t', ':']));
    json!({
        "cpu": model,
        "operation_ns": machine.throughput,
        "waiting_operation_ns": machine.arithmetic,
        "division_ns": machine.division,
        "root_ns": machine.root,
    })
}

fn write(file: Option<&str>, text: &str) -> ExitCode {
    let Some(file) = file else {
        return ExitCode::SUCCESS;
    };
    match std::fs::write(file, text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!(
                "bench: cannot write the results\n  {file}: {error}\n  name a file in a folder that exists and is yours"
            );
            ExitCode::from(2)
        }
    }
}
