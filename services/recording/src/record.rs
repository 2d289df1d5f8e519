//! The records of an MCAP file that heft reads (<https://mcap.dev/spec>). Every length is checked
//! against the remaining bytes before memory is reserved for it.

use std::collections::BTreeMap;

/// Opcode and length of a record.
pub(crate) const HEAD: u64 = 9;

/// A schema of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Schema {
    pub id: u16,
    pub name: String,
    pub encoding: String,
    pub data: Vec<u8>,
}

/// A channel of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Channel {
    pub id: u16,
    pub schema_id: u16,
    pub topic: String,
    pub encoding: String,
    pub metadata: BTreeMap<String, String>,
}

/// The head of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Message {
    pub channel: u16,
    pub sequence: u32,
    pub log_time: u64,
    pub publish_time: u64,
}

/// The head of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ChunkHead {
    /// Time of its first message [ns].
    pub start_time: u64,
    /// Bytes when unpacked.
    pub unpacked: u64,
    /// Check sum of the unpacked bytes, 0 for none.
    pub crc: u32,
    /// Compression of the records.
    pub packing: Packing,
    /// Bytes in the file.
    pub packed: u64,
    /// Bytes of the record before the compressed ones.
    pub length: u64,
}

/// Compression of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Packing {
    None,
    Lz4,
    Zstd,
}

/// Largest length of a chunk's head [bytes].
pub(crate) const CHUNK_HEAD: usize = 8 + 8 + 8 + 4 + 4 + 4 + 8;

pub(crate) fn schema(mut body: &[u8]) -> Option<Schema> {
    let b = &mut body;
    Some(Schema {
        id: u16(b)?,
        name: text(b)?,
        encoding: text(b)?,
        data: block(b)?.to_vec(),
    })
}

pub(crate) fn channel(mut body: &[u8]) -> Option<Channel> {
    let b = &mut body;
    Some(Channel {
        id: u16(b)?,
        schema_id: u16(b)?,
        topic: text(b)?,
        encoding: text(b)?,
        metadata: map(b)?,
    })
}

pub(crate) fn message(mut body: &[u8]) -> Option<(Message, &[u8])> {
    let b = &mut body;
    let head = Message {
        channel: u16(b)?,
        sequence: u32(b)?,
        log_time: u64(b)?,
        publish_time: u64(b)?,
    };
    Some((head, body))
}

/// Name and pairs of a metadata record, whose lengths must match exactly.
pub(crate) fn metadata(mut body: &[u8]) -> Option<(String, BTreeMap<String, String>)> {
    let b = &mut body;
    let found = (text(b)?, map(b)?);
    body.is_empty().then_some(found)
}

/// The head of a chunk that heft can decompress.
pub(crate) fn chunk_head(body: &[u8]) -> Option<ChunkHead> {
    let mut rest = body;
    let b = &mut rest;
    let (start_time, _) = (u64(b)?, u64(b)?);
    let (unpacked, crc) = (u64(b)?, u32(b)?);
    let packing = match block(b)? {
        b"lz4" => Packing::Lz4,
        b"zstd" => Packing::Zstd,
        b"" => Packing::None,
        _ => return None,
    };
    let packed = u64(b)?;
    Some(ChunkHead {
        start_time,
        unpacked,
        crc,
        packing,
        packed,
        length: (body.len() - rest.len()) as u64,
    })
}

/// Whether the lengths within a message index match that of the record.
pub(crate) fn is_message_index(head: &[u8], length: u64) -> bool {
    let mut head = head;
    let b = &mut head;
    u16(b)
        .and_then(|_| u32(b))
        .is_some_and(|array| u64::from(array) + 6 == length && array % 16 == 0)
}

/// Start and check sum of the summary, from a footer.
pub(crate) fn footer(mut body: &[u8]) -> Option<(u64, u32)> {
    let b = &mut body;
    let (start, _offsets) = (u64(b)?, u64(b)?);
    Some((start, u32(b)?))
}

/// Opcode, body and end of the record at `at`; `None` if it is not complete.
pub(crate) fn at(bytes: &[u8], at: usize) -> Option<(u8, &[u8], usize)> {
    let (head, rest) = bytes.get(at..)?.split_first_chunk::<9>()?;
    let [opcode, length @ ..] = *head;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    Some((opcode, rest.get(..length)?, at + 9 + length))
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (head, rest) = bytes.split_first_chunk::<N>()?;
    *bytes = rest;
    Some(*head)
}

fn u16(bytes: &mut &[u8]) -> Option<u16> {
    take(bytes).map(u16::from_le_bytes)
}

fn u32(bytes: &mut &[u8]) -> Option<u32> {
    take(bytes).map(u32::from_le_bytes)
}

fn u64(bytes: &mut &[u8]) -> Option<u64> {
    take(bytes).map(u64::from_le_bytes)
}

/// A block of bytes that follows its length.
fn block<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = usize::try_from(u32(bytes)?).ok()?;
    let found = bytes.get(..length)?;
    *bytes = &bytes[length..];
    Some(found)
}

fn text(bytes: &mut &[u8]) -> Option<String> {
    String::from_utf8(block(bytes)?.to_vec()).ok()
}

fn map(bytes: &mut &[u8]) -> Option<BTreeMap<String, String>> {
    let mut pairs = block(bytes)?;
    let mut map = BTreeMap::new();
    while !pairs.is_empty() {
        map.insert(text(&mut pairs)?, text(&mut pairs)?);
    }
    Some(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_beyond_the_bytes_reserves_nothing() {
        let mut body = vec![0xff, 0xff, 0xff, 0x7f]; // a name of 2 GiB
        body.extend_from_slice(b"heft");
        assert_eq!(metadata(&body), None);
        assert_eq!(schema(&body), None);
        assert_eq!(channel(&body), None);
    }

    #[test]
    fn metadata_with_a_byte_too_many_or_too_few_is_none() {
        let mut body = Vec::new();
        let text = |t: &str, body: &mut Vec<u8>| {
            body.extend_from_slice(&(t.len() as u32).to_le_bytes());
            body.extend_from_slice(t.as_bytes());
        };
        text("heft", &mut body);
        let mut pairs = Vec::new();
        text("a", &mut pairs);
        text("b", &mut pairs);
        body.extend_from_slice(&(pairs.len() as u32).to_le_bytes());
        body.extend_from_slice(&pairs);
        assert_eq!(metadata(&body).expect("whole").1["a"], "b");
        assert_eq!(metadata(&body[..body.len() - 1]), None);
        body.push(0);
        assert_eq!(metadata(&body), None);
    }
}
