//! Small files written by hand, read completely: up to a size limit, so that a device or a wrong file is an error and does not block.

use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

use crate::Error;

/// Largest signal map or DBC file \[bytes\].
const LARGEST: u64 = 50_000_000;

/// Opens a file. A named pipe is refused: opening it would block until it has a writer. A pipe of a shell, `<(command)`, has one.
///
/// # Errors
/// It cannot be opened, or it is a named pipe.
pub fn open_file(path: &Path) -> io::Result<File> {
    if fs::symlink_metadata(path).is_ok_and(|there| there.file_type().is_fifo()) {
        return Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "this is a named pipe, and nobody may ever write into it",
        ));
    }
    File::open(path)
}

/// The content of a file; `what` names its kind in errors.
pub(crate) fn read(path: &Path, what: &str) -> Result<Vec<u8>, Error> {
    let mut content = Vec::new();
    let read = open_file(path).and_then(|f| f.take(LARGEST + 1).read_to_end(&mut content));
    read.map_err(|e| Error::system(&format!("read the {what}"), path, &e))?;
    if content.len() as u64 > LARGEST {
        return Err(Error::new(
            format!("the file has more than {LARGEST} bytes: no {what} is so large"),
            path.display().to_string(),
            format!("name a {what}, which is a text"),
        ));
    }
    Ok(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_without_end_is_refused() {
        let endless = read(Path::new("/dev/zero"), "DBC file").expect_err("too large");
        assert!(
            endless.what.contains("no DBC file is so large"),
            "{endless}"
        );
    }
}
