//! The undamaged contents of an MCAP file. The file is read from record to record. After
//! an implausible record, the search continues byte by byte to the next chunk with a correct check sum,
//! so that a damaged length hides nothing after it.

use std::collections::BTreeMap;
use std::fmt;
use std::io::Read;
use std::path::Path;

use mcap::MAGIC;
use mcap::records::op;

use crate::file::{Bytes, LIMIT};
use crate::record::{self, CHUNK_HEAD, Channel, ChunkHead, HEAD, Packing, Schema};
use crate::writer::{CLOCK, JUMP, METADATA_SUM, Metadata, RECORD, WITH_SUM, sum_of};

/// A section of a file without a complete record.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Damage {
    /// Its begin [bytes].
    pub at: u64,
    /// Its length [bytes].
    pub bytes: u64,
    /// Kind of damage, as a text.
    pub what: &'static str,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, bytes, what } = self;
        write!(f, "{what} at byte {at} ({bytes} bytes)")
    }
}

/// Place of a chunk.
#[derive(Debug, Clone)]
pub(crate) struct Chunk {
    pub head: ChunkHead,
    /// Begin of its record.
    pub at: u64,
    /// Begin of its packed records.
    pub start: u64,
    /// End of the packed records, and of the record.
    pub end: u64,
}

/// The contents of the file.
#[derive(Debug, Default)]
pub(crate) struct Scan {
    pub metadata: Metadata,
    pub schemas: BTreeMap<u16, Schema>,
    pub channels: BTreeMap<u16, Channel>,
    pub chunks: Vec<Chunk>,
    /// Begins and ends of the bodies of messages outside of chunks, which heft never writes.
    pub loose: Vec<(u64, u64)>,
    /// Damaged sections between complete records, and damaged chunks.
    pub damage: Vec<Damage>,
    /// Jumps of the wall clock, in words.
    pub jumps: Vec<String>,
    /// Bytes after the last whole record.
    pub lost_bytes: u64,
    /// The file has the end of a finished recording.
    pub complete: bool,
    /// Begin of the index, from the end of the file.
    index: Option<u64>,
    /// The record for the end of the data was read.
    data_ended: bool,
}

/// Result of reading the record at a place.
enum Step {
    Next(u64),
    Footer(u64),
    Nothing,
}

impl Scan {
    /// Scans a file; `None` if it is no MCAP file.
    pub(crate) fn new(bytes: &Bytes) -> Option<Self> {
        let mut magic = [0; MAGIC.len()];
        bytes.fill(0, &mut magic)?;
        if magic != MAGIC {
            return None;
        }
        let mut scan = Self {
            index: index_start(bytes),
            ..Self::default()
        };
        let mut at = MAGIC.len() as u64;
        while at < bytes.len {
            match scan.take(bytes, at) {
                Step::Next(end) => at = end,
                Step::Footer(end) => {
                    let behind = end + MAGIC.len() as u64;
                    let is_closed = bytes.range(end, behind).as_deref() == Some(MAGIC);
                    let next = bytes.range(behind, behind + MAGIC.len() as u64);
                    let is_joined = is_closed && next.as_deref() == Some(MAGIC);
                    if is_joined {
                        scan.damage.push(Damage {
                            at: behind,
                            bytes: bytes.len - behind,
                            what: "another recording, joined to this one and not read, begins",
                        });
                    }
                    let is_whole = || behind == bytes.len && scan.index_is_whole(bytes, end);
                    scan.complete = is_joined || is_closed && is_whole();
                    at = if scan.complete { bytes.len } else { at };
                    break;
                }
                Step::Nothing => {
                    let found = scan.hidden_chunk(bytes, at);
                    let found = found.or_else(|| scan.step_over(bytes, at));
                    match found.or_else(|| scan.search(bytes, at)) {
                        Some(end) => at = end,
                        None => break,
                    }
                }
            }
        }
        scan.lost_bytes = bytes.len - at;
        scan.check_metadata(bytes);
        if !scan.complete || scan.channels.is_empty() {
            scan.look_into_chunks(bytes);
        }
        Some(scan)
    }

    /// Reads the record at `at`.
    fn take(&mut self, bytes: &Bytes, at: u64) -> Step {
        let Some((opcode, length)) = head(bytes, at) else {
            return Step::Nothing;
        };
        let start = at + HEAD;
        let Some(end) = start.checked_add(length).filter(|end| *end <= bytes.len) else {
            return Step::Nothing;
        };
        let body = || bytes.range(start, end);
        let whole = match opcode {
            op::CHUNK => chunk_at(bytes, at)
                .filter(|c| c.end == end)
                .map(|chunk| self.chunks.push(chunk)),
            op::METADATA => body()
                .and_then(|body| record::metadata(&body))
                .map(|(name, pairs)| self.add_metadata(&name, pairs)),
            op::SCHEMA => body()
                .and_then(|body| record::schema(&body))
                .map(|schema| drop(self.schemas.insert(schema.id, schema))),
            op::CHANNEL => body()
                .and_then(|body| record::channel(&body))
                .map(|channel| drop(self.channels.insert(channel.id, channel))),
            op::MESSAGE => self.is_loose(bytes, start, end).then(|| {
                self.loose.push((start, end));
            }),
            // Attachments have no signals, whatever their length.
            op::ATTACHMENT => (!self.is_ours(bytes)).then_some(()),
            op::MESSAGE_INDEX => {
                let mut head = [0; 6];
                let read = bytes.fill(start, &mut head);
                read.filter(|()| record::is_message_index(&head, length))
            }
            op::FOOTER => {
                return if length == 20 {
                    Step::Footer(end)
                } else {
                    Step::Nothing
                };
            }
            op::DATA_END => (length == 4).then(|| self.data_ended = true),
            op::HEADER => (at == MAGIC.len() as u64 && length < LIMIT).then_some(()),
            // The index has a check sum of its own.
            op::CHUNK_INDEX..=op::SUMMARY_OFFSET => {
                let is_behind = self.data_ended || self.index.is_some_and(|start| at >= start);
                (is_behind && length < LIMIT).then_some(())
            }
            _ => None,
        };
        whole.map_or(Step::Nothing, |()| Step::Next(end))
    }

    /// Whether this is a message outside of chunks, of a channel that was defined there too.
    fn is_loose(&self, bytes: &Bytes, start: u64, end: u64) -> bool {
        let mut id = [0; 2];
        bytes.fill(start, &mut id).is_some()
            && end - start <= LIMIT
            && self.channels.contains_key(&u16::from_le_bytes(id))
            && !self.is_ours(bytes)
    }

    /// Whether heft wrote the file.
    fn is_ours(&self, bytes: &Bytes) -> bool {
        // The profile, the first text of the header.
        bytes
            .range(MAGIC.len() as u64 + HEAD, MAGIC.len() as u64 + HEAD + 8)
            .is_some_and(|head| head == *b"\x04\0\0\0heft")
    }

    fn add_metadata(&mut self, name: &str, mut pairs: Metadata) {
        if name == CLOCK {
            self.jumps.extend(pairs.remove(JUMP));
        }
        if name == RECORD {
            self.metadata.extend(pairs);
        }
    }

    /// Checks the metadata, which have no check sum in MCAP; heft's own have one.
    fn check_metadata(&mut self, bytes: &Bytes) {
        let header = MAGIC.len() as u64;
        let length = head(bytes, header).map_or(0, |h| h.1.min(4096));
        let header = bytes.range(header, header + HEAD + length);
        let has_sum = header.is_some_and(|h| {
            let mut windows = h.windows(WITH_SUM.len());
            windows.any(|w| w == WITH_SUM.as_bytes())
        });
        let sum = self.metadata.remove(METADATA_SUM);
        let is_cut_before = self.metadata.is_empty() && self.chunks.is_empty();
        let lacks = sum.is_none() && has_sum && !is_cut_before;
        if sum.is_some() && sum != Some(sum_of(&self.metadata)) || lacks {
            self.damage.push(Damage {
                at: MAGIC.len() as u64,
                bytes: 0,
                what: "a changed word in the metadata",
            });
        }
    }

    /// Finds a chunk whose record has another opcode.
    fn hidden_chunk(&mut self, bytes: &Bytes, at: u64) -> Option<u64> {
        let end = self.prove_chunk(bytes, at)?;
        self.damage.push(Damage {
            at,
            bytes: 1,
            what: "a record of a wrong kind",
        });
        Some(end)
    }

    /// The end of a small record with damaged content but an undamaged length: another record
    /// begins there.
    fn step_over(&mut self, bytes: &Bytes, at: u64) -> Option<u64> {
        const SMALL: u64 = 1 << 20;
        let (opcode, length) = head(bytes, at)?;
        let end = at + HEAD + Some(length).filter(|l| *l < SMALL)?;
        let (next, its) = head(bytes, end)?;
        let is_record = |opcode| (op::HEADER..=op::DATA_END).contains(&opcode);
        let after = end.checked_add(its).and_then(|e| e.checked_add(HEAD));
        let follows = after.is_some_and(|after| after <= bytes.len);
        let whole = is_record(opcode) && is_record(next) && follows && opcode != op::CHUNK;
        whole.then(|| {
            self.damage.push(Damage {
                at,
                bytes: end - at,
                what: "a damaged record",
            });
            end
        })
    }

    /// Searches from `at` on for the next chunk or metadata with a correct check sum, reads it, and returns its
    /// end; `None` if there is none.
    fn search(&mut self, bytes: &Bytes, at: u64) -> Option<u64> {
        const WINDOW: u64 = 1 << 20;
        let mut from = at;
        while from < bytes.len {
            let end = (from + WINDOW).min(bytes.len);
            let window = bytes.range(from, end)?;
            for (i, byte) in window.iter().enumerate() {
                let here = from + i as u64;
                let found = match *byte {
                    op::CHUNK => self.prove_chunk(bytes, here),
                    op::METADATA => self.prove_metadata(bytes, here),
                    _ => None,
                };
                if let Some(end) = found {
                    self.damage.push(Damage {
                        at,
                        bytes: (here - at).max(HEAD),
                        what: "a damaged stretch",
                    });
                    return Some(end);
                }
            }
            from = end;
        }
        None
    }

    /// A chunk with a correct check sum; the length of its record or that of its content may be wrong.
    fn prove_chunk(&mut self, bytes: &Bytes, at: u64) -> Option<u64> {
        let mut chunk = chunk_at(bytes, at)?;
        if chunk.head.crc == 0 {
            return None;
        }
        let outer = head(bytes, at)?.1.checked_add(at + HEAD)?;
        let mut unpacked = Unpacked::default();
        // The shorter one first: too short fails, too long would include the records that follow.
        for end in [chunk.end.min(outer), chunk.end.max(outer)] {
            chunk.end = end;
            if end > chunk.start && end <= bytes.len && unpacked.load(&chunk, bytes).is_some() {
                self.chunks.push(chunk);
                return Some(end);
            }
        }
        None
    }

    /// heft's own metadata with a correct check sum.
    fn prove_metadata(&mut self, bytes: &Bytes, at: u64) -> Option<u64> {
        let mut name = [0; 8];
        bytes.fill(at + HEAD, &mut name)?;
        (name == [4, 0, 0, 0, b'h', b'e', b'f', b't']).then_some(())?;
        let end = head(bytes, at)?.1.checked_add(at + HEAD)?;
        let (name, pairs) = record::metadata(&bytes.range(at + HEAD, end)?)?;
        self.add_metadata(&name, pairs);
        Some(end)
    }

    /// Whether the index has the check sum in the footer; `end` is the end of the footer.
    fn index_is_whole(&self, bytes: &Bytes, end: u64) -> bool {
        let footer = bytes.range(end - 20, end);
        let Some((start, crc)) = footer.and_then(|body| record::footer(&body)) else {
            return false;
        };
        let sum = |index: Vec<u8>| crc32fast::hash(&index);
        start == 0 || crc == 0 || bytes.range(start, end - 4).map(sum) == Some(crc)
    }

    /// Reads the channels from the chunks, if the index at the end is missing.
    fn look_into_chunks(&mut self, bytes: &Bytes) {
        let mut unpacked = Unpacked::default();
        for chunk in core::mem::take(&mut self.chunks) {
            let define = &mut |opcode: u8, body: &[u8]| match opcode {
                op::SCHEMA => {
                    self.schemas.extend(record::schema(body).map(|s| (s.id, s)));
                }
                op::CHANNEL => {
                    self.channels
                        .extend(record::channel(body).map(|c| (c.id, c)));
                }
                _ => {}
            };
            match unpacked.load(&chunk, bytes) {
                Some(()) => {
                    unpacked.for_each(define);
                    self.chunks.push(chunk);
                }
                None => self.damage.push(chunk.damage()),
            }
        }
    }
}

impl Chunk {
    pub(crate) fn damage(&self) -> Damage {
        Damage {
            at: self.at,
            bytes: self.end - self.at,
            what: "a damaged block",
        }
    }
}

/// Begin of the index by the footer at the end of the file.
fn index_start(bytes: &Bytes) -> Option<u64> {
    let end = bytes.len.checked_sub(MAGIC.len() as u64)?;
    let footer = bytes.range(end.checked_sub(20)?, end)?;
    record::footer(&footer)
        .map(|(start, _)| start)
        .filter(|start| *start > 0)
}

/// Opcode and length of the record at `at`.
fn head(bytes: &Bytes, at: u64) -> Option<(u8, u64)> {
    let mut head = [0; HEAD as usize];
    bytes.fill(at, &mut head)?;
    let [opcode, length @ ..] = head;
    Some((opcode, u64::from_le_bytes(length)))
}

/// Whether an undamaged chunk begins at byte `at` of a file.
pub fn has_chunk_at(file: &Path, at: u64) -> bool {
    let Ok(bytes) = Bytes::open(file) else {
        return false;
    };
    let is_whole = |(opcode, length): (u8, u64)| {
        let end = length.checked_add(at + HEAD);
        opcode == op::CHUNK && end.is_some_and(|end| end <= bytes.len)
    };
    head(&bytes, at).is_some_and(is_whole)
}

/// The chunk at `at`, by its own head.
fn chunk_at(bytes: &Bytes, at: u64) -> Option<Chunk> {
    let mut head = [0; CHUNK_HEAD];
    let start = at + HEAD;
    let room = bytes.len.checked_sub(start)?.min(CHUNK_HEAD as u64) as usize;
    bytes.fill(start, &mut head[..room])?;
    let head = record::chunk_head(&head[..room])?;
    let start = start + head.length;
    let end = start.checked_add(head.packed)?;
    (head.packed <= LIMIT && head.unpacked <= LIMIT).then_some(Chunk {
        head,
        at,
        start,
        end,
    })
}

/// The records of one chunk at a time, and the position in them.
#[derive(Debug, Default)]
pub(crate) struct Unpacked {
    bytes: Vec<u8>,
    at: usize,
}

impl Unpacked {
    /// Decompresses a chunk; `None` if that fails or its check sum is wrong.
    pub(crate) fn load(&mut self, chunk: &Chunk, file: &Bytes) -> Option<()> {
        self.bytes.clear();
        self.at = 0;
        let packed = file.range(chunk.start, chunk.end)?;
        // The limit is checked first: a damaged file may state any size.
        match chunk.head.packing {
            Packing::None => self.bytes = packed,
            Packing::Lz4 => {
                let decoder = lz4::Decoder::new(packed.as_slice()).ok()?;
                let mut limited = decoder.take(LIMIT);
                limited.read_to_end(&mut self.bytes).ok()?;
            }
            Packing::Zstd => {
                let decoder = ruzstd::decoding::StreamingDecoder::new(packed.as_slice()).ok()?;
                let mut limited = decoder.take(LIMIT);
                limited.read_to_end(&mut self.bytes).ok()?;
            }
        }
        let crc = chunk.head.crc;
        let whole = match crc {
            0 => self.bytes.len() as u64 == chunk.head.unpacked,
            crc => crc32fast::hash(&self.bytes) == crc,
        };
        if !whole {
            self.bytes.clear();
        }
        whole.then_some(())
    }

    /// Opcode and body of the next record; `None` at the end, or if the rest is incomplete.
    pub(crate) fn next(&mut self) -> Option<(u8, &[u8])> {
        let (opcode, body, end) = record::at(&self.bytes, self.at)?;
        self.at = end;
        Some((opcode, body))
    }

    /// Whether all of it has been read.
    pub(crate) fn is_at_end(&self) -> bool {
        self.at == self.bytes.len()
    }

    fn for_each(&mut self, found: &mut impl FnMut(u8, &[u8])) {
        while let Some((opcode, body)) = self.next() {
            found(opcode, body);
        }
    }
}
