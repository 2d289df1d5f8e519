//! Identity of a run among the runs of its machine, for the fleet: a random id, and a count stored on the machine. A clock
//! that goes back, or that is ahead, changes neither.

use std::fs;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, Read, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};

/// Bits of an id: readers that parse numbers as floating point represent it exactly.
const BITS: u32 = 52;
/// Longest text that is read as a count \[bytes\].
const LONGEST: u64 = 20;

/// A run among the runs of its machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FleetRun {
    /// Random; never 0.
    #[serde(rename = "run")]
    pub id: u64,
    /// Number of runs that the machine has counted, including this one; 0 if it cannot be stored.
    #[serde(rename = "run_count")]
    count: u64,
}

impl FleetRun {
    /// A run with a random id, not counted yet.
    pub fn draw() -> Self {
        // Two sources of randomness of the system: one is enough.
        let mut hasher = RandomState::new().build_hasher();
        hasher.write_u32(std::process::id());
        let mut bytes = [0; 8];
        let drawn = fs::File::open("/dev/urandom").and_then(|mut f| f.read_exact(&mut bytes));
        let chance = drawn.map_or(0, |()| u64::from_le_bytes(bytes)) ^ hasher.finish();
        Self {
            id: (chance >> (u64::BITS - BITS)).max(1),
            count: 0,
        }
    }

    /// Counts it as a run of this machine. A failure is reported, and the run goes on.
    pub fn count(mut self, site: &str, machine: &str) -> Self {
        let counted = folder()
            .ok_or_else(|| {
                io::Error::other("neither STATE_DIRECTORY, XDG_STATE_HOME nor HOME is set")
            })
            .and_then(|folder| {
                let is_name = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
                if !format!("{site}{machine}").chars().all(is_name) {
                    return Err(io::Error::other("its name is none"));
                }
                Ok(folder)
            })
            .and_then(|folder| next(&folder, &format!("runs-{site}-{machine}")));
        match counted {
            Ok(count) => self.count = count,
            Err(error) => {
                tracing::warn!(%error, "the runs of this machine are not counted; the fleet cannot tell if one was not heard at all");
            }
        }
        self
    }
}

/// Folder of the counts: the unit's own folder, else the user's.
fn folder() -> Option<PathBuf> {
    let path = |name| {
        std::env::var_os(name)
            .map(PathBuf::from)
            .filter(|p| p.is_absolute())
    };
    let own = path("STATE_DIRECTORY");
    let user = || path("XDG_STATE_HOME").or_else(|| Some(path("HOME")?.join(".local/state")));
    own.or_else(|| Some(user()?.join("heft")))
}

/// Increments the count in a file: under a lock, and on the disk before it is used.
fn next(folder: &Path, name: &str) -> io::Result<u64> {
    fs::DirBuilder::new()
        .recursive(true)
        .mode(0o700)
        .create(folder)?;
    let mut options = fs::OpenOptions::new();
    let options = options.read(true).write(true).create(true).truncate(false);
    // Never blocks on a pipe, nor follows a link.
    let flags = (rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOFOLLOW).bits();
    let mut file = options
        .mode(0o600)
        .custom_flags(flags as i32)
        .open(folder.join(name))?;
    if !file.metadata()?.is_file() {
        return Err(io::Error::other(format!("{name} is no file")));
    }
    flock(&file, FlockOperation::LockExclusive)?;
    let mut text = String::new();
    // A file that is cut or damaged restarts the count: readers take a lower count for a new one.
    let _ = (&mut file).take(LONGEST).read_to_string(&mut text);
    let count = text.trim().parse::<u64>().unwrap_or(0) % (1 << BITS) + 1;
    io::Seek::rewind(&mut file)?;
    file.set_len(0)?;
    file.write_all(format!("{count:<19}\n").as_bytes())?;
    file.sync_all()?;
    Ok(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_counted_and_their_ids_differ() {
        let folder = tempfile::tempdir().unwrap();
        let its = folder.path().join("a/b");
        let counts: Vec<u64> = (0..12).map(|_| next(&its, "runs").unwrap()).collect();
        assert_eq!(counts, (1..=12).collect::<Vec<u64>>());
        fs::write(its.join("runs"), "nonsense, and long of that\n").unwrap();
        assert_eq!(next(&its, "runs").unwrap(), 1, "begins anew");
        assert_eq!(next(&its, "runs").unwrap(), 2);
        fs::create_dir(its.join("folder")).unwrap();
        assert!(next(&its, "folder").is_err());
        let ids: std::collections::BTreeSet<u64> = (0..1000).map(|_| FleetRun::draw().id).collect();
        assert_eq!(ids.len(), 1000);
        assert!(ids.iter().all(|id| (1..1 << BITS).contains(id)));
    }
}
