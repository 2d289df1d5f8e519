//! What a recording holds already, for the logger that is started in place of one that died.
//!
//! A flush makes one chunk of the file. Before it the logger marks where that chunk will begin, and which samples are
//! recorded without it and with it. At whatever moment it dies, its successor sees by the chunk which of the two is so.

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
    /// What the recording holds.
    recorded: Next,
    /// The same with what is written since the last flush.
    written: Next,
}

impl Mark {
    /// Reads the mark that a dead logger of the recording `first` may have left in `file`, and goes on from it.
    pub fn open(file: &Path, first: &Path) -> Self {
        let text = fs::read_to_string(file).unwrap_or_default();
        let recorded = read(&text, first).unwrap_or_default();
        Self {
            file: file.to_owned(),
            written: recorded.clone(),
            recorded,
        }
    }

    /// What the recording holds.
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

    /// Marks that a flush follows, whose chunk begins at byte `at` of the part `part`. In one step: a mark is whole.
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

    /// Notes that everything is flushed.
    pub fn end_flush(&mut self) {
        self.recorded.clone_from(&self.written);
    }
}

/// What a mark tells; `None` if it is none.
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
