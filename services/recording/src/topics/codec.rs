//! Decoders of the messages of a topic.

use std::borrow::Cow;
use std::io::Read;

use super::node::Node;
use super::proto::Descriptors;
use super::ros::Definitions;
use crate::file::LIMIT;
use crate::kind::ZSTD;
use crate::record::{Channel, Schema};

/// The encoding of a topic's messages.
#[derive(Debug)]
pub(crate) enum Codec {
    Json,
    Cdr(Definitions),
    Ros1(Definitions),
    Protobuf(Descriptors),
}

impl Codec {
    /// The codec of a channel.
    ///
    /// # Errors
    /// The encoding is not supported: why.
    pub(crate) fn of(channel: &Channel, schema: Option<&Schema>) -> Result<Self, String> {
        let no_schema = || format!("{} has no schema", channel.topic);
        let definitions = |wanted: &str| {
            let schema = schema.ok_or_else(no_schema)?;
            if schema.encoding != wanted {
                return Err(format!(
                    "the schema of {} is {}, not {wanted}",
                    channel.topic, schema.encoding
                ));
            }
            let text = String::from_utf8_lossy(&schema.data);
            Definitions::parse(&schema.name, &text)
                .ok_or_else(|| format!("the definition of {} is not complete", schema.name))
        };
        match channel.encoding.as_str() {
            "json" => Ok(Self::Json),
            "cdr" => definitions("ros2msg").map(Self::Cdr),
            "ros1" => definitions("ros1msg").map(Self::Ros1),
            "protobuf" => {
                let schema = schema.ok_or_else(no_schema)?;
                Descriptors::parse(&schema.name, &schema.data)
                    .map(Self::Protobuf)
                    .ok_or_else(|| format!("the schema has no message {}", schema.name))
            }
            other => Err(format!(
                "{} is encoded as {other}; heft reads json, cdr, ros1 and protobuf",
                channel.topic
            )),
        }
    }

    /// A message as a tree; `None` if it is malformed.
    pub(crate) fn decode(&self, message: &[u8]) -> Option<Node> {
        match self {
            Self::Json => serde_json::from_slice(message)
                .or_else(|_| serde_json::from_slice(&finite(message)))
                .ok()
                .map(json),
            Self::Cdr(types) => types.cdr(&unpacked(message)?),
            Self::Ros1(types) => types.ros1(message),
            Self::Protobuf(types) => types.decode(message),
        }
    }
}

/// A message that rosbag2 compressed by itself (`--compression-mode message`), decompressed; no CDR begins as zstd does.
fn unpacked(message: &[u8]) -> Option<Cow<'_, [u8]>> {
    if !message.starts_with(ZSTD) {
        return Some(message.into());
    }
    let mut bytes = Vec::new();
    let decoder = ruzstd::decoding::StreamingDecoder::new(message).ok()?;
    decoder.take(LIMIT).read_to_end(&mut bytes).ok()?;
    Some(bytes.into())
}

/// JSON with `NaN` and `Infinity`, which Python and JavaScript libraries write for missing numbers, replaced by null.
fn finite(message: &[u8]) -> Vec<u8> {
    const WORDS: [&[u8]; 3] = [b"NaN", b"-Infinity", b"Infinity"];
    let (mut out, mut rest, mut is_text) = (Vec::with_capacity(message.len()), message, false);
    while let Some(first) = rest.first() {
        let word = WORDS.iter().find(|word| !is_text && rest.starts_with(word));
        let taken = match (word, first) {
            (Some(word), _) => word.len(),
            (None, b'\\') => 2.min(rest.len()),
            (None, _) => 1,
        };
        is_text ^= *first == b'"';
        out.extend_from_slice(word.map_or(&rest[..taken], |_| b"null"));
        rest = &rest[taken..];
    }
    out
}

fn json(value: serde_json::Value) -> Node {
    use serde_json::Value;
    match value {
        Value::Null => Node::Nothing,
        Value::Bool(x) => Node::Number(f64::from(u8::from(x))),
        Value::Number(x) => x.as_f64().map_or(Node::Nothing, Node::Number),
        Value::String(text) => Node::Text(text),
        Value::Array(list) => Node::List(list.into_iter().map(json).collect()),
        Value::Object(fields) => {
            let fields = fields.into_iter().map(|(name, v)| (name.into(), json(v)));
            Node::Record(fields.collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_that_was_packed_alone_is_unpacked() {
        use ruzstd::encoding::{CompressionLevel, compress_to_vec};
        let types = Definitions::parse("a/msg/B", "float64 x\n").expect("complete");
        let message = [&[0, 1, 0, 0], 2.5_f64.to_le_bytes().as_slice()].concat();
        let packed = compress_to_vec(message.as_slice(), CompressionLevel::Fastest);
        let codec = Codec::Cdr(types);
        let plain = codec.decode(&message).expect("whole");
        assert_eq!(codec.decode(&packed), Some(plain));
        assert_eq!(codec.decode(&packed[..packed.len() - 4]), None);
    }

    #[test]
    fn a_number_that_is_none_is_missing_and_the_others_stay() {
        let message = br#"{"a NaN": NaN, "b": 1.5, "c": [-Infinity, 2], "d": "\"NaN"}"#;
        let node = Codec::Json.decode(message).expect("whole");
        let mut numbers = Vec::new();
        node.numbers("", &mut |path, x| numbers.push((path.to_owned(), x)));
        assert_eq!(numbers, [("b".into(), 1.5), ("c[1]".into(), 2.0)]);
        assert_eq!(node.field("d"), Some(&Node::Text("\"NaN".into())));
        assert_eq!(Codec::Json.decode(b"{\"a\": nonsense}"), None);
    }
}
