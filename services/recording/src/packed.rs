//! Files that may be packed by gzip, or be text in UTF-16.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use crate::wide;

/// First bytes of what gzip packs.
pub(crate) const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The content of a file, unpacked and in UTF-8 as it is read.
pub(crate) struct Content {
    read: Box<dyn Read>,
    /// Whether it is packed.
    pub is_packed: bool,
    /// Whether its bytes are those of the file.
    pub is_plain: bool,
}

impl Read for Content {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.read.read(out)
    }
}

/// The content of a file.
pub(crate) fn open(path: &Path) -> io::Result<Content> {
    let mut file = File::open(path)?;
    let mut magic = Vec::new();
    file.by_ref().take(2).read_to_end(&mut magic)?;
    file.rewind()?;
    let is_packed = magic == GZIP;
    let (read, is_converted) = wide::utf8(match is_packed {
        // Several packed one after the other are one text, as `cat` makes of them.
        true => Box::new(MultiGzDecoder::new(BufReader::new(file))),
        false => Box::new(file),
    });
    Ok(Content {
        read,
        is_packed,
        is_plain: !is_packed && !is_converted,
    })
}
