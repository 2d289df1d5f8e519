use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt;
use std::io::Read as _;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use mcap::records::op;
use messages::{Machine, Message, NumberType, Value};

use crate::file::Bytes;
use crate::packed::GZIP;
use crate::parts::{self, JOINED, PART};
use crate::record;
use crate::scan::{Damage, Scan, Unpacked};
use crate::schema::{self, RecordedField};
use crate::wire::{self, Scalar};
use crate::writer::JUMPS;
use crate::{Error, Metadata};

/// Metadata that all parts of a run have in common, if they have them.
const OF_A_RUN: [&str; 3] = ["run", "machine", "description.sha256"];

fn left_out(file: &Path, why: &str) -> String {
    format!("{}: it {why}, and is left out", file.display())
}

/// The error of a file that is no recording, as its first bytes say.
fn no_recording(path: &Path) -> Error {
    let mut head = Vec::new();
    let opened = crate::file::open(path);
    let read = opened.and_then(|file| file.take(GZIP.len() as u64).read_to_end(&mut head));
    let (what, remedy) = match head.as_slice() {
        [] if read.is_ok() => (
            "the file is empty",
            "take another copy of it; a run that was killed at once has recorded nothing",
        ),
        head if head == GZIP => ("this is a packed file", "unpack it: gunzip FILE"),
        _ => (
            "this is no MCAP recording",
            "name a recording of heft (.mcap); tables and CAN logs go through `heft estimate`",
        ),
    };
    Error::new(what, path.display().to_string(), remedy)
}

/// Reads an MCAP recording with all of its parts, also one that is cut off or still being written:
/// then up to its last complete chunk. Nothing is written, and only one chunk is in memory at a
/// time. Damaged data are left out, and reported by [`Reader::damage`].
pub struct Reader {
    pub(crate) parts: Vec<Part>,
    metadata: Metadata,
    /// Messages on files with the name of a part that are none, and on missing parts.
    apart: Vec<String>,
    found: RefCell<BTreeSet<(usize, Damage)>>,
    progress: Option<Box<dyn Fn(f64)>>,
}

/// Missing and damaged contents of a recording, as texts with their place.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Lacks {
    /// Damaged stretches, blocks and messages, see [`Reader::damage`].
    pub damage: Vec<String>,
    /// The end is missing, and nobody knows how much: the writer was stopped, or the copy ended early.
    pub cut_off: Option<String>,
    /// Lines of a log that are no frames, and frames that were lost during recording.
    pub left_out: Option<String>,
    /// Columns of a table without a value in any row.
    pub empty: Vec<String>,
}

impl Lacks {
    /// All damage and the cut end, which comes last; empty if the recording is whole.
    pub fn all(&self) -> Vec<&str> {
        let damage = self.damage.iter().map(String::as_str);
        damage
            .chain(self.left_out.as_deref())
            .chain(self.cut_off.as_deref())
            .collect()
    }

    /// The entries that leave no doubt about the rest.
    pub fn remarks(&self) -> impl Iterator<Item = &str> {
        let empty = self.empty.iter().map(String::as_str);
        empty.chain(self.left_out.as_deref())
    }
}

/// One file of a recording.
pub(crate) struct Part {
    pub path: PathBuf,
    pub bytes: Bytes,
    pub scan: Scan,
}

impl Part {
    /// `None` if it is no MCAP file.
    pub(crate) fn open(path: &Path) -> Result<Option<Self>, Error> {
        let bytes = Bytes::open(path).map_err(|e| Error::system("read the recording", path, &e))?;
        let scan = Scan::new(&bytes);
        let path = path.to_owned();
        Ok(scan.map(|scan| Self { path, bytes, scan }))
    }

    /// Whether a message conforms to its schema, as far as heft knows the schema.
    pub(crate) fn is_whole(&self, head: &record::Message, data: &[u8]) -> bool {
        let Some(channel) = self.scan.channels.get(&head.channel) else {
            return false;
        };
        channel.encoding != "protobuf" || wire::decode(data, |_, _| ()).is_some()
    }

    /// Order among the parts of the same run: by the number in the part's metadata, and by
    /// its first time without such a number.
    fn order(&self) -> (u32, u64) {
        let number = self.scan.metadata.get(PART).and_then(|n| n.parse().ok());
        let first = self
            .scan
            .chunks
            .first()
            .map_or(u64::MAX, |c| c.head.start_time);
        (
            number.unwrap_or(0),
            if number.is_some() { 0 } else { first },
        )
    }
}

impl Reader {
    /// Opens a recording: its first file, or its folder. Other parts of it are found beside it.
    ///
    /// # Errors
    /// The file cannot be read, or is no MCAP file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let files = parts::files(path)?;
        let mut parts = Vec::new();
        let mut apart = Vec::new();
        for file in &files {
            match Part::open(file)? {
                Some(part) => parts.push(part),
                // Reserved, and never written.
                None if std::fs::metadata(file).is_ok_and(|m| m.len() == 0) => {}
                None => apart.push(left_out(file, "is no MCAP file")),
            }
        }
        if parts.is_empty() {
            return Err(no_recording(path));
        }
        let joined: Vec<String> = parts
            .iter()
            .filter_map(|p| p.scan.metadata.get(JOINED))
            .flat_map(|names| names.split(',').map(str::to_owned))
            .collect();
        parts.retain(|p| {
            !p.path
                .file_name()
                .is_some_and(|n| joined.iter().any(|j| **j == *n))
        });
        if joined.is_empty() {
            apart.extend(parts::missing(&files));
        }
        let named = parts.first().map(|p| p.scan.metadata.clone());
        let named = named.unwrap_or_default();
        let mut numbers = BTreeSet::new();
        parts.retain(|p| {
            let its = &p.scan.metadata;
            let is_other = OF_A_RUN.iter().any(
                |key| matches!((named.get(*key), its.get(*key)), (Some(a), Some(b)) if a != b),
            );
            let is_known = its.get(PART).is_some_and(|n| !numbers.insert(n.clone()));
            let why = match (is_other, is_known) {
                (true, _) => "is of another run",
                (_, true) => "holds a part once more",
                _ => return true,
            };
            apart.push(left_out(&p.path, why));
            false
        });
        parts.sort_by_key(Part::order);
        let metadata = parts.first().map(|p| p.scan.metadata.clone());
        let mut metadata = metadata.unwrap_or_default();
        let jumps: Vec<&str> = parts
            .iter()
            .flat_map(|p| &p.scan.jumps)
            .map(String::as_str)
            .collect();
        if !jumps.is_empty() {
            metadata.insert(JUMPS.into(), jumps.join("; "));
        }
        let found = |(i, p): (usize, &Part)| -> Vec<(usize, Damage)> {
            p.scan.damage.iter().map(|d| (i, d.clone())).collect()
        };
        Ok(Self {
            found: RefCell::new(parts.iter().enumerate().flat_map(found).collect()),
            metadata,
            apart,
            parts,
            progress: None,
        })
    }

    /// Calls `report` with the share that is read (0 to 1) while a channel is read.
    pub fn on_progress(&mut self, report: impl Fn(f64) + 'static) {
        self.progress = Some(Box::new(report));
    }

    /// Metadata of the run.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The machine whose run heft recorded; none for a foreign recording.
    pub fn machine(&self) -> Option<Machine> {
        let stated = self.metadata.get("machine");
        // If the metadata are damaged, a channel that belongs to one machine only identifies it.
        let recorded = |machine: &Machine| {
            let is_its = |name: &&str| name.split('/').next() == Some(machine.name());
            self.channels().iter().any(is_its)
        };
        stated
            .and_then(|name| Machine::from_name(name))
            .or_else(|| Machine::ALL.into_iter().find(recorded))
    }

    /// Its files, in the order of time.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.parts.iter().map(|p| p.path.as_path())
    }

    /// Its size \[bytes\].
    pub fn size(&self) -> u64 {
        self.parts.iter().map(|p| p.bytes.len).sum()
    }

    /// Whether every part was finished; not if one was cut off or is still being written.
    pub fn is_complete(&self) -> bool {
        self.parts.iter().all(|p| p.scan.complete)
    }

    /// Whether a writer has it open.
    pub fn is_being_written(&self) -> bool {
        self.parts.iter().any(|p| p.bytes.is_being_written())
    }

    /// Bytes at the ends of cut parts that belong to no complete record.
    pub fn lost_bytes(&self) -> u64 {
        self.parts.iter().map(|p| p.scan.lost_bytes).sum()
    }

    /// Damage found up to now, as texts with their place: missing parts, files that are no parts, and damage between the
    /// chunks, when the recording was opened; damage within chunks when they were read.
    pub fn damage(&self) -> Vec<String> {
        let found = self.found.borrow();
        let line = |(i, d): &(usize, Damage)| format!("{}: {d}", self.parts[*i].path.display());
        let apart = self.apart.iter().cloned();
        apart.chain(found.iter().map(line)).collect()
    }

    /// Missing and damaged contents: the damage found up to now, and the cut end.
    pub fn lacks(&self) -> Lacks {
        let is_cut = !self.is_complete() && !self.is_being_written();
        Lacks {
            damage: self.damage(),
            cut_off: is_cut.then(|| {
                let file = self.files().next().unwrap_or(Path::new("")).display();
                let lost = match self.lost_bytes() {
                    0 => " between two messages".to_owned(),
                    bytes => format!("; {bytes} bytes at the end belong to nothing whole"),
                };
                format!("{file}: it was cut off{lost} (`heft recover` writes a whole copy)")
            }),
            ..Lacks::default()
        }
    }

    /// Names of the recorded channels, in alphabetical order.
    pub fn channels(&self) -> Vec<&str> {
        let channels = self.parts.iter().flat_map(|p| p.scan.channels.values());
        let mut names: Vec<&str> = channels.map(|c| c.topic.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// All messages of a channel, in the order of the file; none if the channel
    /// was not recorded. Fields are found by name: a field that an earlier version did not record is 0, one that
    /// a later version added is left out.
    ///
    /// # Errors
    /// The channel carries another type.
    pub fn stream<M: Message>(&self, channel: &str) -> Result<Stream<'_, M>, Error> {
        let rows = self.rows(channel)?;
        let expected = schema::name::<M>();
        for decoder in rows.decoders.iter().flatten() {
            let name = &decoder.name;
            if *name != expected {
                return Err(self.wrong(format!("{channel} carries {name}, not {expected}")));
            }
        }
        let targets = rows.decoders.iter().map(|part| {
            let of = |d: &Decoder| d.fields.iter().map(|f| M::index(&f.name)).collect();
            part.iter().map(of).collect()
        });
        Ok(Stream {
            targets: targets.collect(),
            rows,
            message: PhantomData,
        })
    }

    /// All messages of a channel in memory, see [`Reader::stream`].
    ///
    /// # Errors
    /// The channel carries another type.
    pub fn messages<M: Message>(&self, channel: &str) -> Result<Vec<M>, Error> {
        Ok(self.stream(channel)?.collect())
    }

    /// Fields of a channel by its recorded schema; none if the channel was not recorded.
    pub fn fields(&self, channel: &str) -> Vec<RecordedField> {
        let found = self.parts.iter().find_map(|part| {
            let mut found = part.scan.channels.values().filter(|c| c.topic == channel);
            found.find_map(|c| schema_of(part, c.schema_id))
        });
        found.map_or_else(Vec::new, |(_, fields)| fields)
    }

    /// Calls `found` with log time \[ns\] and all values of each message of a channel, in the order
    /// of [`Reader::fields`].
    ///
    /// # Errors
    /// The channel cannot be read.
    pub fn for_each_value(
        &self,
        channel: &str,
        mut found: impl FnMut(u64, &[Value]),
    ) -> Result<(), Error> {
        let columns = self.fields(channel);
        let mut rows = self.rows(channel)?;
        let mut values = Vec::new();
        while let Some(row) = rows.next() {
            let fields = &rows.decoders[row.part][row.decoder].fields;
            let scalars = &rows.scalars;
            values.clear();
            if fields.len() == columns.len() {
                values.extend(fields.iter().zip(scalars).map(|(f, s)| s.value(f.kind)));
            } else {
                // A part of another version: fields are found by name.
                values.extend(columns.iter().map(|c| {
                    let at = fields.iter().position(|f| f.name == c.name);
                    at.map_or(Scalar::ZERO, |at| scalars[at]).value(c.kind)
                }));
            }
            found(row.log_time, &values);
        }
        Ok(())
    }

    fn rows(&self, channel: &str) -> Result<Rows<'_>, Error> {
        let decoders = self.parts.iter().map(|part| {
            let ids = part.scan.channels.values().filter(|c| c.topic == channel);
            let decoder = |c: &record::Channel| {
                let (name, fields) = schema_of(part, c.schema_id).ok_or_else(|| {
                    self.wrong(format!(
                        "channel {channel} has no protobuf schema that heft can read"
                    ))
                })?;
                Ok(Decoder {
                    id: c.id,
                    name,
                    fields,
                })
            };
            ids.map(decoder).collect::<Result<Vec<_>, Error>>()
        });
        Ok(Rows {
            reader: self,
            decoders: decoders.collect::<Result<_, _>>()?,
            part: 0,
            chunk: 0,
            unpacked: Unpacked::default(),
            scalars: Vec::new(),
        })
    }

    pub(crate) fn note(&self, part: usize, damage: Damage) {
        self.found.borrow_mut().insert((part, damage));
    }

    pub(crate) fn tell(&self, part: usize, at: u64) {
        if let Some(report) = &self.progress {
            let before: u64 = self.parts[..part].iter().map(|p| p.bytes.len).sum();
            report((before + at) as f64 / self.size().max(1) as f64);
        }
    }

    fn wrong(&self, what: String) -> Error {
        let place = self.parts.first().map(|p| p.path.display().to_string());
        let remedy = "give a recording that heft has written";
        Error::new(what, place.unwrap_or_default(), remedy)
    }
}

impl fmt::Debug for Reader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.files()).finish()
    }
}

fn schema_of(part: &Part, id: u16) -> Option<(String, Vec<RecordedField>)> {
    let schema = part.scan.schemas.get(&id)?;
    let fields = schema::fields(&schema.name, &schema.data)?;
    (schema.encoding == "protobuf").then(|| (schema.name.clone(), fields))
}

/// The messages of a channel, see [`Reader::stream`].
pub struct Stream<'a, M> {
    rows: Rows<'a>,
    /// Per part, per channel of that name: index in the message of each recorded field.
    targets: Vec<Vec<Vec<Option<usize>>>>,
    message: PhantomData<M>,
}

impl<M: Message> Iterator for Stream<'_, M> {
    type Item = M;

    fn next(&mut self) -> Option<M> {
        let row = self.rows.next()?;
        let fields = &self.rows.decoders[row.part][row.decoder].fields;
        let targets = &self.targets[row.part][row.decoder];
        let mut message = M::default();
        for ((field, target), scalar) in fields.iter().zip(targets).zip(&self.rows.scalars) {
            if let Some(index) = target {
                put(&mut message, *index, scalar.value(field.kind));
            }
        }
        Some(message)
    }
}

/// Sets a field, if it can hold the value.
fn put<M: Message>(message: &mut M, index: usize, value: Value) {
    let value = match (value, M::FIELDS[index].kind) {
        (Value::U32(v), NumberType::U64) => Value::U64(u64::from(v)),
        (Value::U64(v), NumberType::U32) => Value::U32(v as u32),
        (value, _) => value,
    };
    message.set(index, value);
}

/// Iterates over the messages of a channel.
struct Rows<'a> {
    reader: &'a Reader,
    /// Per part.
    decoders: Vec<Vec<Decoder>>,
    part: usize,
    /// Number of chunks of the part that were started.
    chunk: usize,
    unpacked: Unpacked,
    scalars: Vec<Scalar>,
}

/// A message that was found; its values are in [`Rows::scalars`].
struct Row {
    log_time: u64,
    part: usize,
    decoder: usize,
}

impl Rows<'_> {
    fn next(&mut self) -> Option<Row> {
        loop {
            let Some((opcode, body)) = self.unpacked.next() else {
                self.next_chunk()?;
                continue;
            };
            if opcode != op::MESSAGE {
                continue;
            }
            let Some((head, data)) = record::message(body) else {
                self.damaged_message();
                continue;
            };
            let decoders = &self.decoders[self.part];
            let Some(decoder) = decoders.iter().position(|d| d.id == head.channel) else {
                continue;
            };
            if decoders[decoder].decode(data, &mut self.scalars).is_some() {
                return Some(Row {
                    log_time: head.log_time,
                    part: self.part,
                    decoder,
                });
            }
            self.damaged_message();
        }
    }

    /// Unpacks the next undamaged chunk; `None` at the end.
    fn next_chunk(&mut self) -> Option<()> {
        if !self.unpacked.is_at_end() {
            self.damaged_message();
        }
        loop {
            let part = self.reader.parts.get(self.part)?;
            let chunk = part.scan.chunks.get(self.chunk);
            let Some(chunk) = chunk.filter(|_| !self.decoders[self.part].is_empty()) else {
                if self.part + 1 == self.reader.parts.len() {
                    self.reader.tell(self.part, part.bytes.len);
                    self.unpacked = Unpacked::default();
                    return None;
                }
                (self.part, self.chunk) = (self.part + 1, 0);
                continue;
            };
            self.chunk += 1;
            self.reader.tell(self.part, chunk.at);
            match self.unpacked.load(chunk, &part.bytes) {
                Some(()) => return Some(()),
                None => self.reader.note(self.part, chunk.damage()),
            }
        }
    }

    fn damaged_message(&self) {
        let chunk = &self.reader.parts[self.part].scan.chunks[self.chunk.saturating_sub(1)];
        let what = "a damaged message in the block";
        let damage = Damage {
            what,
            ..chunk.damage()
        };
        self.reader.note(self.part, damage);
    }
}

/// One channel of a file: the field of each number on the wire.
pub(crate) struct Decoder {
    pub id: u16,
    name: String,
    fields: Vec<RecordedField>,
}

impl Decoder {
    /// The scalars of a message in the order of the fields, 0 for an absent one.
    fn decode(&self, data: &[u8], scalars: &mut Vec<Scalar>) -> Option<()> {
        scalars.clear();
        scalars.resize(self.fields.len(), Scalar::ZERO);
        let mut next = 0;
        wire::decode(data, |number, scalar| {
            // Fields come in the order of their numbers, so the search is short.
            let from = self.fields.get(next..).unwrap_or_default();
            let at = from
                .iter()
                .position(|f| f.number == number)
                .map(|i| i + next);
            let at = at.or_else(|| self.fields.iter().position(|f| f.number == number));
            if let Some(at) = at {
                scalars[at] = scalar;
                next = at + 1;
            }
        })
    }
}
