//! Room in memory: what a run and each of its processes need, in shared memory and in the home of the domain.

use std::path::Path;

use crate::Error;
use crate::home::SHARED_MEMORY;

/// Who needs room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// A whole run: with less it would end in SIGBUS.
    Run,
    /// One process that is started again.
    Service,
}

impl Needs {
    /// Shared memory \[bytes\], with margin, and number of names there: an excavator has 250.
    const fn shared(self) -> (u64, u64) {
        match self {
            Self::Run => (64 << 20, 300),
            Self::Service => (16 << 20, 64),
        }
    }

    /// The same for the files of iceoryx2 in the home, of which a run has 190 kB.
    const fn home(self) -> (u64, u64) {
        match self {
            Self::Run => (1 << 20, 300),
            Self::Service => (128 << 10, 64),
        }
    }
}

/// Free shared memory \[bytes\].
pub fn free_shared_memory() -> u64 {
    rustix::fs::statvfs(SHARED_MEMORY).map_or(0, |s| s.f_bavail.saturating_mul(s.f_frsize))
}

/// The first file system that has too little room; the home may be on another one than shared memory.
pub fn lack(home: &Path, needs: Needs) -> Option<Error> {
    let shared = lack_in(Path::new(SHARED_MEMORY), "shared memory", needs.shared());
    shared.or_else(|| lack_in(home, "the folder of the domains", needs.home()))
}

fn lack_in(place: &Path, called: &str, (bytes, names): (u64, u64)) -> Option<Error> {
    let about = rustix::fs::statvfs(place).ok()?;
    let free = about.f_bavail.saturating_mul(about.f_frsize);
    let (what, how) = if free < bytes {
        let (free, bytes) = (free >> 10, bytes >> 10);
        let what = format!("{called} has {free} kB free, {bytes} kB are needed");
        (what, "larger (containers: --shm-size)")
    } else if about.f_files > 0 && about.f_favail < names {
        // A file system that does not count names reports zero.
        let left = about.f_favail;
        let what = format!("{called} takes {left} more names, {names} are needed");
        (what, "with more names (nr_inodes)")
    } else {
        return None;
    };
    let remedy = format!("run `heft doctor --clean`, remove other files there, or mount it {how}");
    Some(Error::new(what, place.display().to_string(), remedy))
}
