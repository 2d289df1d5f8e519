//! Protobuf schemas from and to the tables of fields.

use messages::{Entry, Field, Message, NumberType, Words};
use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::source_code_info::Location;
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto,
    FileDescriptorProto, FileDescriptorSet, SourceCodeInfo,
};

/// Full name of the protobuf message of a payload.
pub(crate) fn name<M: Message>() -> String {
    format!("heft.{}", M::NAME)
}

/// The schema of a payload: a serialised `FileDescriptorSet` with meaning and unit as comments.
pub(crate) fn bytes<M: Message>() -> Vec<u8> {
    let file = FileDescriptorProto {
        name: Some(format!("heft/{}.proto", M::NAME)),
        package: Some("heft".into()),
        message_type: vec![DescriptorProto {
            name: Some(M::NAME.into()),
            field: M::FIELDS.iter().zip(1..).map(descriptor::<M>).collect(),
            ..Default::default()
        }],
        enum_type: codes::<M>().map(enumeration).collect(),
        source_code_info: Some(SourceCodeInfo {
            location: M::FIELDS.iter().zip(0..).map(comment).collect(),
        }),
        syntax: Some("proto3".into()),
        ..Default::default()
    };
    FileDescriptorSet { file: vec![file] }.encode_to_vec()
}

/// The fields that hold codes: the name of the enum, that of the field, the codes.
fn codes<M: Message>() -> impl Iterator<Item = (String, &'static str, &'static [Entry])> {
    M::WORDS.iter().filter_map(|(field, words)| match words {
        Words::Codes(entries) => {
            let (first, rest) = field.split_at(1);
            let name = format!("{}{}{rest}", M::NAME, first.to_uppercase());
            Some((name, *field, *entries))
        }
        Words::Bits(_) => None,
    })
}

/// An enum with the names of every output, in capitals, prefixed as protobuf requires.
fn enumeration(
    (name, field, entries): (String, &'static str, &'static [Entry]),
) -> EnumDescriptorProto {
    let value = |entry: &Entry| {
        let of = match entry.name {
            "" => "NONE".to_owned(),
            name => name.to_uppercase().replace(['-', ' '], "_"),
        };
        EnumValueDescriptorProto {
            name: Some(format!("{}_{of}", field.to_uppercase())),
            number: i32::try_from(entry.number).ok(),
            ..Default::default()
        }
    };
    EnumDescriptorProto {
        name: Some(name),
        value: entries.iter().map(value).collect(),
        ..Default::default()
    }
}

fn descriptor<M: Message>((field, number): (&Field, i32)) -> FieldDescriptorProto {
    let named = codes::<M>().find(|(_, of, _)| *of == field.name);
    let kind = match field.kind {
        _ if named.is_some() => Type::Enum,
        NumberType::U32 => Type::Uint32,
        NumberType::U64 => Type::Uint64,
        NumberType::F64 => Type::Double,
    };
    FieldDescriptorProto {
        name: Some(field.name.into()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        type_name: named.map(|(name, ..)| format!(".heft.{name}")),
        json_name: Some(field.name.into()),
        ..Default::default()
    }
}

/// The comment of field `index` of the first message (path 4, 0, 2, index).
fn comment((field, index): (&Field, i32)) -> Location {
    let unit = if field.unit.is_empty() {
        String::new()
    } else {
        format!(" Unit: {}.", field.unit)
    };
    Location {
        path: vec![4, 0, 2, index],
        span: vec![index + 4, 2, 3],
        leading_comments: Some(format!(" {}{unit}\n", field.doc.trim())),
        ..Default::default()
    }
}

/// A field of a recorded schema.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedField {
    /// Name.
    pub name: String,
    /// Unit, "" if none is stated.
    pub unit: String,
    /// Type.
    pub kind: NumberType,
    /// Number on the wire.
    pub(crate) number: u64,
}

/// The scalar fields of message `name` in a serialised `FileDescriptorSet`; `None` if there is no such message.
pub(crate) fn fields(name: &str, bytes: &[u8]) -> Option<Vec<RecordedField>> {
    let set = FileDescriptorSet::decode(bytes).ok()?;
    let short = name.rsplit('.').next()?;
    for file in &set.file {
        for (at, message) in file.message_type.iter().enumerate() {
            if message.name() == short {
                let units = Units { file, at };
                let fields = message.field.iter().enumerate();
                return Some(
                    fields
                        .filter_map(|(i, f)| recorded(f, units.of(i)))
                        .collect(),
                );
            }
        }
    }
    None
}

fn recorded(field: &FieldDescriptorProto, unit: String) -> Option<RecordedField> {
    let kind = match field.r#type() {
        Type::Uint32 | Type::Enum => NumberType::U32,
        Type::Uint64 => NumberType::U64,
        Type::Double => NumberType::F64,
        _ => return None,
    };
    Some(RecordedField {
        name: field.name().to_owned(),
        unit,
        kind,
        number: u64::try_from(field.number()).ok()?,
    })
}

struct Units<'a> {
    file: &'a FileDescriptorProto,
    at: usize,
}

impl Units<'_> {
    /// Unit in the comment of field `index`.
    fn of(&self, index: usize) -> String {
        let locations = self.file.source_code_info.iter().flat_map(|i| &i.location);
        let path = [4, self.at as i32, 2, index as i32];
        let comment = locations
            .filter(|l| l.path == path)
            .find_map(|l| l.leading_comments.as_ref());
        let unit = comment
            .and_then(|c| c.rsplit_once("Unit: "))
            .map(|(_, unit)| unit.trim());
        unit.map_or_else(String::new, |u| u.trim_end_matches('.').to_owned())
    }
}

#[cfg(test)]
mod tests {
    use messages::{ExcavatorSensors, Health};

    use super::*;

    #[test]
    fn a_schema_reads_back_as_the_table_of_fields() {
        let read =
            fields("heft.ExcavatorSensors", &bytes::<ExcavatorSensors>()).expect("it is there");
        assert_eq!(read.len(), ExcavatorSensors::FIELDS.len());
        for (i, (read, field)) in read.iter().zip(ExcavatorSensors::FIELDS).enumerate() {
            assert_eq!(
                (read.name.as_str(), read.unit.as_str()),
                (field.name, field.unit)
            );
            assert_eq!((read.kind, read.number), (field.kind, i as u64 + 1));
        }
        assert_eq!(fields("heft.Health", &bytes::<ExcavatorSensors>()), None);
        assert_eq!(fields("heft.Health", &[9, 9, 9]), None);
        assert!(fields("heft.Health", &bytes::<Health>()).is_some());
    }
}
