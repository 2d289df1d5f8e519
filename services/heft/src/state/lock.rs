//! The lock of a state: one run at a time. The kernel releases it when the process ends, however that happens.
//!
//! Each write replaces the file, so the new one is locked before it takes the name.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;

use rustix::fs::{CWD, FlockOperation, OFlags, RenameFlags, flock, renameat_with};
use rustix::io::Errno;

use crate::failure::Failure;

/// The locked file of this name; none if there is no such file, or it cannot be opened.
pub(super) fn taken(path: &Path) -> Result<Option<File>, Failure> {
    // Opening a pipe must not block.
    let flags = OFlags::NONBLOCK.bits() as i32;
    let mut options = OpenOptions::new();
    let Ok(file) = options.read(true).custom_flags(flags).open(path) else {
        return Ok(None);
    };
    // The run that held it may have replaced it meanwhile.
    match lock(&file) {
        Ok(()) if is_named(&file, path) => Ok(Some(file)),
        _ => Err(in_use(path)),
    }
}

/// Locks an open file. A file system without locks gives none.
pub(super) fn lock(file: &File) -> io::Result<()> {
    match flock(file, FlockOperation::NonBlockingLockExclusive) {
        Err(Errno::WOULDBLOCK) => Err(Errno::WOULDBLOCK.into()),
        _ => Ok(()),
    }
}

fn is_named(file: &File, path: &Path) -> bool {
    let place = |m: fs::Metadata| (m.dev(), m.ino());
    let (open, named) = (file.metadata(), fs::metadata(path));
    matches!((open.map(place), named.map(place)), (Ok(a), Ok(b)) if a == b)
}

/// Renames a file to a name that no file has: of two runs that start at once, one fails.
pub(super) fn rename_to_new(new: &Path, path: &Path) -> io::Result<()> {
    match renameat_with(CWD, new, CWD, path, RenameFlags::NOREPLACE) {
        // A file system, such as NFS, that cannot do this.
        Err(Errno::INVAL) => fs::rename(new, path),
        renamed => Ok(renamed?),
    }
}

/// The refusal of a state that another run has.
pub(super) fn in_use(path: &Path) -> Failure {
    Failure::input(
        "another run uses this state; of two runs, one would overwrite what the other learns",
        format!("--state {}", path.display()),
        "give each run a file of its own, or end the other run first",
    )
}
