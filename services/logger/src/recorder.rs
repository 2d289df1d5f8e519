//! Parts of a recording: splitting, removal of old ones, and free space on the disk.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use messages::channels::Channel;
use messages::{Envelope, Message, Receiver};
use recording::{Error, Metadata, Writer};
use rustix::time::ClockId;

use crate::ages::{Ages, nanoseconds};
use crate::mark::Mark;

/// Limits of an endless recording; none by default.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Limits {
    /// Duration of a part.
    pub split_after: Option<Duration>,
    /// Size of a part \[bytes\].
    pub split_bytes: Option<u64>,
    /// Size of the folder above which its oldest recordings are removed \[bytes\].
    pub keep_bytes: Option<u64>,
    /// Age since the last write above which recordings of the folder are removed.
    pub keep_for: Option<Duration>,
    /// Free space of the disk below which recording stops \[bytes\].
    pub min_free: Option<u64>,
    /// A group of users that may also read it.
    pub group: Option<u32>,
}

/// Change of the offset between wall clock and monotonic clock that counts as a jump [ns].
const JUMP_NS: i64 = 500_000_000;
/// Time between two attempts to resume after the disk was full.
const RETRY: Duration = Duration::from_secs(5);

/// Length at which a chunk is flushed [bytes], before the writer closes it by itself (768 kB): a flush is one chunk.
const CHUNK: u64 = 512 << 10;

/// Writes messages into the parts of a recording.
pub struct Recorder {
    first: PathBuf,
    metadata: Metadata,
    limits: Limits,
    /// `None` while the disk takes no more.
    writer: Option<Writer>,
    part: PathBuf,
    mark: Mark,
    begun: Instant,
    wall_offset_ns: i64,
    ages: Ages,
    stopped: Instant,
}

impl Recorder {
    /// Starts the recording `first`, or its next part where it exists already; `mark` contains its progress.
    ///
    /// # Errors
    /// The file cannot be created.
    pub fn create(
        first: &Path,
        metadata: &Metadata,
        limits: Limits,
        mark: Mark,
    ) -> Result<Self, Error> {
        let mut recorder = Self {
            first: first.to_owned(),
            metadata: metadata.clone(),
            limits,
            writer: None,
            part: first.to_owned(),
            mark,
            begun: Instant::now(),
            wall_offset_ns: 0,
            ages: Ages::begin(),
            stopped: Instant::now(),
        };
        recorder.begin()?;
        Ok(recorder)
    }

    fn begin(&mut self) -> Result<(), Error> {
        let begun = std::fs::metadata(&self.first).is_ok_and(|m| m.is_file() && m.len() > 0);
        // The first part may have been removed already.
        let next = recording::next_part(&self.first);
        self.part = if begun || !self.first.exists() {
            next
        } else {
            self.first.clone()
        };
        self.wall_offset_ns = wall_offset_ns();
        let mut metadata = self.metadata.clone();
        let number = recording::part_number(&self.part);
        metadata.insert(recording::PART.into(), number.to_string());
        let seconds = runtime::since_1970().as_secs();
        metadata.insert("wall_clock.start".into(), recording::date_and_time(seconds));
        metadata.insert(
            "wall_clock.minus_monotonic_ns".into(),
            self.wall_offset_ns.to_string(),
        );
        let mut writer = Writer::create(&self.part, &metadata)?;
        // Locked before any other process can open it.
        let shared = self
            .limits
            .group
            .map(|group| runtime::share(&self.part, group));
        if let Some(Err(error)) = shared {
            tracing::warn!(%error, "the recording is not given to the group");
        }
        writer.set_wall_offset(self.wall_offset_ns);
        tracing::info!(file = %self.part.display(), part = number, "a part of the recording begins");
        self.writer = Some(writer);
        self.begun = Instant::now();
        Ok(())
    }

    /// Records a message; false if it is not recorded. The caller flushes while a part [is due](Self::is_full).
    ///
    /// # Errors
    /// The disk takes no more. Recording then stops, and resumes by itself when there is room.
    pub fn write(&mut self, channel: &'static Channel, envelope: &Envelope) -> Result<bool, Error> {
        let Some(writer) = &mut self.writer else {
            return Ok(false);
        };
        if let Err(error) = envelope.open(WriteTo(writer, channel)) {
            return Err(self.stop(error));
        }
        self.mark.note(channel, envelope.stamp().sequence);
        Ok(true)
    }

    /// Whether the unflushed length requires a flush now: however fast messages come, a part becomes at most twice as large
    /// as requested.
    pub fn is_full(&self) -> bool {
        let most = self.limits.split_bytes.unwrap_or(CHUNK).min(CHUNK);
        self.writer.as_ref().is_some_and(|w| w.unflushed() >= most)
    }

    /// Passes all data to the operating system, and maintains free space, parts and clock.
    ///
    /// # Errors
    /// As [`Recorder::write`].
    pub fn flush(&mut self) -> Result<(), Error> {
        let Some(writer) = &mut self.writer else {
            return self.try_again();
        };
        if writer.unflushed() > 0 {
            // Without a mark a successor may record some samples twice, which is better than no recording.
            if let Err(error) = self.mark.begin_flush(&self.part, writer.size()) {
                tracing::warn!(%error, "cannot mark what is recorded");
            }
            if let Err(error) = writer.flush() {
                return Err(self.stop(error));
            }
            self.mark.end_flush();
        }
        if writer.is_deleted() {
            let error = self.deleted();
            self.stop(error.clone());
            self.begin()?;
            return Err(error);
        }
        let size = writer.size();
        self.look_at_the_clock()?;
        if let Some(error) = self.lacks_room() {
            let finished = self.finish();
            self.stopped = Instant::now();
            return finished.and(Err(error));
        }
        let full = self.limits.split_bytes.is_some_and(|most| size >= most)
            || self
                .limits
                .split_after
                .is_some_and(|most| self.begun.elapsed() >= most);
        if full {
            self.finish()?;
            self.begin()?;
            self.remove_old();
        }
        Ok(())
    }

    /// Ends the part: index and footer.
    ///
    /// # Errors
    /// The file cannot be written; what was flushed stays readable.
    pub fn finish(&mut self) -> Result<(), Error> {
        self.writer.take().map_or(Ok(()), Writer::finish)
    }

    /// Error: the part that is being written was deleted, with its contents.
    fn deleted(&self) -> Error {
        Error {
            what: "the recording was deleted while it was written: what it held is lost".into(),
            place: self.part.display().to_string(),
            remedy: "leave it to --keep; the recording goes on in a new part".into(),
            io: None,
        }
    }

    fn stop(&mut self, error: Error) -> Error {
        self.writer = None;
        self.stopped = Instant::now();
        error
    }

    fn try_again(&mut self) -> Result<(), Error> {
        if self.stopped.elapsed() < RETRY {
            return Ok(());
        }
        self.stopped = Instant::now();
        self.remove_old();
        if self.lacks_room().is_some() {
            return Ok(());
        }
        // Still full: that was reported when it began.
        let _ = self.begin();
        Ok(())
    }

    /// Error: the disk has too little free space.
    fn lacks_room(&self) -> Option<Error> {
        let least = self.limits.min_free?;
        let folder = self.first.parent()?;
        let disk = rustix::fs::statvfs(folder).ok()?;
        let free = disk.f_bavail.saturating_mul(disk.f_frsize);
        (free < least).then(|| Error {
            what: format!(
                "the disk has {} MB of room left, less than --min-free asks for",
                free / 1_000_000
            ),
            place: folder.display().to_string(),
            remedy: "make room: the recording goes on by itself then, in a new part".into(),
            io: Some(std::io::ErrorKind::StorageFull),
        })
    }

    fn look_at_the_clock(&mut self) -> Result<(), Error> {
        self.ages.look();
        let offset = wall_offset_ns();
        let jump = offset.saturating_sub(self.wall_offset_ns);
        if jump.abs() < JUMP_NS {
            return Ok(());
        }
        self.wall_offset_ns = offset;
        let seconds = jump as f64 / 1e9;
        tracing::warn!("the wall clock jumped by {seconds:.3} s; the recording keeps its time");
        let text = format!(
            "{seconds:.3} s at {} ns of the monotonic clock",
            monotonic_ns()
        );
        match self.writer.as_mut().map(|w| w.note_clock(&text)) {
            Some(Err(error)) => Err(self.stop(error)),
            _ => Ok(()),
        }
    }

    /// Removes the oldest recordings of the folder until the rest is within its limits. The part that
    /// is being written stays, and so do those that another run is writing, and every file with another name.
    /// The parts of this recording are the newest, in their order, whatever the clock says of them.
    fn remove_old(&self) {
        let (
            Some(folder),
            Limits {
                keep_bytes,
                keep_for,
                ..
            },
        ) = (self.first.parent(), self.limits)
        else {
            return;
        };
        if keep_bytes.is_none() && keep_for.is_none() {
            return;
        }
        let mut files = recording::files_by_age(folder);
        files.retain(|(file, _, _)| *file != self.part);
        files.sort_by_key(|(file, ..)| {
            let is_own = recording::is_part_of(&self.first, file);
            is_own.then(|| recording::part_number(file))
        });
        let now = SystemTime::now();
        let own = self.writer.as_ref().map_or(0, Writer::size);
        let mut total: u64 = own + files.iter().map(|f| f.2).sum::<u64>();
        for (file, changed, size) in files {
            let too_old = keep_for.is_some_and(|most| self.ages.age(changed, now) > most);
            let too_much = keep_bytes.is_some_and(|most| total > most);
            // A user who may read a part may lock it, so the lock of this recorder's finished parts is ignored.
            let is_finished = recording::is_part_of(&self.first, &file);
            if (too_old || too_much) && (is_finished || !recording::is_being_written(&file)) {
                match std::fs::remove_file(&file) {
                    Ok(()) => total -= size,
                    Err(e) => tracing::warn!(file = %file.display(), "cannot remove: {e}"),
                }
            }
        }
    }
}

struct WriteTo<'a>(&'a mut Writer, &'static Channel);

impl Receiver for WriteTo<'_> {
    type Output = Result<(), Error>;
    fn receive<M: Message>(self, message: &M) -> Self::Output {
        self.0.write(self.1, message)
    }
}

fn monotonic_ns() -> i64 {
    nanoseconds(ClockId::Monotonic)
}

/// Wall time minus the monotonic clock [ns].
fn wall_offset_ns() -> i64 {
    nanoseconds(ClockId::Realtime) - monotonic_ns()
}

#[cfg(test)]
mod tests;
