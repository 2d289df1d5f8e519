use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use messages::{Kind, Message, Value};

use crate::scan::{Chunk, Scan};
use crate::schema::{self, RecordedField};
use crate::wire::{self, Scalar};
use crate::{Error, Metadata};

/// Reads an MCAP recording, also one that is cut off or still being written: then up to its last
/// whole chunk.
pub struct Reader {
    path: PathBuf,
    bytes: Vec<u8>,
    scan: Scan,
}

impl Reader {
    /// Opens a recording.
    ///
    /// # Errors
    /// The file cannot be read, or is no MCAP file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let bytes =
            std::fs::read(&path).map_err(|e| Error::system("read the recording", &path, &e))?;
        let scan = Scan::new(&bytes).ok_or_else(|| {
            Error::new(
                "this is no MCAP recording",
                path.display().to_string(),
                "give a .mcap file that heft has written, or a .csv with that ending",
            )
        })?;
        Ok(Self { path, bytes, scan })
    }

    /// What the recording says of its run.
    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        &self.scan.metadata
    }

    /// Whether the recording was finished, or else cut off (or is still being written).
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.scan.complete
    }

    /// Names of the recorded channels, in alphabetical order.
    #[must_use]
    pub fn channels(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self
            .scan
            .channels
            .values()
            .map(|c| c.topic.as_str())
            .collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// All messages of a channel in the order of the file; none if the channel was not recorded.
    /// Fields are found by name: what an earlier version did not record is 0, what a later one
    /// added is left out.
    ///
    /// # Errors
    /// The channel carries another type, or the file is damaged.
    pub fn messages<M: Message>(&self, channel: &str) -> Result<Vec<M>, Error> {
        let mut messages = Vec::new();
        let expected = schema::name::<M>();
        self.each(channel, |name, fields, scalars| {
            if name != expected {
                return Err(self.wrong(format!("{channel} carries {name}, not {expected}")));
            }
            let mut message = M::default();
            for (field, scalar) in fields.iter().zip(scalars) {
                put(&mut message, field, *scalar);
            }
            messages.push(message);
            Ok(())
        })?;
        Ok(messages)
    }

    /// Fields of a channel as its own schema tells them; none if the channel was not recorded.
    #[must_use]
    pub fn fields(&self, channel: &str) -> Vec<RecordedField> {
        let mut found = self.scan.channels.values().filter(|c| c.topic == channel);
        found
            .find_map(|c| self.schema(c.schema_id))
            .map_or_else(Vec::new, |(_, fields)| fields)
    }

    /// Calls `found` with log time [ns] and all values of each message of a channel, in the order
    /// of [`Reader::fields`].
    ///
    /// # Errors
    /// The file is damaged.
    pub fn for_each_value(
        &self,
        channel: &str,
        mut found: impl FnMut(u64, &[Value]),
    ) -> Result<(), Error> {
        let mut values = Vec::new();
        self.each_timed(channel, |header, _, fields, scalars| {
            values.clear();
            values.extend(fields.iter().zip(scalars).map(|(f, s)| s.value(f.kind)));
            found(header.log_time, &values);
            Ok(())
        })
    }

    fn each(
        &self,
        channel: &str,
        mut found: impl FnMut(&str, &[RecordedField], &[Scalar]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.each_timed(channel, |_, name, fields, scalars| {
            found(name, fields, scalars)
        })
    }

    fn each_timed(
        &self,
        channel: &str,
        mut found: impl FnMut(&MessageHeader, &str, &[RecordedField], &[Scalar]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let decoders = self.decoders(channel)?;
        if decoders.is_empty() {
            return Ok(());
        }
        let mut scalars = Vec::new();
        for chunk in &self.scan.chunks {
            let mut outcome = Ok(());
            let whole = chunk.messages(&self.bytes, |header, data| {
                let decoder = decoders.iter().find(|d| d.id == header.channel_id);
                if let (Some(decoder), Ok(())) = (decoder, &outcome) {
                    outcome = match decoder.decode(data, &mut scalars) {
                        Some(()) => found(header, &decoder.name, &decoder.fields, &scalars),
                        None => Err(self.wrong(format!("a message of {channel} is damaged"))),
                    };
                }
            });
            whole.ok_or_else(|| self.damaged(chunk))?;
            outcome?;
        }
        Ok(())
    }

    fn decoders(&self, channel: &str) -> Result<Vec<Decoder>, Error> {
        let ids = self.scan.channels.values().filter(|c| c.topic == channel);
        ids.map(|c| {
            let (name, fields) = self.schema(c.schema_id).ok_or_else(|| {
                self.wrong(format!(
                    "channel {channel} has no protobuf schema that heft can read"
                ))
            })?;
            Ok(Decoder::new(c.id, name, fields))
        })
        .collect()
    }

    fn schema(&self, id: u16) -> Option<(String, Vec<RecordedField>)> {
        let schema = self.scan.schemas.get(&id)?;
        let fields = schema::fields(&schema.name, &schema.data)?;
        (schema.encoding == "protobuf").then(|| (schema.name.clone(), fields))
    }

    fn damaged(&self, chunk: &Chunk) -> Error {
        self.wrong(format!("the recording is damaged at byte {}", chunk.start))
    }

    fn wrong(&self, what: String) -> Error {
        Error::new(
            what,
            self.path.display().to_string(),
            "run `heft recover` on the file: it keeps what is whole",
        )
    }
}

/// Sets the field of the same name, if there is one that can hold the value.
fn put<M: Message>(message: &mut M, field: &RecordedField, scalar: Scalar) {
    if let Some(index) = M::index(&field.name) {
        let value = match (scalar.value(field.kind), M::FIELDS[index].kind) {
            (Value::U32(v), Kind::U64) => Value::U64(u64::from(v)),
            (Value::U64(v), Kind::U32) => Value::U32(v as u32),
            (value, _) => value,
        };
        message.set(index, value);
    }
}

/// One channel of the file: which number on the wire is which field.
struct Decoder {
    id: u16,
    name: String,
    fields: Vec<RecordedField>,
}

impl Decoder {
    fn new(id: u16, name: String, fields: Vec<RecordedField>) -> Self {
        Self { id, name, fields }
    }

    /// The scalars of a message in the order of the fields, 0 where one is left out.
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
