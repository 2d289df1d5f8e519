use std::fmt;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use crate::copy::copy;
use crate::file::{self, ClaimError};
use crate::output::{self, Unfinished};
use crate::parts::{JOINED, PART};
use crate::reader::{Part, Reader};
use crate::writer::{RECORD, failure, options, with_sum};
use crate::{Error, Metadata};

/// Result of [`recover`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovered {
    /// The new recording; none if the old one is whole and no copy was requested.
    pub written: Option<PathBuf>,
    /// Whether nothing was missing, in a single file.
    pub was_complete: bool,
    /// Files that the recording consists of.
    pub parts: usize,
    /// Number of complete messages.
    pub messages: u64,
    /// Bytes at the ends of its files that belonged to no complete record.
    pub lost_bytes: u64,
    /// Damage within, as texts.
    pub damage: Vec<String>,
}

impl fmt::Display for Recovered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let messages = self.messages;
        let Some(written) = &self.written else {
            return write!(f, "complete, {messages} messages; nothing was changed");
        };
        if self.was_complete {
            let copy = written.display();
            return write!(
                f,
                "complete, {messages} messages: nothing was damaged; a copy is in {copy}"
            );
        }
        write!(f, "recovered {} messages", self.messages)?;
        if self.parts > 1 {
            write!(f, " from {} parts", self.parts)?;
        }
        write!(f, " into {}", written.display())?;
        if self.lost_bytes > 0 {
            write!(f, "; {} bytes at the end were cut off", self.lost_bytes)?;
        }
        for damage in &self.damage {
            write!(f, "\n  lost: {damage}")?;
        }
        Ok(())
    }
}

/// Repairs a recording that was cut off, damaged, or left in parts: every complete message is copied into a new
/// file beside it, `RUN.recovered.mcap` without `output`. A recording that is whole is copied only to an
/// `output`. The recording itself is never changed.
///
/// # Errors
/// The recording cannot be read, or is still being written; it has no complete message; the new file exists or cannot be
/// written.
pub fn recover(path: impl AsRef<Path>, output: Option<&Path>) -> Result<Recovered, Error> {
    let path = path.as_ref();
    let reader = Reader::open(path)?;
    if reader.is_being_written() {
        return Err(Error::new(
            "this recording is being written: there is nothing to mend yet",
            path.display().to_string(),
            "read it as it is (heft report, replay, export), or end the run first",
        ));
    }
    let messages = copy(&reader, |_, _, _| Ok(()))?;
    let mut recovered = Recovered {
        written: None,
        was_complete: false,
        parts: reader.parts.len(),
        messages,
        lost_bytes: reader.lost_bytes(),
        damage: reader.damage(),
    };
    let is_whole = reader.is_complete() && recovered.damage.is_empty();
    recovered.was_complete = is_whole && recovered.parts == 1;
    if messages == 0 && !is_whole {
        let remedy = if reader.metadata().is_empty() {
            "look whether it is packed or encoded in a way that heft does not know"
        } else {
            "look for another copy of the recording"
        };
        return Err(Error::new(
            "no message of this file can be read: a copy would be empty",
            path.display().to_string(),
            remedy,
        ));
    }
    let file = match output {
        Some(file) => Some(file.to_owned()),
        None if recovered.was_complete => None,
        None => Some(free_name(&reader)),
    };
    if let Some(file) = file {
        match recovered.was_complete {
            true => copy_whole(&reader, &file)?,
            false => write(&reader, &file, &note(&recovered)).map(drop)?,
        }
        recovered.written = Some(file);
    }
    Ok(recovered)
}

/// `RUN.recovered.mcap`, with a number where that exists.
fn free_name(reader: &Reader) -> PathBuf {
    let first = reader
        .parts
        .first()
        .map_or(Path::new("run"), |p| p.path.as_path());
    let name = |n: u32| {
        first.with_extension(match n {
            1 => "recovered.mcap".to_owned(),
            n => format!("{n}.recovered.mcap"),
        })
    };
    (1..)
        .map(name)
        .find(|file| !file.exists())
        .unwrap_or_else(|| name(1))
}

fn note(recovered: &Recovered) -> Metadata {
    let Recovered {
        lost_bytes, damage, ..
    } = recovered;
    let text = format!(
        "{lost_bytes} bytes at the end and {} damaged stretches lost",
        damage.len()
    );
    [("recovered".to_owned(), text)].into()
}

/// Joins all parts of a recording into one new file at `output`.
///
/// # Errors
/// A part cannot be read, or the file exists or cannot be written; it is then removed.
pub fn join(reader: &Reader, output: &Path) -> Result<(), Error> {
    let names = reader.files().filter_map(|p| p.file_name()?.to_str());
    // The first part's name becomes that of the whole.
    let names = names.filter(|name| name.contains(".part"));
    let names = names.collect::<Vec<_>>().join(",");
    write(reader, output, &[(JOINED.to_owned(), names)].into()).map(drop)
}

/// Copies a recording that is one whole file, including contents unknown to heft.
fn copy_whole(reader: &Reader, path: &Path) -> Result<(), Error> {
    let (mut file, unfinished) = claim(path)?;
    let copied = reader.files().next().map_or(Ok(()), |from| {
        std::io::copy(&mut File::open(from)?, &mut file)?;
        file.sync_all()
    });
    copied.map_err(|e| Error::system("write beside the recording", path, &e))?;
    unfinished.keep();
    Ok(())
}

/// Takes the name of a file that does not exist yet. A device is not taken: an unfinished copy is removed.
fn claim(path: &Path) -> Result<(File, Unfinished), Error> {
    let is_device = output::is_device(path);
    let claimed = Unfinished::create(path.to_owned(), |path| match is_device {
        true => Err(ClaimError::Exists),
        false => file::take(path),
    });
    let (unfinished, file) = claimed.map_err(|e| match e {
        ClaimError::System(e) => Error::system("write beside the recording", path, &e),
        ClaimError::Exists => Error::new(
            "this file exists already; it is not overwritten",
            path.display().to_string(),
            "choose another name with -o",
        ),
    })?;
    Ok((file, unfinished))
}

/// Writes every complete message into a new file, with the metadata of the run and a note.
fn write(reader: &Reader, path: &Path, note: &Metadata) -> Result<u64, Error> {
    let (file, unfinished) = claim(path)?;
    let messages = fill(reader, path, file, note)?;
    unfinished.keep();
    Ok(messages)
}

fn fill(reader: &Reader, path: &Path, file: File, note: &Metadata) -> Result<u64, Error> {
    let fail = |e| failure(path, e);
    let mut writer = options().create(BufWriter::new(file)).map_err(fail)?;
    let mut metadata = reader.metadata().clone();
    metadata.remove(PART);
    metadata.extend(note.clone());
    writer
        .write_metadata(&mcap::records::Metadata {
            name: RECORD.into(),
            metadata: with_sum(&metadata),
        })
        .map_err(fail)?;
    // Each part has its own channel numbers.
    let mut ids: Vec<Vec<(u16, u16)>> = Vec::new();
    for part in &reader.parts {
        ids.push(add_channels(&mut writer, part).map_err(fail)?);
    }
    let messages = copy(reader, |part, head, data| {
        let id = ids[part].iter().find(|(old, _)| *old == head.channel);
        let Some((_, id)) = id else {
            return Ok(());
        };
        let header = mcap::records::MessageHeader {
            channel_id: *id,
            sequence: head.sequence,
            log_time: head.log_time,
            publish_time: head.publish_time,
        };
        writer.write_to_known_channel(&header, data).map_err(fail)
    })?;
    writer.finish().map_err(fail)?;
    let file = writer.into_inner().into_inner();
    file.map_err(|e| e.into_error())
        .and_then(|file| file.sync_all())
        .map_err(|e| Error::system("write beside the recording", path, &e))?;
    Ok(messages)
}

/// Adds the channels of a part; returns their numbers there and in the new file.
fn add_channels(
    writer: &mut mcap::Writer<BufWriter<File>>,
    part: &Part,
) -> mcap::McapResult<Vec<(u16, u16)>> {
    let mut ids = Vec::new();
    for channel in part.scan.channels.values() {
        let schema = match part.scan.schemas.get(&channel.schema_id) {
            Some(s) => writer.add_schema(&s.name, &s.encoding, &s.data)?,
            None if channel.schema_id == 0 => 0,
            None => continue,
        };
        let id =
            writer.add_channel(schema, &channel.topic, &channel.encoding, &channel.metadata)?;
        ids.push((channel.id, id));
    }
    Ok(ids)
}
