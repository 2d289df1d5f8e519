use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use messages::channels::Channel;
use messages::{Hops, Message, Stamp};

use crate::{Error, schema, wire};

/// What a recording says of its run, by name: seed, configuration, version, host.
pub type Metadata = BTreeMap<String, String>;

/// Name of the metadata record.
pub(crate) const RECORD: &str = "heft";

/// Writes an MCAP recording. Only whole chunks reach the file, so that a process killed at any
/// moment loses at most what came after the last [`Writer::flush`] and leaves a file that
/// [`crate::recover`] mends.
pub struct Writer {
    inner: mcap::Writer<BufWriter<File>>,
    path: PathBuf,
    ids: Vec<(&'static str, u16)>,
    bytes: Vec<u8>,
}

impl Writer {
    /// Creates the file, or empties it, and writes the metadata.
    ///
    /// # Errors
    /// The file cannot be created or written.
    pub fn create(path: impl AsRef<Path>, metadata: &Metadata) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let file =
            File::create(&path).map_err(|e| Error::system("create the recording", &path, &e))?;
        let mut inner = options()
            .create(BufWriter::new(file))
            .map_err(|e| failure(&path, e))?;
        inner
            .write_metadata(&mcap::records::Metadata {
                name: RECORD.into(),
                metadata: metadata.clone(),
            })
            .and_then(|()| inner.flush())
            .map_err(|e| failure(&path, e))?;
        Ok(Self {
            inner,
            path,
            ids: Vec::new(),
            bytes: Vec::new(),
        })
    }

    /// Adds a message to its channel. It is stamped with the time of its measurement and with that
    /// of its last hop; where no clock was read (replays), with the time of the data.
    ///
    /// # Errors
    /// The file cannot be written. What was flushed before stays readable; nothing more can be
    /// added.
    pub fn write<M: Message>(&mut self, channel: &Channel, message: &M) -> Result<(), Error> {
        let channel_id = self.channel_id::<M>(channel)?;
        let (log_time, publish_time) = times(message.stamp(), message.hops());
        self.bytes.clear();
        wire::encode(message, &mut self.bytes);
        let header = MessageHeader {
            channel_id,
            sequence: message.stamp().sequence as u32,
            log_time,
            publish_time,
        };
        self.inner
            .write_to_known_channel(&header, &self.bytes)
            .map_err(|e| failure(&self.path, e))
    }

    /// Closes the chunk and hands everything to the operating system: it survives the end of this
    /// process, but not of the machine.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn flush(&mut self) -> Result<(), Error> {
        self.inner.flush().map_err(|e| failure(&self.path, e))
    }

    /// Writes index and footer and waits until the disk has it all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> Result<(), Error> {
        self.inner.finish().map_err(|e| failure(&self.path, e))?;
        let file = self.inner.into_inner().into_inner();
        file.map_err(|e| e.into_error())
            .and_then(|file| file.sync_all())
            .map_err(|e| Error::system("write the recording", &self.path, &e))
    }

    fn channel_id<M: Message>(&mut self, channel: &Channel) -> Result<u16, Error> {
        let known = self.ids.iter().find(|(name, _)| *name == channel.name);
        if let Some((_, id)) = known {
            return Ok(*id);
        }
        let id = self
            .inner
            .add_schema(&schema::name::<M>(), "protobuf", &schema::bytes::<M>())
            .and_then(|schema| {
                let empty = BTreeMap::new();
                self.inner
                    .add_channel(schema, channel.name, "protobuf", &empty)
            })
            .map_err(|e| failure(&self.path, e))?;
        self.ids.push((channel.name, id));
        Ok(id)
    }
}

/// Chunks are put together in memory and written at once (no seeking back into the file).
pub(crate) fn options() -> mcap::WriteOptions {
    mcap::WriteOptions::new()
        .profile("heft")
        .library(concat!("heft ", env!("CARGO_PKG_VERSION")))
        .compression(Some(mcap::Compression::Lz4))
        .disable_seeking(true)
}

/// Log time and publish time [ns].
fn times(stamp: &Stamp, hops: &Hops) -> (u64, u64) {
    let log = if stamp.measured_ns != 0 {
        stamp.measured_ns
    } else {
        (stamp.time * 1e9).round() as u64 // NaN and negative times become 0
    };
    let last = hops.sensor_ns.max(hops.filter_ns).max(hops.estimate_ns);
    (log, if last == 0 { log } else { last })
}

pub(crate) fn failure(path: &Path, error: mcap::McapError) -> Error {
    match error {
        mcap::McapError::Io(e) => Error::system("write the recording", path, &e),
        other => Error::new(
            format!("cannot write the recording: {other}"),
            path.display().to_string(),
            "the recording ends here; what was written before stays readable",
        ),
    }
}

/// SHA-256 of a text in hexadecimal digits, by which a recording names its description.
#[must_use]
pub fn sha256(data: impl AsRef<[u8]>) -> String {
    use sha2::Digest;
    let digest = sha2::Sha256::digest(data);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
