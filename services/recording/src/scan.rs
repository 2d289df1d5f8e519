//! The records of an MCAP file, as far as they are whole.

use std::collections::BTreeMap;
use std::io::Read;

use mcap::MAGIC;
use mcap::records::{Channel, ChunkHeader, MessageHeader, Record, op};

use crate::writer::{Metadata, RECORD};

/// A schema of the file.
#[derive(Debug, Clone)]
pub(crate) struct Schema {
    pub name: String,
    pub encoding: String,
    pub data: Vec<u8>,
}

/// Where a chunk lies.
#[derive(Debug, Clone)]
pub(crate) struct Chunk {
    pub header: ChunkHeader,
    /// Range of its compressed records in the file.
    pub start: usize,
    /// End of that range.
    pub end: usize,
}

/// What the file holds.
#[derive(Debug, Default)]
pub(crate) struct Scan {
    pub metadata: Metadata,
    pub schemas: BTreeMap<u16, Schema>,
    pub channels: BTreeMap<u16, Channel>,
    pub chunks: Vec<Chunk>,
    /// Chunks that are there but cannot be unpacked.
    pub damaged: usize,
    /// Bytes after the last whole record.
    pub lost_bytes: usize,
    /// The file ends as a finished recording does.
    pub complete: bool,
}

impl Scan {
    /// Scans a file; `None` if it is no MCAP file.
    pub(crate) fn new(bytes: &[u8]) -> Option<Self> {
        let mut at = MAGIC.len();
        if bytes.get(..at)? != MAGIC {
            return None;
        }
        let mut scan = Self::default();
        while let Some((opcode, body, end)) = record(bytes, at) {
            if !scan.add(opcode, body, end) {
                break;
            }
            at = end;
            if opcode == op::FOOTER {
                scan.complete = bytes.get(at..) == Some(MAGIC) && index_is_whole(bytes, body, end);
                break;
            }
        }
        scan.lost_bytes = if scan.complete { 0 } else { bytes.len() - at };
        if !scan.complete {
            scan.look_into_chunks(bytes);
        }
        Some(scan)
    }

    /// Takes in a record; false if it is not one that can stand there.
    fn add(&mut self, opcode: u8, body: &[u8], end: usize) -> bool {
        if !matches!(opcode, op::METADATA | op::CHUNK | op::SCHEMA | op::CHANNEL) {
            return matches!(opcode, op::HEADER..=op::DATA_END | 0x80..);
        }
        let Ok(record) = mcap::parse_record(opcode, body) else {
            return false;
        };
        match record {
            Record::Metadata(m) if m.name == RECORD => self.metadata.extend(m.metadata),
            Record::Chunk { header, data } => {
                let start = end - body.len() + header_length(&header);
                self.chunks.push(Chunk {
                    start,
                    end: start + data.len(),
                    header,
                });
            }
            other => self.define(other),
        }
        true
    }

    fn define(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                let schema = Schema {
                    name: header.name,
                    encoding: header.encoding,
                    data: data.into_owned(),
                };
                self.schemas.insert(header.id, schema);
            }
            Record::Channel(channel) => {
                self.channels.insert(channel.id, channel);
            }
            _ => {}
        }
    }

    /// Without the index at the end, the channels are named only inside the chunks.
    fn look_into_chunks(&mut self, bytes: &[u8]) {
        self.schemas.clear();
        self.channels.clear();
        for chunk in core::mem::take(&mut self.chunks) {
            match chunk.records(bytes, |record| self.define(record)) {
                Some(()) => self.chunks.push(chunk),
                None => self.damaged += 1,
            }
        }
    }
}

impl Chunk {
    /// Its records, unpacked; `None` if they cannot be unpacked or their check sum is wrong.
    fn unpack(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let data = bytes.get(self.start..self.end)?;
        let size = self.header.uncompressed_size;
        let mut unpacked = Vec::new();
        match self.header.compression.as_str() {
            "" => unpacked.extend_from_slice(data),
            "lz4" => {
                // The limit comes first: a damaged file may say any size.
                let decoder = lz4::Decoder::new(data).ok()?;
                decoder
                    .take(size.saturating_add(1))
                    .read_to_end(&mut unpacked)
                    .ok()?;
            }
            _ => return None,
        }
        let crc = self.header.uncompressed_crc;
        let whole = unpacked.len() as u64 == size;
        (whole && (crc == 0 || crc32fast::hash(&unpacked) == crc)).then_some(unpacked)
    }

    /// Calls `found` with each of its records; `None` if the chunk is damaged (then, unless its
    /// check sum was left out, nothing was found).
    pub(crate) fn records(&self, bytes: &[u8], mut found: impl FnMut(Record<'_>)) -> Option<()> {
        let unpacked = self.unpack(bytes)?;
        let mut at = 0;
        while at < unpacked.len() {
            let (opcode, body, end) = record(&unpacked, at)?;
            if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                found(mcap::parse_record(opcode, body).ok()?);
            }
            at = end;
        }
        Some(())
    }

    /// Calls `found` with each of its messages; `None` if the chunk is damaged.
    pub(crate) fn messages(
        &self,
        bytes: &[u8],
        mut found: impl FnMut(&MessageHeader, &[u8]),
    ) -> Option<()> {
        self.records(bytes, |record| {
            if let Record::Message { header, data } = record {
                found(&header, &data);
            }
        })
    }
}

/// Whether the index has the check sum that the footer says; `end` is the end of the footer.
fn index_is_whole(bytes: &[u8], footer: &[u8], end: usize) -> bool {
    let Ok(Record::Footer(footer)) = mcap::parse_record(op::FOOTER, footer) else {
        return false;
    };
    let start = usize::try_from(footer.summary_start).unwrap_or(usize::MAX);
    let index = bytes.get(start..end - 4).unwrap_or_default();
    footer.summary_start == 0 || crc32fast::hash(index) == footer.summary_crc
}

/// Opcode, body and end of the record at `at`; `None` if it is not whole.
fn record(bytes: &[u8], at: usize) -> Option<(u8, &[u8], usize)> {
    let (head, rest) = bytes.get(at..)?.split_first_chunk::<9>()?;
    let [opcode, length @ ..] = *head;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    Some((opcode, rest.get(..length)?, at + 9 + length))
}

/// Bytes of a chunk record before its compressed records.
fn header_length(header: &ChunkHeader) -> usize {
    8 + 8 + 8 + 4 + 4 + header.compression.len() + 8
}
