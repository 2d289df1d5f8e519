//! Measured latencies as tables.

use hdrhistogram::Histogram;
use limits::Primitive;

use super::ROUNDS;
use super::chain::Chain;
use super::conditions::Conditions;
use super::measure::{Measured, Passage, max_us, us};

/// The host and the chain.
pub fn machine(chain: &Chain) {
    let system = rustix::system::uname();
    println!(
        "{} cores, {} {}; µs from measurement to arrival, {}, {} processes, {ROUNDS} rounds in turn",
        runtime::realtime::cores().len(),
        system.sysname().to_string_lossy(),
        system.release().to_string_lossy(),
        chain.machine,
        chain.processes()
    );
}

/// One set of conditions.
pub fn measured(m: &Measured) {
    let load = if m.conditions.loaded {
        "every core occupied by a spinner"
    } else {
        "idle"
    };
    println!(
        "\n{} Hz, {}, {load}",
        m.conditions.rate,
        scheduling(&m.conditions)
    );
    println!(
        "{:<30}{:>9}{:>9}{:>9}{:>9}{:>9}",
        "", "p50", "p99", "p99.9", "max", "samples"
    );
    let row = |name: &str, h: &Histogram<u64>| {
        println!(
            "{name:<30}{:>9.1}{:>9.1}{:>9.1}{:>9.1}{:>9}",
            us(h, 0.5),
            us(h, 0.99),
            us(h, 0.999),
            max_us(h),
            h.len()
        );
    };
    let hops = m.chain.hops();
    let passage = |name: &str, passage: &Passage| {
        row(name, &passage.end_to_end);
        for (name, h) in hops.iter().zip(&passage.hops) {
            row(&format!("  {name}"), h);
        }
    };
    passage("heft, sensor to user", &m.ours);
    if m.conditions.spin.is_some() {
        passage("the same, by bells", &m.by_bell);
    }
    let last = hops.last().map_or("", String::as_str);
    row(&format!("  {last}, iceoryx2 event"), &m.by_event);
    for (kind, h) in m.limits.iter().filter(|(_, h)| !h.is_empty()) {
        let name = if *kind == Primitive::Spin {
            "bare cache line, 1 hop"
        } else {
            &format!("bare {} chain", kind.name())
        };
        row(name, h);
    }
    if let (Some(p50), Some(p999)) = (m.ratio(0.5), m.ratio(0.999)) {
        println!(
            "heft over bare futex: p50 {p50:.2} x, p99.9 {p999:.2} x; lost {}",
            m.ours.lost
        );
    }
}

fn scheduling(conditions: &Conditions) -> String {
    if let Some(spinning) = &conditions.spin {
        return format!("normal scheduling, spinning: {spinning}");
    }
    let cores: Vec<String> = conditions.pinned.iter().map(usize::to_string).collect();
    match (conditions.realtime, cores.as_slice()) {
        (false, _) => "normal scheduling, free placement".to_owned(),
        (true, [core]) => format!("SCHED_FIFO on core {core}"),
        (true, cores) => format!("SCHED_FIFO on cores {} in turn", cores.join(", ")),
    }
}
