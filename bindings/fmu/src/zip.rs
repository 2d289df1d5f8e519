//! Zip archive of an FMU; its members are deflated if that makes them smaller.

use miniz_oxide::deflate::compress_to_vec;

/// Compression level of 10: higher ones take longer and save little.
const LEVEL: u8 = 9;

/// Appends members and then the table of contents.
#[derive(Default)]
pub struct Zip {
    bytes: Vec<u8>,
    contents: Vec<u8>,
    count: u16,
}

/// 1 January 1980, so that the same input gives the same file.
const DATE: u16 = 1 << 5 | 1;

impl Zip {
    /// Adds a file. `name` has forward slashes.
    ///
    /// # Panics
    /// The archive reaches 4 GiB.
    pub fn add(&mut self, name: &str, data: &[u8]) {
        let offset = u32::try_from(self.bytes.len()).expect("less than 4 GiB");
        let size = u32::try_from(data.len()).expect("less than 4 GiB");
        let deflated = compress_to_vec(data, LEVEL);
        let (method, packed) = if deflated.len() < data.len() {
            (8, deflated.as_slice())
        } else {
            (0, data)
        };
        let packed_size = u32::try_from(packed.len()).expect("less than 4 GiB");
        let length = u16::try_from(name.len()).expect("a short name");
        // The common part of local header and table of contents: version 2.0, no flags, method
        // (8 deflated, 0 stored), time, date, checksum, sizes, length of the name, no extra field.
        let mut common = Vec::new();
        for half in [20, 0, method, 0, DATE] {
            common.extend(u16::to_le_bytes(half));
        }
        for word in [crc32fast::hash(data), packed_size, size] {
            common.extend(word.to_le_bytes());
        }
        common.extend(length.to_le_bytes());
        common.extend([0, 0]);

        self.bytes.extend(b"PK\x03\x04");
        self.bytes.extend(&common);
        self.bytes.extend(name.as_bytes());
        self.bytes.extend(packed);

        // Made by 2.0 under Unix; no comment, first disk, binary, readable and executable by all.
        self.contents.extend(b"PK\x01\x02\x14\x03");
        self.contents.extend(&common);
        self.contents.extend([0; 6]);
        self.contents.extend((0o100_755_u32 << 16).to_le_bytes());
        self.contents.extend(offset.to_le_bytes());
        self.contents.extend(name.as_bytes());
        self.count += 1;
    }

    /// The whole archive.
    #[must_use]
    pub fn finish(mut self) -> Vec<u8> {
        let (offset, size) = (self.bytes.len() as u32, self.contents.len() as u32);
        self.bytes.extend(&self.contents);
        self.bytes.extend(b"PK\x05\x06\0\0\0\0");
        self.bytes.extend(self.count.to_le_bytes());
        self.bytes.extend(self.count.to_le_bytes());
        self.bytes.extend(size.to_le_bytes());
        self.bytes.extend(offset.to_le_bytes());
        self.bytes.extend([0, 0]);
        self.bytes
    }
}
