//! Mark of a recording's contents, for the successor of a logger that died.
//!
//! A flush writes one chunk of the file. Before it, the logger marks where that chunk will start, and which samples are
//! recorded without it and with it. Whenever the logger dies, its successor finds out by the chunk which of the two applies.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use messages::channels::Channel;

/// Number after that of the latest sample, by channel.
pub type Next = BTreeMap<String, u64>;

/// A mark beside a recording that is being written.
#[derive(Debug)]
pub struct Mark {
    file: PathBuf,
    /// Flushed contents of the recording.
    recorded: Next,
    /// The same with the samples written since the last flush.
    written: Next,
}

impl Mark {
    /// Reads the mark that a dead logger of the recording `first` may have left in `file`, and continues from it.
    pub fn open(file: &Path, first: &Path) -> Self {
        let text = fs::read_to_string(file).unwrap_or_default();
        let recorded = read(&text, first).unwrap_or_default();
        Self {
            file: file.to_owned(),
            written: recorded.clone(),
            recorded,
        }
    }

    /// Flushed contents of the recording.
    pub fn recorded(&self) -> &Next {
        &self.recorded
    }

    /// Notes a sample that is written, but not flushed.
    pub fn note(&mut self, channel: &Channel, sequence: u64) {
        let next = sequence + 1;
        match self.written.get_mut(channel.name) {
            Some(known) => *known = next.max(*known),
            None => drop(self.written.insert(channel.name.to_owned(), next)),
        }
    }

    /// Marks that a flush follows, whose chunk starts at byte `at` of the part `part`. The file is replaced atomically.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn begin_flush(&self, part: &Path, at: u64) -> io::Result<()> {
        let mut text = format!("{} {at}\n", recording::part_number(part));
        for (channel, with) in &self.written {
            let without = self.recorded.get(channel).copied().unwrap_or_default();
            text += &format!("{channel} {without} {with}\n");
        }
        let new = self.file.with_extension("new");
        fs::write(&new, text)?;
        fs::rename(&new, &self.file)
    }

    /// Notes that all samples are flushed.
    pub fn end_flush(&mut self) {
        self.recorded.clone_from(&self.written);
    }
}

/// Contents of a mark; `None` if the text is not one.
fn read(text: &str, first: &Path) -> Option<Next> {
    let mut lines = text.lines();
    let (part, at) = lines.next()?.split_once(' ')?;
    let part = recording::part(first, part.parse().ok()?);
    let has_chunk = recording::has_chunk_at(&part, at.parse().ok()?);
    let line = |line: &str| {
        let mut words = line.split(' ');
        let (channel, without, with) = (words.next()?, words.next()?, words.next()?);
        let next = if has_chunk { with } else { without };
        Some((channel.to_owned(), next.parse().ok()?))
    };
    lines.map(line).collect()
}
