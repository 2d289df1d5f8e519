//! One process of a chain.

use crate::assignment::Assignment;
use crate::link::{Input, Output, output};
use crate::schedule::{become_fifo, now_ns, pin, sleep_until, work_for};
use crate::shared::Shared;
use crate::spawn;
use rustix::io::Errno;
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Signal, getppid, set_parent_process_death_signal};
use rustix::thread::futex;
use std::io;
use std::sync::atomic::Ordering;

/// Runs one stage; `args` is what follows [`SUBCOMMAND`](crate::SUBCOMMAND). Returns the exit status of the process.
pub fn worker_main(args: &[String]) -> i32 {
    match Assignment::from_args(args).and_then(|assignment| run(&assignment)) {
        Ok(()) => 0,
        Err(error) => {
            eprintln!("limits-worker: {error}");
            2
        }
    }
}

fn run(assignment: &Assignment) -> io::Result<()> {
    die_with_parent(assignment.parent)?;
    let (memory, input, output_pipe) = spawn::inherited(assignment);
    let Some(memory) = memory else {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "no shared memory was handed over",
        ));
    };
    let shared = Shared::open(
        memory,
        assignment.stages,
        assignment.samples,
        assignment.payload,
    )?;
    set_up(assignment, &shared)?;

    let last = assignment.stage + 1 == assignment.stages;
    let onward = if last {
        None
    } else {
        output(assignment.kind, &shared, assignment.stage, output_pipe)
    };
    if assignment.stage == 0 {
        wait_for_go(&shared)?;
        return feed(assignment, &shared, onward);
    }
    let Some(input) = Input::new(assignment.kind, &shared, assignment.stage - 1, input) else {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "no pipe was handed over",
        ));
    };
    wait_for_go(&shared)?;
    relay(assignment, &shared, input, onward)
}

fn die_with_parent(parent: i32) -> io::Result<()> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    if getppid().map(|pid| pid.as_raw_pid()) != Some(parent) {
        return Err(io::Error::other(
            "the process that started this one has ended",
        ));
    }
    Ok(())
}

fn set_up(assignment: &Assignment, shared: &Shared) -> io::Result<()> {
    if let Some(core) = assignment.core {
        pin(core)?;
    }
    if !assignment.fifo || !become_fifo(assignment.stage) {
        shared.note_not_fifo();
    } else {
        // Best effort: without it the chain still runs, with page faults in its tail.
        let _ = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE);
    }
    Ok(())
}

fn wait_for_go(shared: &Shared) -> io::Result<()> {
    shared.ready().fetch_add(1, Ordering::AcqRel);
    futex::wake(shared.ready(), futex::Flags::empty(), 1)?;
    while shared.go().load(Ordering::Acquire) == 0 {
        match futex::wait(shared.go(), futex::Flags::empty(), 0, None) {
            Ok(()) | Err(Errno::AGAIN | Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

/// The first stage: a sample at each tick of an absolute clock. Word 0 is its number, word 1 + i the stamp of stage i.
fn feed(assignment: &Assignment, shared: &Shared, onward: Option<Output>) -> io::Result<()> {
    let Some(onward) = onward else {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "no pipe was handed over",
        ));
    };
    let start = shared.start_ns().load(Ordering::Acquire);
    let mut sample = vec![0; assignment.payload / 8];
    for index in 0..assignment.samples as u64 {
        sleep_until(start + index * assignment.period_ns);
        sample[0] = index;
        sample[1] = now_ns();
        onward.send(&sample)?;
    }
    onward.finish()
}

/// Every other stage: stamps a sample on arrival and hands it on; the last one records it.
fn relay(
    assignment: &Assignment,
    shared: &Shared,
    mut input: Input,
    onward: Option<Output>,
) -> io::Result<()> {
    let mut sample = vec![0; assignment.payload / 8];
    let mut next = 0;
    while input.receive(&mut sample)? {
        sample[1 + assignment.stage] = now_ns();
        work_for(assignment.work_ns);
        match &onward {
            Some(onward) => onward.send(&sample)?,
            None if sample[0] >= next => {
                next = sample[0] + 1;
                shared.record(sample[0], &sample[1..=assignment.stages]);
            }
            None => {}
        }
    }
    onward.map_or(Ok(()), Output::finish)
}
