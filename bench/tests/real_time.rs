//! Real-time properties of the steps: no allocations, no system calls, and filters with a data-independent number of instructions.

use bench::{counts, groups, real};
use messages::keyframe::LONGEST;
use runtime::{Source, Step, answer};
use sensor::{excavator, loader};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

/// The system's allocator, counting the calls of each thread.
struct Counting;

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

fn note() {
    // A terminating thread has no counter any more, and is not tested.
    let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
}

// SAFETY: every call is passed on to the system's allocator unchanged; counting touches a constant-initialised thread local only,
// which does not allocate.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller's promises about `layout` are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        note();
        // SAFETY: `pointer` came from `System.alloc` with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn ten_thousand_steps_allocate_nothing() {
    let comparisons = groups::all()
        .into_iter()
        .map(|mut group| group.contenders.swap_remove(0));
    let product = real::STEPS.into_iter().map(|(_, make)| make());
    for mut step in comparisons.chain(product) {
        let before = CALLS.get();
        (0..10_000).for_each(|_| step.step());
        assert_eq!(CALLS.get() - before, 0, "{}", step.name);
    }
}

/// Number of allocations of a service that answers ten thousand messages, including the first, and saves its state
/// in the middle. Asserts that a service that restores this state continues with identical bits.
fn allocations<S: Step + Clone>(mut service: S, messages: &[S::Input]) -> u64 {
    assert!(messages.len() >= 10_000);
    let mut other = service.clone();
    let mut state = vec![0; LONGEST];
    let mut length = 0;
    let mut last = S::Output::default();
    let before = CALLS.get();
    for (n, message) in messages[..10_000].iter().enumerate() {
        last = std::hint::black_box(answer(&mut service, message));
        if n == 4_999 {
            length = service.save(&mut state).expect("the state has room");
        }
    }
    let calls = CALLS.get() - before;
    assert!(!other.restore(&state[..length - 1]), "a state cut off");
    assert!(other.restore(&state[..length]));
    let after = messages[5_000..10_000].iter();
    let answers = after.map(|message| answer(&mut other, message));
    assert_eq!(
        answers.last(),
        Some(last),
        "it goes on as if nothing had been"
    );
    println!("{}: {length} bytes of state", std::any::type_name::<S>());
    calls
}

fn sensors<S: Source>(mut source: S) -> Vec<S::Sensors> {
    std::iter::from_fn(|| source.next())
        .map(|(sensors, _)| sensors)
        .collect()
}

#[test]
fn the_excavators_services_answer_without_allocating() {
    let description = config::Excavator::default();
    let run = sim::excavator::Run {
        duration: 100.0,
        ..sim::excavator::Run::new(sim::excavator::Scenario::Cycle)
    };
    let samples = sensors(excavator::Simulator::new(&run).expect("a valid run"));
    let mut filter = steps::excavator::FilterStep::new(&description).expect("valid settings");
    let motions: Vec<_> = samples.iter().map(|s| answer(&mut filter, s)).collect();
    let filter = steps::excavator::FilterStep::new(&description).expect("valid settings");
    assert_eq!(allocations(filter, &samples), 0, "kalman");
    for method in ["multi-forgetting-rls", "svf-rls"] {
        let service =
            steps::excavator::RegressionStep::new(&description, method).expect("a method");
        assert_eq!(allocations(service, &motions), 0, "{method}");
    }
    for method in ["auto", "posture-torque", "torque", "posture", "velocity"] {
        let service = steps::excavator::EstimatorStep::new(&description, method).expect("a method");
        assert_eq!(allocations(service, &samples), 0, "{method}");
    }
}

#[test]
fn the_loaders_services_answer_without_allocating() {
    let description = config::Loader::default();
    let run = sim::loader::Run {
        duration: Some(100.0),
        ..sim::loader::Run::new(sim::loader::Scenario::WorkCycle)
    };
    let samples = sensors(loader::Simulator::new(&run).expect("a valid run"));
    for method in messages::LOADER_METHODS {
        let service = steps::loader::EstimatorStep::new(&description, method).expect("a method");
        assert_eq!(allocations(service, &samples), 0, "{method}");
    }
}

#[test]
fn the_counter_counts() {
    let before = CALLS.get();
    drop(std::hint::black_box(Box::new(1)));
    assert_eq!(CALLS.get() - before, 2);
}

/// Number of system calls of a process that runs `passes` passes over the data of a step.
fn system_calls(key: &str, passes: usize) -> usize {
    let output = Command::new("valgrind")
        .args([
            "--tool=none",
            "--trace-syscalls=yes",
            env!("CARGO_BIN_EXE_bench"),
        ])
        .args([counts::SUBCOMMAND, key, "0", &passes.to_string()])
        .stdout(Stdio::null())
        .output()
        .expect("valgrind was found before");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8_lossy(&output.stderr)
        .matches("SYSCALL[")
        .count()
}

#[test]
fn steps_make_no_system_calls() {
    if !counts::available() {
        let _ = writeln!(std::io::stderr(), "skipped: valgrind is not installed");
        return;
    }
    // Thousands of further steps add no system call: all calls belong to the start and the end of the process.
    for key in ["srukf_6_3", "excavator_posture_torque", "loader_full_12"] {
        let (few, many) = (system_calls(key, 1), system_calls(key, 2));
        assert!(few > 10, "{key}: valgrind reports calls at all");
        assert_eq!(many, few, "{key}");
    }
}

#[test]
fn a_filter_does_the_same_work_on_all_data() {
    if !counts::available() {
        let _ = writeln!(std::io::stderr(), "skipped: valgrind is not installed");
        return;
    }
    let bench = Path::new(env!("CARGO_BIN_EXE_bench"));
    for (key, index, ..) in counts::BUDGETS {
        let count =
            |passes| counts::instructions(bench, key, index, passes).expect("valgrind counts");
        // The first pass starts at the prior, the later ones in other states: the number of instructions must not depend on it.
        let (one, two, three) = (count(1), count(2), count(3));
        assert_eq!(two - one, three - two, "{key} {index}");
        assert_eq!(two, 2 * one, "{key} {index}");
    }
}
