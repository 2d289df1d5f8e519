//! File descriptors that are kept back, so that a service can be started again when all others are
//! in use: by viewers of the live page, above all.

use std::fs::File;

use rustix::process::{Resource, getrlimit};

use crate::failure::Failure;

/// What a clean-up and a start take, with some to spare.
const SPARE: usize = 24;
/// What a run takes in its supervisor, without viewers, and in each service.
const NEEDED: u64 = 192;
/// The same where its services are threads of the supervisor: 390 counted, without viewers.
const NEEDED_WITH_THREADS: u64 = 512;

/// Descriptors in reserve.
#[derive(Default)]
pub struct Spare(Vec<File>);

impl Spare {
    /// As many as there are to be had.
    pub fn fill(&mut self) {
        while self.0.len() < SPARE
            && let Ok(file) = File::open("/dev/null")
        {
            self.0.push(file);
        }
    }

    /// Lets go of them.
    pub fn release(&mut self) {
        self.0.clear();
    }
}

/// Whether a run has what it needs.
pub fn check_limit(threads: bool) -> Result<(), Failure> {
    let needed = if threads { NEEDED_WITH_THREADS } else { NEEDED };
    match getrlimit(Resource::Nofile).current {
        Some(limit) if limit < needed => Err(Failure::input(
            format!("{limit} open files are permitted, a process of a run needs {needed}"),
            "the limits of this shell or unit",
            "ulimit -n 4096, or LimitNOFILE=4096 in the systemd unit",
        )),
        _ => Ok(()),
    }
}
