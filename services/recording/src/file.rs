//! Files as recordings need them: read at any place without holding them in memory, locked while
//! they are written.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::time::{Duration, Instant};

/// No record that is taken into memory is longer than this, whatever its length field says.
pub(crate) const LIMIT: u64 = 64 << 20;

/// Opens a file that can be read more than once. To open a pipe waits until somebody writes it.
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

/// A file that is read at any place. Its length is that of the moment when it was opened, so that
/// a file that still grows reads as one thing.
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

    /// Fills `out` from `at` on; `None` where the file or the disk does not give it.
    pub(crate) fn fill(&self, at: u64, out: &mut [u8]) -> Option<()> {
        let end = at.checked_add(out.len() as u64)?;
        (end <= self.len).then_some(())?;
        self.file.read_exact_at(out, at).ok()
    }

    /// The bytes from `at` to `end`; `None` also where there are more than [`LIMIT`].
    pub(crate) fn range(&self, at: u64, end: u64) -> Option<Vec<u8>> {
        let length = end.checked_sub(at)?;
        (end <= self.len && length <= LIMIT).then_some(())?;
        let mut bytes = vec![0; length as usize];
        self.fill(at, &mut bytes)?;
        Some(bytes)
    }

    /// Whether somebody writes the file at this moment.
    pub(crate) fn is_being_written(&self) -> bool {
        let locked = matches!(self.file.try_lock_shared(), Err(TryLockError::WouldBlock));
        let _ = self.file.unlock();
        locked
    }
}

/// Why a file could not be taken for writing.
pub(crate) enum ClaimError {
    /// There is something in it, or somebody else writes it.
    Exists,
    /// The system refused.
    System(io::Error),
}

/// A reader looks whether a file is locked by locking it for a moment; a writer waits that long.
const PATIENCE: Duration = Duration::from_millis(500);

/// Takes `path` for writing: a new file, or an empty one that was reserved. Nothing that exists is
/// cut off. The lock lasts as long as the file is open, so also no longer than the process.
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
            // A file system without locks: then there are none.
            Err(TryLockError::Error(_)) => break,
        }
    }
    let about = file.metadata().map_err(ClaimError::System)?;
    if about.is_file() && about.len() > 0 {
        return Err(ClaimError::Exists);
    }
    Ok(file)
}
