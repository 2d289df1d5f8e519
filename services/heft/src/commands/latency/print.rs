//! The numbers as tables.

use hdrhistogram::Histogram;
use limits::Primitive;

use super::conditions::Conditions;
use super::measure::{Measured, max_us, us};
use super::{ROUNDS, STAGES};

/// What was measured on, and how.
pub fn machine() {
    let system = rustix::system::uname();
    println!(
        "{} cores, {} {}; µs from measurement to arrival, {STAGES} processes, {ROUNDS} rounds in turn",
        runtime::realtime::cores().len(),
        system.sysname().to_string_lossy(),
        system.release().to_string_lossy()
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
    row("heft, sensor to user", &m.end_to_end);
    for (name, h) in ["  sensor to kalman", "  kalman to rls", "  rls to user"]
        .iter()
        .zip(&m.hops)
    {
        row(name, h);
    }
    row("  rls to user, iceoryx2 event", &m.by_event);
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
            m.lost
        );
    }
}

fn scheduling(conditions: &Conditions) -> String {
    let cores: Vec<String> = conditions.pinned.iter().map(usize::to_string).collect();
    match (conditions.realtime, cores.as_slice()) {
        (false, _) => "normal scheduling, free placement".to_owned(),
        (true, [core]) => format!("SCHED_FIFO on core {core}"),
        (true, cores) => format!("SCHED_FIFO on cores {} in turn", cores.join(", ")),
    }
}
