use std::fmt;
use std::fs::File;
use std::io::{BufWriter, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use mcap::MAGIC;
use mcap::records::op;

use crate::scan::{Scan, Schema};
use crate::writer::{RECORD, failure, options};
use crate::{Error, Metadata};

/// What [`recover`] did.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovered {
    /// The recording was whole; nothing was changed.
    pub was_complete: bool,
    /// Messages that the file holds now.
    pub messages: u64,
    /// Bytes at the end that belonged to nothing whole.
    pub lost_bytes: usize,
    /// Chunks within the file that could not be unpacked.
    pub damaged_chunks: usize,
}

impl fmt::Display for Recovered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            messages,
            lost_bytes,
            damaged_chunks,
            ..
        } = self;
        if self.was_complete {
            return write!(f, "complete, {messages} messages; nothing was changed");
        }
        write!(
            f,
            "recovered {messages} messages; {lost_bytes} bytes at the end were cut off"
        )?;
        if *damaged_chunks > 0 {
            write!(
                f,
                ", {damaged_chunks} blocks within were damaged and are lost"
            )?;
        }
        Ok(())
    }
}

/// Whether the recording was finished. It is read only at both ends.
///
/// # Errors
/// The file cannot be read.
pub fn is_complete(path: impl AsRef<Path>) -> Result<bool, Error> {
    let path = path.as_ref();
    let ends = || -> std::io::Result<bool> {
        let mut file = File::open(path)?;
        let mut head = [0; 8];
        let mut tail = [0; FOOTER + 8];
        if file.metadata()?.len() < (head.len() + tail.len()) as u64 {
            return Ok(false);
        }
        file.read_exact(&mut head)?;
        file.seek(SeekFrom::End(-(tail.len() as i64)))?;
        file.read_exact(&mut tail)?;
        Ok(head == *MAGIC && tail[0] == op::FOOTER && tail[FOOTER..] == *MAGIC)
    };
    ends().map_err(|e| Error::system("read the recording", path, &e))
}

/// Length of a footer record.
const FOOTER: usize = 1 + 8 + 20;

/// Mends a recording that was cut off or damaged: keeps every whole chunk, and writes the index
/// and the end anew. The new file is written beside the old one and takes its place at the end.
///
/// # Errors
/// The file cannot be read or written, or is no MCAP file. It is then unchanged.
pub fn recover(path: impl AsRef<Path>) -> Result<Recovered, Error> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|e| Error::system("read the recording", path, &e))?;
    let mut scan = Scan::new(&bytes).ok_or_else(|| {
        Error::new(
            "there is nothing to recover: this is no MCAP recording",
            path.display().to_string(),
            "delete the file, or give another one",
        )
    })?;
    let chunks = scan.chunks.len();
    scan.chunks
        .retain(|chunk| chunk.messages(&bytes, |_, _| ()).is_some());
    scan.damaged += chunks - scan.chunks.len();
    let mut recovered = Recovered {
        was_complete: scan.complete && scan.damaged == 0,
        messages: count(&scan, &bytes),
        lost_bytes: scan.lost_bytes,
        damaged_chunks: scan.damaged,
    };
    if !recovered.was_complete {
        recovered.messages = rewrite(path, &scan, &bytes)?;
    }
    Ok(recovered)
}

fn count(scan: &Scan, bytes: &[u8]) -> u64 {
    let mut messages = 0;
    for chunk in &scan.chunks {
        chunk.messages(bytes, |_, _| messages += 1);
    }
    messages
}

fn rewrite(path: &Path, scan: &Scan, bytes: &[u8]) -> Result<u64, Error> {
    let beside = beside(path);
    let written = write(&beside, scan, bytes);
    let done = written.and_then(|messages| {
        std::fs::rename(&beside, path)
            .map_err(|e| Error::system("replace the recording", path, &e))?;
        Ok(messages)
    });
    if done.is_err() {
        let _ = std::fs::remove_file(&beside); // the error that is returned matters more
    }
    done
}

fn beside(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".recovering");
    name.into()
}

fn write(path: &Path, scan: &Scan, bytes: &[u8]) -> Result<u64, Error> {
    let file =
        File::create(path).map_err(|e| Error::system("write beside the recording", path, &e))?;
    let fail = |e| failure(path, e);
    let mut writer = options().create(BufWriter::new(file)).map_err(fail)?;
    writer
        .write_metadata(&mcap::records::Metadata {
            name: RECORD.into(),
            metadata: metadata(scan),
        })
        .map_err(fail)?;
    for (id, schema) in &scan.schemas {
        let Schema {
            name,
            encoding,
            data,
        } = schema;
        writer
            .add_schema_with_id(*id, name, encoding, data)
            .map_err(fail)?;
    }
    for (id, c) in &scan.channels {
        if c.schema_id == 0 || scan.schemas.contains_key(&c.schema_id) {
            let added = writer.add_channel_with_id(
                *id,
                c.schema_id,
                &c.topic,
                &c.message_encoding,
                &c.metadata,
            );
            added.map_err(fail)?;
        }
    }
    let mut messages = 0;
    for chunk in &scan.chunks {
        let mut outcome = Ok(());
        chunk.messages(bytes, |header, data| {
            if outcome.is_ok() && scan.channels.contains_key(&header.channel_id) {
                outcome = writer.write_to_known_channel(header, data);
                messages += 1;
            }
        });
        outcome.map_err(fail)?;
    }
    writer.finish().map_err(fail)?;
    let file = writer.into_inner().into_inner();
    file.map_err(|e| e.into_error())
        .and_then(|file| file.sync_all())
        .map_err(|e| Error::system("write beside the recording", path, &e))?;
    Ok(messages)
}

/// The metadata of the run, with a note that the recording was mended.
fn metadata(scan: &Scan) -> Metadata {
    let mut metadata = scan.metadata.clone();
    let note = format!(
        "cut off: {} bytes at the end and {} damaged chunks lost",
        scan.lost_bytes, scan.damaged
    );
    metadata.insert("recovered".into(), note);
    metadata
}
