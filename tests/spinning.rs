//! `heft run --spin`: a process that polls for messages answers them all, and is refused if the host would
//! starve.

mod common;

use std::time::Duration;

use common::{Running, both, run, sequences, wait_until, words};
use messages::ExcavatorEstimate;
use rustix::process::Signal;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// Number of voluntary context switches of a process's main thread.
fn sleeps(pid: u32) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{pid}/status")).expect("it runs");
    let count = text
        .lines()
        .find_map(|l| l.strip_prefix("voluntary_ctxt_switches:"));
    count.and_then(|c| c.trim().parse().ok()).expect("a count")
}

#[test]
fn a_process_that_spins_answers_everything_and_never_sleeps() {
    if runtime::realtime::cores().len() < 2 {
        eprintln!("not tested: one core cannot spare one");
        return;
    }
    let args = words("excavator --scenario cycle --duration 60 --spin=rls");
    let running = Running::start("spin", &args);
    running.wait_for_services();
    wait_until("it records", Duration::from_secs(20), || {
        running
            .recording()
            .metadata()
            .is_ok_and(|file| file.len() > 20_000)
    });
    let pid = |name| running.service(name).expect("it runs");
    let before = [sleeps(pid("rls")), sleeps(pid("ukf"))];
    // On a busy host a process that wakes up may find several samples, and sleeps less often than they come.
    wait_until("ukf has slept", Duration::from_secs(30), || {
        sleeps(pid("ukf")) - before[1] > 250
    });
    let slept = sleeps(pid("rls")) - before[0];
    assert!(slept < 10, "rls slept {slept} times");
    running.signal(Signal::TERM);
    let recording = running.recording();
    let (output, _folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    let numbers = sequences::<ExcavatorEstimate>(&recording, "excavator/inertia_rls");
    assert!(numbers.len() > 200, "{}", numbers.len());
    assert!(numbers.iter().enumerate().all(|(at, n)| *n == at as u64));
}

#[test]
fn what_would_starve_the_host_or_cannot_spin_is_refused() {
    let refused = |args: &[&str], words: &str| {
        let output = run(args);
        let said = both(&output);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {said}");
        assert!(said.contains(words), "{said}");
    };
    refused(
        &["run", "excavator", "--spin=sensor"],
        "no process `sensor` waits for messages",
    );
    refused(
        &["run", "excavator", "--spin", "--rt"],
        "cannot be used with",
    );
    if !runtime::realtime::isolated_cores().is_empty() {
        return;
    }
    // Processes started by this thread have one core.
    let all = sched_getaffinity(None).expect("a set");
    let mut one = CpuSet::new();
    one.set(runtime::realtime::cores()[0]);
    sched_setaffinity(None, &one).expect("a core of ours");
    refused(
        &["run", "excavator", "--spin=ukf"],
        "need 2 cores, and there are 1",
    );
    refused(
        &["run", "excavator", "--spin"],
        "3 processes that spin (kalman, rls, ukf) and the rest of the run need 4 cores",
    );
    refused(
        &["latency", "loader", "--spin"],
        "need 4 cores, and there are 1",
    );
    sched_setaffinity(None, &all).expect("as before");
}

#[test]
fn latency_is_measured_with_spinning_and_by_bells() {
    if runtime::realtime::cores().len() < 2 {
        eprintln!("not tested: one core cannot spare one");
        return;
    }
    let args = words("latency loader --spin=ukf --rate 200 --duration 1.5");
    let output = run(&args);
    let said = both(&output);
    assert!(output.status.success(), "{said}");
    let rows: Vec<&str> = said
        .lines()
        .filter(|l| l.contains("sensor to ukf"))
        .collect();
    assert_eq!(rows.len(), 2, "{said}");
    assert!(
        said.contains("spinning: ukf") && said.contains("the same, by bells"),
        "{said}"
    );
}
