//! Files that may be packed by gzip.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

/// First bytes of what gzip packs.
pub(crate) const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The content of a file, unpacked as it is read where it is packed.
pub(crate) fn open(path: &Path) -> io::Result<Box<dyn Read>> {
    let mut file = File::open(path)?;
    let mut magic = Vec::new();
    file.by_ref().take(2).read_to_end(&mut magic)?;
    file.rewind()?;
    if magic != GZIP {
        return Ok(Box::new(file));
    }
    // Several packed one after the other are one text, as `cat` makes of them.
    Ok(Box::new(MultiGzDecoder::new(BufReader::new(file))))
}
