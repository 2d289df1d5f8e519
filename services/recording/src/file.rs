//! Files of recordings: read at any place without loading them into memory, locked while
//! they are written.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::time::{Duration, Instant};

/// Longest record that is read into memory [bytes], whatever its length field states.
pub(crate) const LIMIT: u64 = 64 << 20;

/// Opens a file that can be read more than once. Opening a pipe would block until it has a writer.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    let about = std::fs::metadata(path)?;
    if about.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !about.is_file() {
        return Err(io::ErrorKind::NotSeekable.into());
    }
    File::open(path)
}

/// A file that is read at any place. Its length is that at the time of opening, so that
/// a growing file is read consistently.
#[derive(Debug)]
pub(crate) struct Bytes {
    file: File,
    /// Length [bytes].
    pub len: u64,
}

impl Bytes {
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let file = open(path)?;
        let len = file.metadata()?.len();
        Ok(Self { file, len })
    }

    /// Fills `out` from `at` on; `None` if the file ends or the disk fails.
    pub(crate) fn fill(&self, at: u64, out: &mut [u8]) -> Option<()> {
        let end = at.checked_add(out.len() as u64)?;
        (end <= self.len).then_some(())?;
        self.file.read_exact_at(out, at).ok()
    }

    /// The bytes from `at` to `end`; `None` also for more than [`LIMIT`].
    pub(crate) fn range(&self, at: u64, end: u64) -> Option<Vec<u8>> {
        let length = end.checked_sub(at)?;
        (end <= self.len && length <= LIMIT).then_some(())?;
        let mut bytes = vec![0; length as usize];
        self.fill(at, &mut bytes)?;
        Some(bytes)
    }

    /// Whether a writer has the file open.
    pub(crate) fn is_being_written(&self) -> bool {
        let locked = matches!(self.file.try_lock_shared(), Err(TryLockError::WouldBlock));
        let _ = self.file.unlock();
        locked
    }
}

/// Why a file could not be opened for writing.
pub(crate) enum ClaimError {
    /// It is not empty, or has a writer.
    Exists,
    /// The system refused.
    System(io::Error),
}

/// Time for which a writer waits for a lock: readers test it by locking the file for a moment.
const PATIENCE: Duration = Duration::from_millis(500);

/// Opens `path` for writing: a new file, or an empty one that was reserved. An existing file is never
/// truncated. The lock lasts as long as the file is open, so at most as long as the process.
pub(crate) fn take(path: &Path) -> Result<File, ClaimError> {
    let mut options = OpenOptions::new();
    let file = options.write(true).create(true).truncate(false).open(path);
    let file = file.map_err(ClaimError::System)?;
    let begun = Instant::now();
    loop {
        match file.try_lock() {
            Ok(()) => break,
            Err(TryLockError::WouldBlock) if begun.elapsed() > PATIENCE => {
                return Err(ClaimError::Exists);
            }
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(1)),
            // A file system without locks: the file stays unlocked.
            Err(TryLockError::Error(_)) => break,
        }
    }
    let about = file.metadata().map_err(ClaimError::System)?;
    if about.is_file() && about.len() > 0 {
        return Err(ClaimError::Exists);
    }
    Ok(file)
}
