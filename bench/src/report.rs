//! The table and the JSON of the comparison.

use crate::bounds::Host;
use crate::groups::{Group, Role};
use crate::measure::{Tail, Timing, interleaved, tail};
use serde_json::{Map, Value, json};

/// Blocks of each contender; the fastest and the middle one are reported.
pub const BLOCKS: usize = 61;
/// Approximate duration of a block \[us\].
pub const BLOCK_US: f64 = 400.0;
/// Number of separately timed calls.
pub const CALLS: usize = 50_000;

/// Measurements of a group.
pub struct Measured {
    /// Times in the order of the group's contenders.
    pub times: Vec<Timing>,
    /// Single calls of ours.
    pub tail: Tail,
    /// Index of the fastest peer of the same kind.
    pub best: usize,
}

/// Measures a group.
pub fn measure(group: &mut Group) -> Measured {
    let times = interleaved(&mut group.contenders, BLOCKS, BLOCK_US);
    let tail = tail(&mut group.contenders[0], CALLS);
    let best = quickest(group, &times, Role::Peer).unwrap_or(0);
    Measured { times, tail, best }
}

fn quickest(group: &Group, times: &[Timing], role: Role) -> Option<usize> {
    (0..times.len())
        .filter(|i| group.roles[*i] == role)
        .min_by(|a, b| times[*a].min.total_cmp(&times[*b].min))
}

/// Prints one group.
pub fn print(group: &Group, measured: &Measured, machine: &Host) {
    let ours = measured.times[0].min;
    let best = measured.times[measured.best].min;
    let verdict = if ours / best <= group.target {
        "met"
    } else {
        "MISSED"
    };
    println!(
        "\n{}: {:.2} x the best peer, target {} {verdict}",
        group.title,
        ours / best,
        group.target
    );
    println!(
        "  {:34} {:>9} {:>9} {:>11}",
        "", "min ns", "median", "x best peer"
    );
    for ((contender, time), role) in group
        .contenders
        .iter()
        .zip(&measured.times)
        .zip(&group.roles)
    {
        let mark = if *role == Role::Other { "*" } else { "" };
        println!(
            "  {:34} {:9.1} {:9.1} {:10.2} {mark}",
            contender.name,
            time.min,
            time.median,
            time.min / best
        );
    }
    let (flops, chain) = (
        machine.flop_bound(&group.operations),
        machine.chain_bound(&group.operations),
    );
    println!(
        "  {:34} {flops:9.1} {:>9} ours is {:.1} x it",
        "bound: all operations",
        "",
        ours / flops
    );
    println!(
        "  {:34} {chain:9.1} {:>9} ours is {:.1} x it",
        "bound: dependency chain",
        "",
        ours / chain
    );
    let Tail {
        p50,
        p99,
        p999,
        max,
    } = measured.tail;
    println!(
        "  single calls of ours, clock included: p50 {p50:.0}, p99 {p99:.0}, p99.9 {p999:.0}, max {max:.0} ns"
    );
}

/// One group as JSON.
pub fn to_json(group: &Group, measured: &Measured, machine: &Host) -> Value {
    let ours = measured.times[0];
    let best = measured.times[measured.best];
    let all: Map<String, Value> = group
        .contenders
        .iter()
        .zip(&measured.times)
        .map(|(contender, time)| {
            (
                contender.name.to_string(),
                json!({ "ns": time.min, "median_ns": time.median }),
            )
        })
        .collect();
    let other = quickest(group, &measured.times, Role::Other);
    json!({
        "ns": ours.min,
        "median_ns": ours.median,
        "best_peer": group.contenders[measured.best].name,
        "best_peer_ns": best.min,
        "ratio": ours.min / best.min,
        "target": group.target,
        "other_kind": other.map(|i| group.contenders[i].name),
        "other_kind_ns": other.map(|i| measured.times[i].min),
        "flop_bound_ns": machine.flop_bound(&group.operations),
        "chain_bound_ns": machine.chain_bound(&group.operations),
        "call_ns": tail_json(&measured.tail),
        "all": all,
    })
}

/// Single calls as JSON.
pub fn tail_json(tail: &Tail) -> Value {
    json!({ "p50": tail.p50, "p99": tail.p99, "p999": tail.p999, "max": tail.max })
}
