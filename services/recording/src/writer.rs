use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use messages::channels::Channel;
use messages::{Hops, Message, Stamp};

use crate::file::{self, ClaimError};
use crate::{Error, schema, wire};

/// Metadata of a run, by name: seed, configuration, version, host.
pub type Metadata = BTreeMap<String, String>;

/// Name of the metadata record.
pub(crate) const RECORD: &str = "heft";

/// Name of a metadata record for a jump of the wall clock, and its key.
pub(crate) const CLOCK: &str = "heft.clock";
pub(crate) const JUMP: &str = "jump";

/// Key under which a reader returns all jumps.
pub(crate) const JUMPS: &str = "wall_clock.jumps";

/// Key of the check sum over all other pairs, which MCAP itself does not provide.
pub(crate) const METADATA_SUM: &str = "metadata.sha256";

/// Part of the library's name that states that there must be a check sum.
pub(crate) const WITH_SUM: &str = ", metadata with check sum";

/// Bytes of a message in a chunk before its content.
const MESSAGE_HEAD: u64 = 9 + 22;

/// Writes an MCAP recording. Only complete chunks reach the file. A process killed at any
/// moment loses at most the messages after the last [`Writer::flush`], and leaves a file that every
/// reader reads. The file is locked as long as it is written.
pub struct Writer {
    inner: mcap::Writer<BufWriter<File>>,
    /// The same file, for its length.
    file: File,
    path: PathBuf,
    ids: Vec<(&'static str, u16)>,
    bytes: Vec<u8>,
    unflushed: u64,
    wall_offset_ns: i64,
}

impl Writer {
    /// Begins a recording and writes the metadata. The file must be new or empty: an existing
    /// recording is never truncated.
    ///
    /// # Errors
    /// The file exists, or cannot be created or written; a new file is then removed.
    pub fn create(path: impl AsRef<Path>, metadata: &Metadata) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let file = file::take(&path).map_err(|e| refused(&path, e))?;
        Self::begin(path.clone(), file, metadata).inspect_err(|_| {
            if path.is_file() {
                let _ = std::fs::remove_file(&path); // the error that is returned matters more
            }
        })
    }

    fn begin(path: PathBuf, file: File, metadata: &Metadata) -> Result<Self, Error> {
        let same = file
            .try_clone()
            .map_err(|e| Error::system("create the recording", &path, &e))?;
        let mut inner = options()
            .create(BufWriter::new(file))
            .map_err(|e| failure(&path, e))?;
        inner
            .write_metadata(&mcap::records::Metadata {
                name: RECORD.into(),
                metadata: with_sum(metadata),
            })
            .and_then(|()| inner.flush())
            .map_err(|e| failure(&path, e))?;
        Ok(Self {
            inner,
            file: same,
            path,
            ids: Vec::new(),
            bytes: Vec::new(),
            unflushed: 0,
            wall_offset_ns: 0,
        })
    }

    /// Stamps the messages with wall time, their monotonic times plus this \[ns\], so that
    /// viewers show the date. The messages themselves retain the monotonic clock.
    pub fn set_wall_offset(&mut self, offset_ns: i64) {
        self.wall_offset_ns = offset_ns;
    }

    /// Adds a message to its channel. It is stamped with the time of its measurement and with that
    /// of its last hop; without clock times (replays), with the time of the data.
    ///
    /// # Errors
    /// The file cannot be written. Flushed messages stay readable; no more can be
    /// added.
    pub fn write<M: Message>(&mut self, channel: &Channel, message: &M) -> Result<(), Error> {
        let channel_id = self.channel_id::<M>(channel)?;
        let (log_time, publish_time) = times(message.stamp(), message.hops(), self.wall_offset_ns);
        self.bytes.clear();
        wire::encode(message, &mut self.bytes);
        self.unflushed += MESSAGE_HEAD + self.bytes.len() as u64;
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

    /// Records a jump of the wall clock as text, and flushes.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn note_clock(&mut self, text: &str) -> Result<(), Error> {
        let record = mcap::records::Metadata {
            name: CLOCK.into(),
            metadata: [(JUMP.to_owned(), text.to_owned())].into(),
        };
        let written = self.inner.write_metadata(&record);
        written.map_err(|e| failure(&self.path, e))?;
        self.flush()
    }

    /// Closes the chunk and passes all data to the operating system: they survive the end of this
    /// process, but not of the machine.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn flush(&mut self) -> Result<(), Error> {
        self.unflushed = 0;
        self.inner.flush().map_err(|e| failure(&self.path, e))
    }

    /// Bytes of messages with their heads since the last flush, not yet compressed.
    pub fn unflushed(&self) -> u64 {
        self.unflushed
    }

    /// Bytes in the file.
    pub fn size(&self) -> u64 {
        self.file.metadata().map_or(0, |m| m.len())
    }

    /// Whether its file was deleted meanwhile: the data written are lost with it.
    pub fn is_deleted(&self) -> bool {
        let about = self.file.metadata();
        about.is_ok_and(|about| std::os::unix::fs::MetadataExt::nlink(&about) == 0)
    }

    /// Writes index and footer and waits until all data are on the disk.
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

/// Chunks are assembled in memory and written at once (no seeking back in the file).
pub(crate) fn options() -> mcap::WriteOptions {
    mcap::WriteOptions::new()
        .profile("heft")
        .library(format!("heft {}{WITH_SUM}", env!("CARGO_PKG_VERSION")))
        .compression(Some(mcap::Compression::Lz4))
        .disable_seeking(true)
}

/// Log time and publish time [ns].
fn times(stamp: &Stamp, hops: &Hops, wall_offset_ns: i64) -> (u64, u64) {
    let wall = |monotonic: u64| monotonic.saturating_add_signed(wall_offset_ns);
    let log = if stamp.measured_ns != 0 {
        wall(stamp.measured_ns)
    } else {
        (stamp.time * 1e9).round() as u64 // NaN and negative times become 0
    };
    let last = hops.sensor_ns.max(hops.filter_ns).max(hops.estimate_ns);
    (log, if last == 0 { log } else { wall(last) })
}

/// The pairs with their check sum.
pub(crate) fn with_sum(metadata: &Metadata) -> Metadata {
    let mut metadata = metadata.clone();
    metadata.remove(METADATA_SUM);
    metadata.insert(METADATA_SUM.into(), sum_of(&metadata));
    metadata
}

/// Check sum of pairs.
pub(crate) fn sum_of(metadata: &Metadata) -> String {
    let length = |text: &str| format!("{} {text}\n", text.len());
    let pairs = metadata.iter().map(|(k, v)| length(k) + &length(v));
    sha256(pairs.collect::<String>())
}

fn refused(path: &Path, taken: ClaimError) -> Error {
    match taken {
        ClaimError::System(e) => Error::system("create the recording", path, &e),
        ClaimError::Exists => Error::new(
            "there is a recording already; it is not overwritten",
            path.display().to_string(),
            "choose another name or folder, or move the file away",
        ),
    }
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

/// SHA-256 of a text in hexadecimal digits, which identifies the description in a recording.
pub fn sha256(data: impl AsRef<[u8]>) -> String {
    use sha2::Digest;
    let digest = sha2::Sha256::digest(data);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
