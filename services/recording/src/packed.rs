//! Files that may be compressed by gzip, or text in UTF-16.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;

use flate2::bufread::GzDecoder;

use crate::wide;

/// First bytes of a gzip file.
pub(crate) const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The content of a file, decompressed and converted to UTF-8 while it is read.
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
        true => Box::new(Members(Some(GzDecoder::new(BufReader::new(file))))),
        false => Box::new(file),
    });
    Ok(Content {
        read,
        is_packed,
        is_plain: !is_packed && !is_converted,
    })
}

/// Several gzip members in sequence are one text, as `cat` joins them. Zeros after the last one fill up a block of a disk.
struct Members(Option<GzDecoder<BufReader<File>>>);

impl Read for Members {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.0 {
            let count = member.read(out)?;
            if count > 0 || out.is_empty() {
                return Ok(count);
            }
            let next = self.0.take().map(GzDecoder::into_inner);
            self.0 = next.map(behind_zeros).transpose()?.flatten();
        }
        Ok(0)
    }
}

/// The next member, if the input has other bytes than zeros.
fn behind_zeros(mut file: BufReader<File>) -> io::Result<Option<GzDecoder<BufReader<File>>>> {
    loop {
        let bytes = file.fill_buf()?;
        let (zeros, all) = (bytes.iter().take_while(|b| **b == 0).count(), bytes.len());
        file.consume(zeros);
        if all == 0 {
            return Ok(None);
        }
        if zeros < all {
            return Ok(Some(GzDecoder::new(file)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn members_are_one_text_and_zeros_behind_them_are_none() {
        let pack = |text: &str| {
            let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            packer.write_all(text.as_bytes()).expect("memory");
            packer.finish().expect("memory")
        };
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.gz");
        let read = |bytes: &[u8]| {
            std::fs::write(&path, bytes).expect("written");
            let mut text = String::new();
            open(&path)?.read_to_string(&mut text).map(|_| text)
        };
        let (zeros, two) = ([0; 20_000], [pack("t,speed\n"), pack("0,1\n")].concat());
        for more in [&zeros[..], &zeros[..1], b""] {
            assert_eq!(
                read(&[&two, more].concat()).ok().as_deref(),
                Some("t,speed\n0,1\n")
            );
        }
        assert!(read(&[&two, &b"xyz"[..]].concat()).is_err());
        assert!(read(&two[..two.len() - 9]).is_err());
    }
}
