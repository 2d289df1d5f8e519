//! Starts the stages, lets them run, and sees to their end.
#![allow(unsafe_code)]

use crate::assignment::Assignment;
use crate::schedule::now_ns;
use crate::shared::Shared;
use crate::{Options, Primitive, SUBCOMMAND, WARM_UP};
use rustix::io::{FdFlags, fcntl_setfd};
use rustix::pipe::{PipeFlags, pipe_with};
use rustix::thread::futex;
use std::io;
use std::os::fd::{AsRawFd, BorrowedFd, FromRawFd, OwnedFd, RawFd};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Longest time the stages may take to start.
const START: Duration = Duration::from_secs(10);
/// From the word "go" to the first sample [ns]: every stage is asleep on its word by then.
const LEAD_NS: u64 = 20_000_000;
/// Period at which the starter checks its processes: long, because it shares their cores.
const LOOK: Duration = Duration::from_millis(20);

/// Runs the chain to its end.
pub fn run(kind: Primitive, options: &Options, shared: &Shared) -> io::Result<()> {
    let mut stages = Stages(start_all(kind, options, shared)?);
    stages.wait_until_ready(shared, options.stages)?;
    shared
        .start_ns()
        .store(now_ns() + LEAD_NS, Ordering::Release);
    shared.go().store(1, Ordering::Release);
    futex::wake(shared.go(), futex::Flags::empty(), i32::MAX as u32)?;
    let planned = (options.samples + WARM_UP) as f64 / options.rate_hz;
    let working = options.work.as_secs_f64() * (options.samples * options.stages) as f64;
    stages.wait_until_done(Duration::from_secs_f64(10.0 + 2.0 * planned + working))
}

fn start_all(kind: Primitive, options: &Options, shared: &Shared) -> io::Result<Vec<Child>> {
    let mut started = Stages(Vec::new());
    let mut from_before: Option<OwnedFd> = None;
    for stage in 0..options.stages {
        let (reader, writer) = if kind == Primitive::Pipe && stage + 1 < options.stages {
            let (reader, writer) = pipe_with(PipeFlags::CLOEXEC)?;
            (Some(reader), Some(writer))
        } else {
            (None, None)
        };
        let mut assignment = Assignment::new(kind, options, stage);
        assignment.memory = shared.file().as_raw_fd();
        assignment.input = from_before.as_ref().map_or(-1, AsRawFd::as_raw_fd);
        assignment.output = writer.as_ref().map_or(-1, AsRawFd::as_raw_fd);
        started.0.push(start(&assignment)?);
        from_before = reader; // our copies close here: a pipe ends when its one writer does
    }
    Ok(std::mem::take(&mut started.0))
}

fn start(assignment: &Assignment) -> io::Result<Child> {
    let descriptors = [assignment.memory, assignment.input, assignment.output];
    let mut command = Command::new(std::env::current_exe()?);
    command.arg(SUBCOMMAND).args(assignment.to_args());
    command.stdin(Stdio::null()).stdout(Stdio::null());
    // SAFETY: the closure runs between fork and exec and makes one async-signal-safe call for each descriptor; it does not allocate.
    unsafe { command.pre_exec(move || keep_open(descriptors)) };
    command.spawn()
}

/// Lets descriptors survive `exec`, in the child only: another child started at the same time does not get them.
fn keep_open(descriptors: [RawFd; 3]) -> io::Result<()> {
    for raw in descriptors {
        if raw >= 0 {
            // SAFETY: the starter holds this descriptor open while it spawns, and a fork copies it.
            let descriptor = unsafe { BorrowedFd::borrow_raw(raw) };
            fcntl_setfd(descriptor, FdFlags::empty())?;
        }
    }
    Ok(())
}

/// The memory, the input pipe and the output pipe a stage was born with. To be called once, by the process made for it.
pub fn inherited(assignment: &Assignment) -> (Option<OwnedFd>, Option<OwnedFd>, Option<OwnedFd>) {
    let own = |raw: RawFd| {
        // SAFETY: the starter left exactly these descriptors open for this process, and nothing else in it knows of them.
        (raw > 2).then(|| unsafe { OwnedFd::from_raw_fd(raw) })
    };
    (
        own(assignment.memory),
        own(assignment.input),
        own(assignment.output),
    )
}

/// The running stages; killed and reaped when dropped early.
struct Stages(Vec<Child>);

impl Stages {
    fn wait_until_ready(&mut self, shared: &Shared, stages: usize) -> io::Result<()> {
        let deadline = Instant::now() + START;
        while (shared.ready().load(Ordering::Acquire) as usize) < stages {
            if self.check()? || Instant::now() > deadline {
                return Err(io::Error::new(
                    io::ErrorKind::TimedOut,
                    "the stages of the chain did not start",
                ));
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(())
    }

    fn wait_until_done(&mut self, at_most: Duration) -> io::Result<()> {
        let deadline = Instant::now() + at_most;
        while !self.check()? {
            if Instant::now() > deadline {
                return Err(io::Error::new(
                    io::ErrorKind::TimedOut,
                    "the chain came to a halt",
                ));
            }
            std::thread::sleep(LOOK);
        }
        Ok(())
    }

    /// Whether all have ended well; an error if one has not.
    fn check(&mut self) -> io::Result<bool> {
        let mut ended = 0;
        for child in &mut self.0 {
            match child.try_wait()? {
                Some(status) if status.success() => ended += 1,
                Some(status) => {
                    return Err(io::Error::other(format!(
                        "a stage of the chain ended with {status}"
                    )));
                }
                None => {}
            }
        }
        Ok(ended == self.0.len())
    }
}

impl Drop for Stages {
    fn drop(&mut self) {
        for child in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
