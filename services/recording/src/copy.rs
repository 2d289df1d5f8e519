//! Every complete message of a recording, in the order of the file.

use std::collections::BTreeMap;

use mcap::records::op;

use crate::Error;
use crate::reader::{Part, Reader};
use crate::record;
use crate::scan::{Damage, Unpacked};

impl Reader {
    /// Number of messages of each channel.
    pub fn counts(&self) -> BTreeMap<String, u64> {
        let mut counts = BTreeMap::new();
        // Damage is noted when a channel is read.
        let counted = copy(self, |part, head, _| {
            if let Some(channel) = self.parts[part].scan.channels.get(&head.channel) {
                match counts.get_mut(&channel.topic) {
                    Some(count) => *count += 1,
                    None => drop(counts.insert(channel.topic.clone(), 1)),
                }
            }
            Ok(())
        });
        let _ = counted; // nothing in there can fail
        counts
    }
}

/// Calls `take` with part, head and content of every complete message; returns their number.
/// Damage is noted by the reader.
pub(crate) fn copy(
    reader: &Reader,
    mut take: impl FnMut(usize, &record::Message, &[u8]) -> Result<(), Error>,
) -> Result<u64, Error> {
    let mut messages = 0;
    for (i, part) in reader.parts.iter().enumerate() {
        for_each_message(reader, i, |head, data| {
            if !part.is_whole(head, data) {
                return Ok(Some(DAMAGED));
            }
            messages += 1;
            take(i, head, data).map(|()| None)
        })?;
    }
    Ok(messages)
}

/// Damage of a block in which the records are not whole.
const DAMAGED: &str = "a damaged message in the block";
/// Damage of a block with a message that does not conform to its schema.
pub(crate) const UNREADABLE: &str = "a message that cannot be read in the block";

/// Calls `found` with head and content of each message of a part, in the order of the file; it returns the damage of one that it cannot
/// read. Damage is noted by the reader.
pub(crate) fn for_each_message<E>(
    reader: &Reader,
    part: usize,
    mut found: impl FnMut(&record::Message, &[u8]) -> Result<Option<&'static str>, E>,
) -> Result<(), E> {
    let mut unpacked = Unpacked::default();
    let Part { bytes, scan, .. } = &reader.parts[part];
    for chunk in &scan.chunks {
        reader.tell(part, chunk.at);
        let note = |what| {
            let damage = chunk.damage();
            reader.note(part, Damage { what, ..damage });
        };
        if unpacked.load(chunk, bytes).is_none() {
            reader.note(part, chunk.damage());
            continue;
        }
        while let Some((opcode, body)) = unpacked.next() {
            if opcode == op::MESSAGE {
                match record::message(body) {
                    Some((head, data)) => found(&head, data)?.into_iter().for_each(note),
                    None => note(DAMAGED),
                }
            }
        }
        if !unpacked.is_at_end() {
            note(DAMAGED);
        }
    }
    for &(at, end) in &scan.loose {
        let body = bytes.range(at, end);
        let damage = match body.as_deref().and_then(record::message) {
            Some((head, data)) => found(&head, data)?,
            None => Some(DAMAGED),
        };
        if damage.is_some() {
            let what = "a message that cannot be read";
            let bytes = end - at;
            reader.note(part, Damage { at, bytes, what });
        }
    }
    Ok(())
}
