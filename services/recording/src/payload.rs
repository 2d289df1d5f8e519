//! A message outside a recording: the same bytes and the same schema, for other channels of communication.

use std::io::{self, BufRead};

use messages::Message;

use crate::{schema, wire};

/// Appends the protobuf encoding of `message`, as recordings hold it, to `out`.
pub fn encode<M: Message>(message: &M, out: &mut Vec<u8>) {
    wire::encode(message, out);
}

/// The message that `bytes` encode; fields that this version does not know are ignored. `None` if the
/// bytes are no valid message. Its numbers may have any value, NaN included.
pub fn decode<M: Message>(bytes: &[u8]) -> Option<M> {
    let mut message = M::default();
    wire::decode(bytes, |number, scalar| {
        let index = usize::try_from(number).ok().and_then(|n| n.checked_sub(1));
        if let Some((index, field)) = index.and_then(|i| Some((i, M::FIELDS.get(i)?))) {
            message.set(index, scalar.value(field.kind));
        }
    })?;
    Some(message)
}

/// Appends `bytes` with their length before them (varint), as protobuf delimits messages.
pub fn put_delimited(bytes: &[u8], out: &mut Vec<u8>) {
    wire::put_varint(bytes.len() as u64, out);
    out.extend_from_slice(bytes);
}

/// Removes a message of [`put_delimited`] from the front of `bytes`; `None` if it is incomplete.
pub fn take_delimited<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
    let mut rest = *bytes;
    let length = usize::try_from(wire::take_varint(&mut rest)?).ok()?;
    let (taken, rest) = rest.split_at_checked(length)?;
    *bytes = rest;
    Some(taken)
}

/// Reads a message of [`put_delimited`]; false at the end of the input.
///
/// # Errors
/// The input cannot be read, ends within the message, or holds more than `most` bytes.
pub fn read_delimited(
    input: &mut impl BufRead,
    most: usize,
    into: &mut Vec<u8>,
) -> io::Result<bool> {
    into.clear();
    if input.fill_buf()?.is_empty() {
        return Ok(false);
    }
    // The input may end within the length: one byte at a time, ten at most.
    let length = loop {
        let mut byte = [0];
        input.read_exact(&mut byte)?;
        into.push(byte[0]);
        if byte[0] & 0x80 == 0 || into.len() == 10 {
            break wire::take_varint(&mut into.as_slice());
        }
    };
    let length = length.and_then(|n| usize::try_from(n).ok());
    let length = length.filter(|n| *n <= most);
    let length = length.ok_or(io::ErrorKind::InvalidData)?;
    into.resize(length, 0);
    input.read_exact(into)?;
    Ok(true)
}

/// Name of the protobuf message: `heft.Health`.
pub fn name<M: Message>() -> String {
    schema::name::<M>()
}

/// Its schema: a serialised `FileDescriptorSet` with meaning and unit as comments.
pub fn schema<M: Message>() -> Vec<u8> {
    schema::bytes::<M>()
}

#[cfg(test)]
mod tests {
    use messages::ExcavatorEstimate;

    use super::*;

    #[test]
    fn a_message_comes_back_as_it_was_and_broken_bytes_do_not() {
        let mut message = ExcavatorEstimate {
            inertia: 5873.25,
            offset: -0.0,
            flags: u32::MAX,
            refused: u64::MAX,
            ..Default::default()
        };
        message.stamp.sequence = 1 << 40;
        let mut bytes = Vec::new();
        encode(&message, &mut bytes);
        assert_eq!(decode(&bytes), Some(message));
        assert_eq!(decode::<ExcavatorEstimate>(&bytes[..bytes.len() - 1]), None);
        assert_eq!(
            decode::<ExcavatorEstimate>(&[0, 0]),
            Some(Default::default())
        );
    }

    #[test]
    fn what_is_delimited_is_taken_back_piece_by_piece() {
        let (long, mut bytes) = (vec![7; 300], Vec::new());
        for piece in [b"ex-17".as_slice(), b"", &long] {
            put_delimited(piece, &mut bytes);
        }
        let (mut rest, mut input) = (bytes.as_slice(), bytes.as_slice());
        let mut got = Vec::new();
        for piece in [b"ex-17".as_slice(), b"", &long] {
            assert_eq!(take_delimited(&mut rest), Some(piece));
            assert!(read_delimited(&mut input, 300, &mut got).expect("memory"));
            assert_eq!(got, piece);
        }
        assert_eq!(take_delimited(&mut rest), None);
        assert!(!read_delimited(&mut input, 300, &mut got).expect("the end"));
    }

    #[test]
    fn what_is_cut_off_or_too_long_is_not_taken() {
        let (mut bytes, mut got) = (Vec::new(), Vec::new());
        put_delimited(&[7; 300], &mut bytes);
        for cut in 1..bytes.len() {
            assert_eq!(take_delimited(&mut &bytes[..cut]), None, "{cut}");
            assert!(read_delimited(&mut &bytes[..cut], 300, &mut got).is_err());
        }
        assert!(read_delimited(&mut bytes.as_slice(), 299, &mut got).is_err());
        assert!(read_delimited(&mut [0xff; 20].as_slice(), 300, &mut got).is_err());
        assert_eq!(take_delimited(&mut [0xff; 20].as_slice()), None);
    }
}
