//! How the messages of a topic are read.

use super::node::Node;
use super::proto::Descriptors;
use super::ros::Definitions;
use crate::record::{Channel, Schema};

/// How the messages of a topic are read.
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
    /// heft does not read it: why.
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

    /// A message as a tree; `None` if it is not whole.
    pub(crate) fn decode(&self, message: &[u8]) -> Option<Node> {
        match self {
            Self::Json => serde_json::from_slice(message).ok().map(json),
            Self::Cdr(types) => types.cdr(message),
            Self::Ros1(types) => types.ros1(message),
            Self::Protobuf(types) => types.decode(message),
        }
    }
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
