//! File descriptors held in reserve, so that a service can be restarted when all others are
//! in use, above all by viewers of the live page.

use std::fs::File;

use rustix::process::{Resource, getrlimit};

use crate::failure::Failure;

/// Descriptors for a clean-up and a start, with a margin.
const SPARE: usize = 24;
/// Descriptors of a run: in its supervisor, without viewers, and in each service.
const NEEDED: u64 = 192;
/// Descriptors of a run whose services are threads of the supervisor: 390 counted, without viewers.
const NEEDED_WITH_THREADS: u64 = 512;

/// Address space of one process with services as threads \[bytes\]: 1.13 GB were counted, most of it stacks and arenas of threads. With
/// less the allocator ends the process during a run.
const ADDRESSES_WITH_THREADS: u64 = 1200 << 20;

/// Size of the largest file of a run in shared memory, with a margin: more than 1500 and less than 2000 kB were counted.
const FILE_BYTES: u64 = 2 << 20;

/// Descriptors in reserve.
#[derive(Default)]
pub struct Spare(Vec<File>);

impl Spare {
    /// Takes descriptors up to the reserve, or as many as the system gives.
    pub fn fill(&mut self) {
        while self.0.len() < SPARE
            && let Ok(file) = File::open("/dev/null")
        {
            self.0.push(file);
        }
    }

    /// Releases them.
    pub fn release(&mut self) {
        self.0.clear();
    }
}

/// Checks that a run may open enough descriptors.
pub fn check_limit(threads: bool) -> Result<(), Failure> {
    let needed = if threads { NEEDED_WITH_THREADS } else { NEEDED };
    match getrlimit(Resource::Nofile).current {
        Some(limit) if limit < needed => Err(Failure::input(
            format!("{limit} open files are permitted, a process of a run needs {needed}"),
            "the limits of this shell or unit",
            "ulimit -n 4096, or LimitNOFILE=4096 in the systemd unit",
        )),
        _ => check_addresses(getrlimit(Resource::As).current.filter(|_| threads))
            .and_then(|()| check_file_size(getrlimit(Resource::Fsize).current)),
    }
}

/// Checks that a file may have the size of a channel in shared memory.
fn check_file_size(limit: Option<u64>) -> Result<(), Failure> {
    match limit {
        Some(limit) if limit < FILE_BYTES => Err(Failure::input(
            format!(
                "files of {} KiB are permitted, a channel in shared memory needs {}",
                limit >> 10,
                FILE_BYTES >> 10
            ),
            "the limits of this shell or unit",
            "ulimit -f unlimited, or LimitFSIZE=infinity in the systemd unit",
        )),
        _ => Ok(()),
    }
}

/// Checks that a process with threads may map enough memory.
fn check_addresses(limit: Option<u64>) -> Result<(), Failure> {
    match limit {
        Some(limit) if limit < ADDRESSES_WITH_THREADS => Err(Failure::input(
            format!(
                "{} MiB of address space are permitted, a run with --threads needs {}",
                limit >> 20,
                ADDRESSES_WITH_THREADS >> 20
            ),
            "the limits of this shell or unit (ulimit -v, LimitAS)",
            "permit more, or run without --threads: each of its processes needs less",
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_little_address_space_for_threads_is_named() {
        assert!(check_addresses(None).is_ok());
        assert!(check_addresses(Some(2 << 30)).is_ok());
        let error = check_addresses(Some(300 << 20)).expect_err("too little");
        assert!(
            error.to_string().contains("300 MiB of address space"),
            "{error}"
        );
    }

    #[test]
    fn a_limit_of_files_that_shared_memory_exceeds_is_named() {
        assert!(check_file_size(None).is_ok());
        assert!(check_file_size(Some(1 << 30)).is_ok());
        let error = check_file_size(Some(100 << 10)).expect_err("too little");
        let words = ["files of 100 KiB", "ulimit -f unlimited"];
        assert!(
            words.iter().all(|w| error.to_string().contains(w)),
            "{error}"
        );
    }
}
