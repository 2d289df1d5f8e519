//! A message outside a recording: the same bytes and the same schema, for who sends it elsewhere.

use messages::Message;

use crate::{schema, wire};

/// Appends the protobuf encoding of `message`, as recordings hold it, to `out`.
pub fn encode<M: Message>(message: &M, out: &mut Vec<u8>) {
    wire::encode(message, out);
}

/// The message that `bytes` encode; fields that this version does not know are left out. `None` if the
/// bytes are no message. The numbers in it may be anything, NaN too.
#[must_use]
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

/// Name of the protobuf message: `heft.Health`.
#[must_use]
pub fn name<M: Message>() -> String {
    schema::name::<M>()
}

/// Its schema: a serialised `FileDescriptorSet` with meaning and unit as comments.
#[must_use]
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
}
