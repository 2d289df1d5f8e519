//! The protobuf encoding of a message, made from its table of fields: field i has number i + 1,
//! `f64` is `double`, the counts are varints. A field whose bits are all zero is left out, as
//! proto3 does; minus zero and NaN keep their bits.

use messages::{Message, NumberType, Value};

const VARINT: u64 = 0;
const FIXED64: u64 = 1;
const BYTES: u64 = 2;
const FIXED32: u64 = 5;

/// Appends the encoding of `message` to `out`.
pub(crate) fn encode<M: Message>(message: &M, out: &mut Vec<u8>) {
    for index in 0..M::FIELDS.len() {
        let number = index as u64 + 1;
        match message.get(index) {
            Some(Value::U32(v)) => put_count(number, u64::from(v), out),
            Some(Value::U64(v)) => put_count(number, v, out),
            Some(Value::F64(v)) if v.to_bits() != 0 => {
                put_varint(number << 3 | FIXED64, out);
                out.extend_from_slice(&v.to_bits().to_le_bytes());
            }
            _ => {}
        }
    }
}

fn put_count(number: u64, value: u64, out: &mut Vec<u8>) {
    if value != 0 {
        put_varint(number << 3 | VARINT, out);
        put_varint(value, out);
    }
}

pub(crate) fn put_varint(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// A scalar on the wire, to be interpreted by its field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scalar(u64);

impl Scalar {
    /// An absent field.
    pub(crate) const ZERO: Self = Self(0);

    /// The value of a field of this kind.
    pub(crate) fn value(self, kind: NumberType) -> Value {
        match kind {
            NumberType::U32 => Value::U32(self.0 as u32),
            NumberType::U64 => Value::U64(self.0),
            NumberType::F64 => Value::F64(f64::from_bits(self.0)),
        }
    }
}

/// Calls `found` with number and value of each scalar field; `None` if the bytes are no valid message.
pub(crate) fn decode(mut bytes: &[u8], mut found: impl FnMut(u64, Scalar)) -> Option<()> {
    while !bytes.is_empty() {
        let tag = take_varint(&mut bytes)?;
        match tag & 7 {
            VARINT => found(tag >> 3, Scalar(take_varint(&mut bytes)?)),
            FIXED64 => {
                let (head, rest) = bytes.split_first_chunk::<8>()?;
                found(tag >> 3, Scalar(u64::from_le_bytes(*head)));
                bytes = rest;
            }
            BYTES => {
                let length = usize::try_from(take_varint(&mut bytes)?).ok()?;
                bytes = bytes.get(length..)?;
            }
            FIXED32 => bytes = bytes.get(4..)?,
            _ => return None,
        }
    }
    Some(())
}

pub(crate) fn take_varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (first, rest) = bytes.split_first()?;
        *bytes = rest;
        value |= u64::from(first & 0x7f) << shift;
        if first & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use messages::ExcavatorTruth;

    use super::*;

    #[test]
    fn the_bytes_are_those_of_the_protobuf_specification() {
        let mut out = Vec::new();
        put_varint(300, &mut out);
        assert_eq!(out, [0xac, 0x02]); // the example of the protobuf documentation
        let mut message = ExcavatorTruth::default();
        message.stamp.machine = 150;
        message.inertia = 1.0;
        out.clear();
        encode(&message, &mut out);
        assert_eq!(out[..3], [0x08, 0x96, 0x01]);
        let tag = (ExcavatorTruth::index("inertia").expect("a field") as u8 + 1) << 3 | 1;
        assert_eq!(out[3..], [tag, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f]); // double 1.0
    }

    #[test]
    fn unknown_fields_are_skipped_and_broken_bytes_are_refused() {
        let mut seen = Vec::new();
        let bytes = [0x1a, 2, 9, 9, 0x15, 1, 2, 3, 4, 0x08, 5];
        assert!(decode(&bytes, |n, v| seen.push((n, v))).is_some());
        assert_eq!(seen, [(1, Scalar(5))]);
        for cut in [1, 3, 6, 10] {
            assert!(decode(&bytes[..cut], |_, _| ()).is_none(), "cut at {cut}");
        }
        assert!(decode(&[0xff; 11], |_, _| ()).is_none());
    }
}
