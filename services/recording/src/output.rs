//! Files that a command writes: they get their name when they are complete, and never replace
//! a file that heft did not write.

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::Error;

/// The unfinished files, for a process that ends without dropping its values.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes every unfinished file, and then calls `end`, which ends the process: for a command that is ended by a signal, in which
/// no value is dropped.
pub fn abandon(end: impl FnOnce()) {
    // The lock is also taken to create a file: none is created while the list is read.
    let unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in unfinished.iter() {
        let _ = std::fs::remove_file(path);
    }
    end();
}

/// An unfinished file. It is written beside its place and moved there by [`Output::finish`]; without
/// that call it is removed.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    /// Its purpose for error messages: "write the estimates".
    doing: &'static str,
    /// The unfinished file; none for a device or a pipe.
    beside: Option<Beside>,
    out: BufWriter<File>,
}

impl Output {
    /// Begins the file `path`. `doing` states its purpose, such as "write the page". The path must not be one of `inputs`. An existing file
    /// must be an earlier result of the same kind, which `is_ours` recognizes by its first bytes.
    ///
    /// # Errors
    /// It would overwrite a file of value, or cannot be created.
    pub fn create(
        doing: &'static str,
        path: &Path,
        inputs: &[&Path],
        is_ours: impl Fn(&[u8]) -> bool,
    ) -> Result<Self, Error> {
        check(path, inputs, is_ours)?;
        let fail = |e| Error::system(doing, path, &e);
        let (beside, file) = if is_standard_output(path) {
            let owned = io::stdout().as_fd().try_clone_to_owned();
            (None, owned.map_err(fail)?.into())
        } else if is_device(path) {
            (None, File::options().write(true).open(path).map_err(fail)?)
        } else {
            let (beside, file) = Beside::create(path).map_err(fail)?;
            (Some(beside), file)
        };
        Ok(Self {
            path: path.to_owned(),
            doing,
            beside,
            out: BufWriter::new(file),
        })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// The file cannot be written; it is then removed.
    pub fn finish(mut self) -> Result<(), Error> {
        let fail = |e| Error::system(self.doing, &self.path, &e);
        self.out.flush().map_err(fail)?;
        if let Some(beside) = &self.beside {
            self.out.get_ref().sync_all().map_err(fail)?;
            std::fs::rename(beside.path(), &self.path).map_err(fail)?;
        }
        Ok(())
    }

    /// Adds bytes.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let written = self.out.write_all(bytes);
        written.map_err(|e| Error::system(self.doing, &self.path, &e))
    }
}

/// A file that is removed when this is dropped, or when a signal ends the process, unless it is kept.
#[derive(Debug)]
pub(crate) struct Unfinished(PathBuf);

impl Unfinished {
    /// Registers a file of this name, which `make` creates.
    pub(crate) fn create<F, E>(
        path: PathBuf,
        make: impl FnOnce(&Path) -> Result<F, E>,
    ) -> Result<(Self, F), E> {
        let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        let file = make(&path)?;
        unfinished.push(path.clone());
        Ok((Self(path), file))
    }

    /// Keeps the complete file.
    pub(crate) fn keep(self) {
        self.forget();
        std::mem::forget(self);
    }

    fn forget(&self) {
        let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        unfinished.retain(|other| *other != self.0);
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
        self.forget();
    }
}

/// A temporary file beside a result, for as long as this lives.
#[derive(Debug)]
pub struct Beside(Unfinished);

impl Beside {
    /// Creates an empty one beside `result`.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn create(result: &Path) -> io::Result<(Self, File)> {
        for number in 0.. {
            let mut name = result.as_os_str().to_owned();
            name.push(format!(".partial-{}-{number}", std::process::id()));
            match Unfinished::create(name.into(), |name| File::create_new(name)) {
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
                created => return created.map(|(unfinished, file)| (Self(unfinished), file)),
            }
        }
        Err(ErrorKind::AlreadyExists.into())
    }

    /// Its name.
    pub fn path(&self) -> &Path {
        &self.0.0
    }
}

/// Whether a result goes to standard output, which then gets no other text.
pub fn is_standard_output(path: &Path) -> bool {
    ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"]
        .map(Path::new)
        .contains(&path)
}

/// Whether a file cannot be replaced: a device, a pipe, or the name of an open file.
pub(crate) fn is_device(path: &Path) -> bool {
    let is_open_file = ["/dev", "/proc"].iter().any(|top| path.starts_with(top));
    path.exists() && (is_open_file && !path.starts_with("/dev/shm") || !path.is_file())
}

/// Whether a result may be written to `path`, see [`Output::create`].
///
/// # Errors
/// It may not; the error says why.
pub fn check(path: &Path, inputs: &[&Path], is_ours: impl Fn(&[u8]) -> bool) -> Result<(), Error> {
    if is_standard_output(path) {
        return Ok(());
    }
    let Ok(there) = std::fs::metadata(path) else {
        return Ok(());
    };
    let refused = |what: &str| {
        let remedy = "choose another name for the result, or move that file away";
        Err(Error::new(what, path.display().to_string(), remedy))
    };
    let is_input = |input: &&Path| {
        std::fs::metadata(input).is_ok_and(|m| (m.dev(), m.ino()) == (there.dev(), there.ino()))
    };
    if there.is_dir() {
        return Err(Error::system(
            "write the result",
            path,
            &ErrorKind::IsADirectory.into(),
        ));
    }
    if there.is_file() && inputs.iter().any(is_input) {
        return refused("the result would overwrite its own input");
    }
    if !there.is_file() || there.len() == 0 {
        return Ok(());
    }
    let mut head = Vec::new();
    File::open(path)
        .and_then(|f| f.take(4096).read_to_end(&mut head))
        .map_err(|e| Error::system("read the earlier result", path, &e))?;
    if !is_ours(&head) {
        return refused("there is a file that is no earlier result; it is not overwritten");
    }
    Ok(())
}

/// The first line of a text, if it is whole.
pub(crate) fn first_line(head: &[u8]) -> Option<&str> {
    let end = head.iter().position(|b| *b == b'\n')?;
    std::str::from_utf8(&head[..end]).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neither_an_input_nor_a_foreign_file_is_overwritten_but_an_earlier_result_is() {
        let dir = tempfile::tempdir().expect("a folder");
        let at = |name: &str| dir.path().join(name);
        let ours = |head: &[u8]| head.starts_with(b"ours");
        let write = |to: &str, inputs: &[&Path]| -> Result<(), Error> {
            let mut out = Output::create("write", &at(to), inputs, ours)?;
            out.put(b"ours, again")?;
            out.finish()
        };
        std::fs::write(at("in"), "ours").expect("writable");
        std::fs::hard_link(at("in"), at("hard")).expect("linkable");
        std::os::unix::fs::symlink(at("in"), at("soft")).expect("linkable");
        std::fs::write(at("foreign"), "theirs").expect("writable");
        for name in ["in", "hard", "soft"] {
            assert!(write(name, &[&at("in")]).is_err(), "{name}");
        }
        assert!(write("foreign", &[]).is_err());
        assert_eq!(std::fs::read(at("in")).expect("there"), b"ours");
        assert_eq!(write("new", &[&at("in")]), Ok(()));
        assert_eq!(write("new", &[&at("in")]), Ok(()), "an earlier result");
        drop(Output::create("write", &at("half"), &[], ours));
        assert_eq!(std::fs::read_dir(dir.path()).expect("there").count(), 5);
    }

    #[test]
    fn a_file_that_cannot_be_read_is_not_said_to_be_anothers() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("closed");
        std::fs::write(&path, "ours").expect("writable");
        let closed = std::fs::Permissions::from_mode(0o200);
        std::fs::set_permissions(&path, closed).expect("owned");
        let said = check(&path, &[], |_| true).map_err(|e| e.to_string());
        match File::open(&path) {
            Ok(_) => assert_eq!(said, Ok(()), "root reads all"),
            Err(why) => assert!(said.is_err_and(|said| said.contains(&why.to_string()))),
        }
    }
}
