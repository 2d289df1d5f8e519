//! Files that people write by hand: read up to a size, so that a device or a wrong file is an error and not a wait.

use std::fs::File;
use std::io::{Error, Read};
use std::path::Path;

/// Six times a description with every key and its meaning \[bytes\].
const LARGEST: u64 = 100_000;

/// The text of a description.
pub fn text(file: &Path) -> std::io::Result<String> {
    let mut text = String::new();
    File::open(file)?
        .take(LARGEST + 1)
        .read_to_string(&mut text)?;
    if text.len() as u64 > LARGEST {
        let why = format!("it has more than {LARGEST} bytes: no description is so large");
        return Err(Error::other(why));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_without_end_is_refused_and_an_empty_one_read() {
        let endless = text(Path::new("/dev/zero")).expect_err("too large");
        assert!(endless.to_string().contains("100000 bytes"), "{endless}");
        assert_eq!(text(Path::new("/dev/null")).expect("empty"), "");
    }
}
