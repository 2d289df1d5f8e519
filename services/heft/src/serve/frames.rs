//! Protocol between the router and its shards: kind, length, bytes; numbers little-endian.

use std::io::{self, Read, Write};

use messages::{Message, NumberType, Value};

/// A sample of a machine: its number, then the fields of the message; without fields the machine is removed.
pub const SAMPLE: u8 = b'S';
/// To a shard: request for its state. From a shard: the state.
pub const STATE: u8 = b'C';
/// The row of the estimate of a sample: the machine's number, the flags of the estimate, the row; an empty row means none.
pub const ROW: u8 = b'E';
/// In place of a row: the machine of this number was removed.
pub const GONE: u8 = b'-';
/// The failure that ends a shard.
pub const FAULT: u8 = b'!';

/// Longest accepted frame \[bytes\]: states of a hundred thousand machines.
pub const LONGEST: usize = 1 << 31;

/// Writes a frame; one that is too long is refused before its first byte.
pub fn write(out: &mut impl Write, kind: u8, parts: &[&[u8]]) -> io::Result<()> {
    let length: usize = parts.iter().map(|p| p.len()).sum();
    let short = u32::try_from(length).ok().filter(|_| length <= LONGEST);
    let short = short.ok_or(io::ErrorKind::InvalidInput)?;
    out.write_all(&[kind])?;
    out.write_all(&short.to_le_bytes())?;
    parts.iter().try_for_each(|part| out.write_all(part))
}

/// Reads a frame into `into` and returns its kind; `None` at the end of the input.
pub fn read(input: &mut impl Read, into: &mut Vec<u8>) -> io::Result<Option<u8>> {
    let mut kind = [0];
    if input.read(&mut kind)? == 0 {
        return Ok(None);
    }
    let mut length = [0; 4];
    input.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length) as usize;
    if length > LONGEST {
        return Err(io::ErrorKind::InvalidData.into());
    }
    into.resize(length, 0);
    input.read_exact(into)?;
    Ok(Some(kind[0]))
}

/// A message as bytes: its fields in their order, eight bytes each.
pub fn pack<M: Message>(message: &M, into: &mut Vec<u8>) {
    into.clear();
    for index in 0..M::FIELDS.len() {
        let bits = match message.get(index) {
            Some(Value::U32(v)) => u64::from(v),
            Some(Value::U64(v)) => v,
            Some(Value::F64(v)) => v.to_bits(),
            None => 0,
        };
        into.extend_from_slice(&bits.to_le_bytes());
    }
}

/// The message in bytes of [`pack`].
pub fn unpack<M: Message>(bytes: &[u8]) -> M {
    let mut message = M::default();
    let (words, _) = bytes.as_chunks::<8>();
    for (index, (field, word)) in M::FIELDS.iter().zip(words).enumerate() {
        let bits = u64::from_le_bytes(*word);
        let value = match field.kind {
            NumberType::U32 => Value::U32(bits as u32),
            NumberType::U64 => Value::U64(bits),
            NumberType::F64 => Value::F64(f64::from_bits(bits)),
        };
        message.set(index, value);
    }
    message
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::ExcavatorSensors;

    #[test]
    fn what_is_written_is_read() {
        let mut sample = ExcavatorSensors::default();
        sample.stamp.machine = 7;
        sample.stamp.sequence = u64::MAX;
        sample.swing_velocity = -0.0;
        sample.valid = 3;
        let (mut bytes, mut out) = (Vec::new(), Vec::new());
        pack(&sample, &mut bytes);
        write(&mut out, SAMPLE, &[&7_u32.to_le_bytes(), &bytes]).unwrap();
        let mut input = out.as_slice();
        let mut got = Vec::new();
        assert_eq!(read(&mut input, &mut got).unwrap(), Some(SAMPLE));
        let back: ExcavatorSensors = unpack(&got[4..]);
        assert_eq!(back, sample);
        assert_eq!(back.swing_velocity.to_bits(), (-0.0_f64).to_bits());
        assert_eq!(read(&mut input, &mut got).unwrap(), None);
        assert!(read(&mut &out[..9], &mut got).is_err(), "cut off");
    }

    #[test]
    fn a_frame_longer_than_its_length_can_say_is_refused() {
        let part = vec![0; 1 << 20];
        let parts = |count| vec![part.as_slice(); count];
        let mut out = Vec::new();
        // 4 GiB and one part: the length would be that of the part.
        assert!(write(&mut out, STATE, &parts((1 << 12) + 1)).is_err());
        assert!(write(&mut out, STATE, &parts((1 << 11) + 1)).is_err());
        assert!(out.is_empty());
        assert!(write(&mut io::sink(), STATE, &parts(1 << 11)).is_ok());
    }
}
