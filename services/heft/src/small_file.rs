//! Files written by hand: read up to a size limit, so that a device or a wrong file is an error and does not block.

use std::io::Read;
use std::path::Path;

use crate::failure::Failure;

/// Size limit \[bytes\]: six times a description with every key and its meaning.
const LARGEST: u64 = 100_000;

/// The text of a description.
pub fn text(file: &Path) -> Result<String, Failure> {
    let mut text = String::new();
    let read =
        recording::open_file(file).and_then(|f| f.take(LARGEST + 1).read_to_string(&mut text));
    read.map_err(|error| Failure::file("read", file, &error))?;
    if text.len() as u64 > LARGEST {
        return Err(Failure::input(
            format!("the file has more than {LARGEST} bytes: no machine file is so large"),
            file.display(),
            "name a machine file, a text in TOML of some kilobytes",
        ));
    }
    // A full disk leaves empty files; /dev/null is empty on purpose.
    if text.trim().is_empty() && file.is_file() {
        return Err(Failure::input(
            "the machine file is empty",
            file.display(),
            "get it anew, or leave it out for the reference machine; `heft check --print` writes one",
        ));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_named_pipe_is_refused_and_not_waited_for() {
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join("m.toml");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.is_ok_and(|status| status.success()));
        let error = text(&pipe).expect_err("a pipe");
        assert!(error.to_string().contains("named pipe"), "{error}");
    }

    #[test]
    fn a_device_without_end_and_a_file_of_nothing_are_refused() {
        let endless = text(Path::new("/dev/zero")).expect_err("too large");
        assert!(endless.to_string().contains("100000 bytes"), "{endless}");
        assert_eq!(text(Path::new("/dev/null")).expect("empty"), "");
        let left = tempfile::NamedTempFile::new().expect("a file");
        let error = text(left.path()).expect_err("nothing in it");
        assert!(error.to_string().contains("is empty"), "{error}");
    }
}
