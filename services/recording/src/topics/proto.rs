//! Protobuf messages, by the descriptors in the file.

use std::collections::BTreeMap;
use std::rc::Rc;

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorSet};

use super::node::Node;
use crate::wire::take_varint;

/// Largest depth of nested messages.
const DEEPEST: usize = 32;

/// The messages of a schema.
#[derive(Debug)]
pub(crate) struct Descriptors {
    messages: BTreeMap<String, Vec<Field>>,
    main: String,
}

#[derive(Debug)]
struct Field {
    name: Rc<str>,
    number: u64,
    kind: Type,
    /// Full name of its message.
    message: String,
    is_list: bool,
    /// An absent number is 0 (proto3 without presence).
    is_zero: bool,
}

impl Descriptors {
    /// From a serialised `FileDescriptorSet`; `None` if it has no such message.
    pub(crate) fn parse(name: &str, bytes: &[u8]) -> Option<Self> {
        let set = FileDescriptorSet::decode(bytes).ok()?;
        let mut messages = BTreeMap::new();
        for file in &set.file {
            let is_3 = file.syntax() == "proto3";
            let package = Some(file.package()).filter(|p| !p.is_empty());
            let before = package.map_or(String::new(), |p| format!(".{p}"));
            for message in &file.message_type {
                add(&mut messages, &before, message, is_3, 0);
            }
        }
        let main = format!(".{}", name.trim_start_matches('.'));
        messages
            .contains_key(&main)
            .then_some(Self { messages, main })
    }

    /// Decodes a message; `None` if it is malformed.
    pub(crate) fn decode(&self, bytes: &[u8]) -> Option<Node> {
        self.message(&self.main, bytes, 0)
    }

    fn message(&self, name: &str, mut bytes: &[u8], depth: usize) -> Option<Node> {
        (depth < DEEPEST).then_some(())?;
        let fields = self.messages.get(name)?;
        let empty = |f: &Field| match f {
            f if f.is_list => Node::List(Vec::new()),
            f if f.is_zero => Node::Number(0.0),
            _ => Node::Nothing,
        };
        let mut found: Vec<Node> = fields.iter().map(empty).collect();
        while !bytes.is_empty() {
            let tag = take_varint(&mut bytes)?;
            let raw = Raw::take(&mut bytes, tag & 7)?;
            let Some(at) = fields.iter().position(|f| f.number == tag >> 3) else {
                continue;
            };
            let field = &fields[at];
            match (&mut found[at], raw) {
                (Node::List(list), Raw::Bytes(packed)) if is_number(field.kind) => {
                    let mut packed = packed;
                    while !packed.is_empty() {
                        let raw = Raw::take(&mut packed, wire(field.kind))?;
                        list.push(self.value(field, raw, depth)?);
                    }
                }
                (Node::List(list), raw) => list.push(self.value(field, raw, depth)?),
                (node, raw) => *node = self.value(field, raw, depth)?,
            }
        }
        let names = fields.iter().map(|f| Rc::clone(&f.name));
        Some(Node::Record(names.zip(found).collect()))
    }

    fn value(&self, field: &Field, raw: Raw<'_>, depth: usize) -> Option<Node> {
        let number = match (field.kind, raw) {
            (Type::Message, Raw::Bytes(bytes)) => {
                return self.message(&field.message, bytes, depth + 1);
            }
            (Type::String, Raw::Bytes(bytes)) => {
                return Some(Node::Text(String::from_utf8_lossy(bytes).into_owned()));
            }
            (Type::Double, Raw::Eight(v)) => f64::from_bits(v),
            (Type::Float, Raw::Four(v)) => f64::from(f32::from_bits(v)),
            (Type::Fixed64, Raw::Eight(v)) => v as f64,
            (Type::Sfixed64, Raw::Eight(v)) => v as i64 as f64,
            (Type::Fixed32, Raw::Four(v)) => f64::from(v),
            (Type::Sfixed32, Raw::Four(v)) => f64::from(v as i32),
            (Type::Sint32 | Type::Sint64, Raw::Varint(v)) => {
                ((v >> 1) as i64 ^ -((v & 1) as i64)) as f64
            }
            (Type::Int32 | Type::Int64 | Type::Enum, Raw::Varint(v)) => v as i64 as f64,
            (Type::Uint32 | Type::Uint64, Raw::Varint(v)) => v as f64,
            (Type::Bool, Raw::Varint(v)) => f64::from(u8::from(v != 0)),
            (Type::Bytes | Type::Group, _) => return Some(Node::Nothing),
            _ => return None,
        };
        Some(Node::Number(number))
    }
}

fn add(
    messages: &mut BTreeMap<String, Vec<Field>>,
    before: &str,
    message: &DescriptorProto,
    is_3: bool,
    depth: usize,
) {
    let name = format!("{before}.{}", message.name());
    let fields = message.field.iter().filter_map(|f| field(f, is_3));
    messages.insert(name.clone(), fields.collect());
    if depth < DEEPEST {
        for nested in &message.nested_type {
            add(messages, &name, nested, is_3, depth + 1);
        }
    }
}

fn field(field: &FieldDescriptorProto, is_3: bool) -> Option<Field> {
    let kind = field.r#type();
    let in_choice = field.oneof_index.is_some(); // also what proto3 calls optional
    Some(Field {
        name: field.name().into(),
        number: u64::try_from(field.number()).ok()?,
        kind,
        message: field.type_name().to_owned(),
        is_list: field.label() == Label::Repeated,
        is_zero: is_3 && is_number(kind) && !in_choice,
    })
}

fn is_number(kind: Type) -> bool {
    !matches!(
        kind,
        Type::Message | Type::String | Type::Bytes | Type::Group
    )
}

/// Wire type of a number.
fn wire(kind: Type) -> u64 {
    match kind {
        Type::Double | Type::Fixed64 | Type::Sfixed64 => 1,
        Type::Float | Type::Fixed32 | Type::Sfixed32 => 5,
        _ => 0,
    }
}

enum Raw<'a> {
    Varint(u64),
    Eight(u64),
    Four(u32),
    Bytes(&'a [u8]),
}

impl<'a> Raw<'a> {
    fn take(bytes: &mut &'a [u8], wire: u64) -> Option<Self> {
        match wire {
            0 => take_varint(bytes).map(Self::Varint),
            1 => {
                let (head, rest) = bytes.split_first_chunk::<8>()?;
                *bytes = rest;
                Some(Self::Eight(u64::from_le_bytes(*head)))
            }
            2 => {
                let length = usize::try_from(take_varint(bytes)?).ok()?;
                let (head, rest) = bytes.split_at_checked(length)?;
                *bytes = rest;
                Some(Self::Bytes(head))
            }
            5 => {
                let (head, rest) = bytes.split_first_chunk::<4>()?;
                *bytes = rest;
                Some(Self::Four(u32::from_le_bytes(*head)))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use messages::{ExcavatorTruth, Message as _};

    use super::*;
    use crate::topics::node::path;
    use crate::{schema, wire as own};

    #[test]
    fn a_message_of_heft_reads_as_its_descriptors_say() {
        let message = ExcavatorTruth {
            inertia: -1.5,
            known: 300,
            ..ExcavatorTruth::default()
        };
        let mut bytes = Vec::new();
        own::encode(&message, &mut bytes);
        let schema = schema::bytes::<ExcavatorTruth>();
        let types = Descriptors::parse("heft.ExcavatorTruth", &schema).expect("it is there");
        let node = types.decode(&bytes).expect("whole");
        let at = |name| node.number(&path(name).expect("a path"), None);
        assert_eq!(at("inertia"), Some(-1.5));
        assert_eq!(at("known"), Some(300.0));
        assert_eq!(at("damping"), Some(0.0), "left out by proto3");
        assert!(ExcavatorTruth::index("damping").is_some());
        assert_eq!(types.decode(&bytes[..bytes.len() - 1]), None);
        assert!(Descriptors::parse("heft.Other", &schema).is_none());
    }

    #[test]
    fn packed_lists_and_signs_are_read() {
        let field = |name: &str, number, kind, is_list| Field {
            name: name.into(),
            number,
            kind,
            message: String::new(),
            is_list,
            is_zero: false,
        };
        let fields = vec![
            field("v", 1, Type::Double, true),
            field("s", 2, Type::Sint32, false),
            field("i", 3, Type::Int32, false),
        ];
        let types = Descriptors {
            messages: BTreeMap::from([(".M".to_owned(), fields)]),
            main: ".M".into(),
        };
        let mut bytes = vec![0x0a, 16];
        bytes.extend(1.0_f64.to_le_bytes());
        bytes.extend(2.0_f64.to_le_bytes());
        bytes.extend([0x10, 3, 0x18]);
        own::put_varint((-7_i64) as u64, &mut bytes);
        let node = types.decode(&bytes).expect("whole");
        let at = |name| node.number(&path(name).expect("a path"), None);
        assert_eq!(at("v[1]"), Some(2.0));
        assert_eq!((at("s"), at("i")), (Some(-2.0), Some(-7.0)));
    }
}
