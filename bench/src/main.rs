//! `cargo run --release -p bench`: what a step costs, next to the peers and to the limits of the machine.

use bench::bounds::Machine;
use bench::{counts, groups, report};
use serde_json::{Map, Value, json};
use std::process::ExitCode;

const USAGE: &str = "\
usage: bench [--json FILE]          steps of ours and of the peers, interleaved
       bench counts                 instructions a step, against the budgets (needs valgrind)
       bench scale [--json FILE] [--plot FILE.svg]
                                    machines on one host";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    match words[..] {
        [] => compare(None),
        ["--json", file] => compare(Some(file)),
        ["counts"] => count(),
        [counts::SUBCOMMAND, key, index, passes] => block(key, index, passes),
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

fn compare(file: Option<&str>) -> ExitCode {
    let machine = Machine::measure();
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
    document.insert("machine".to_string(), describe(&machine));
    write(file, &Value::Object(document))
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

fn describe(machine: &Machine) -> Value {
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

fn write(file: Option<&str>, document: &Value) -> ExitCode {
    let Some(file) = file else {
        return ExitCode::SUCCESS;
    };
    match std::fs::write(file, format!("{document:#}\n")) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!(
                "bench: cannot write the results\n  {file}: {error}\n  name a file in a folder that exists and is yours"
            );
            ExitCode::from(2)
        }
    }
}
