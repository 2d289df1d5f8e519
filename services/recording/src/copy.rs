//! Every complete message of a recording, in the order of the file.

use std::collections::BTreeMap;

use mcap::records::op;

use crate::Error;
use crate::reader::Reader;
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
    let mut unpacked = Unpacked::default();
    for (i, part) in reader.parts.iter().enumerate() {
        for chunk in &part.scan.chunks {
            reader.tell(i, chunk.at);
            if unpacked.load(chunk, &part.bytes).is_none() {
                reader.note(i, chunk.damage());
                continue;
            }
            let mut damaged = false;
            while let Some((opcode, body)) = unpacked.next() {
                if opcode != op::MESSAGE {
                    continue;
                }
                match record::message(body).filter(|(head, data)| part.is_whole(head, data)) {
                    Some((head, data)) => {
                        take(i, &head, data)?;
                        messages += 1;
                    }
                    None => damaged = true,
                }
            }
            if damaged || !unpacked.is_at_end() {
                let what = "a damaged message in the block";
                let damage = chunk.damage();
                reader.note(i, Damage { what, ..damage });
            }
        }
        for (start, end) in &part.scan.loose {
            let body = part.bytes.range(*start, *end);
            let message = body.as_deref().and_then(record::message);
            match message.filter(|(head, data)| part.is_whole(head, data)) {
                Some((head, data)) => {
                    take(i, &head, data)?;
                    messages += 1;
                }
                None => reader.note(
                    i,
                    Damage {
                        at: *start,
                        bytes: end - start,
                        what: "a message that cannot be read",
                    },
                ),
            }
        }
    }
    Ok(messages)
}
