//! Recordings of other versions: fields are found by name, not by number or place.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use messages::ExcavatorTruth;
use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use recording::Reader;

fn field(name: &str, number: i32, kind: Type) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.into()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        ..Default::default()
    }
}

/// A recording of an `ExcavatorTruth` with these fields and a message for each of these bytes.
fn write(path: &Path, fields: Vec<FieldDescriptorProto>, messages: &[&[u8]]) {
    let message = DescriptorProto {
        name: Some("ExcavatorTruth".into()),
        field: fields,
        ..Default::default()
    };
    let file = FileDescriptorProto {
        name: Some("old.proto".into()),
        message_type: vec![message],
        ..Default::default()
    };
    let schema = FileDescriptorSet { file: vec![file] }.encode_to_vec();
    let out = BufWriter::new(File::create(path).expect("a file"));
    let mut writer = mcap::Writer::new(out).expect("a writer");
    let id = writer
        .add_schema("heft.ExcavatorTruth", "protobuf", &schema)
        .expect("a schema");
    let id = writer
        .add_channel(id, "excavator/truth", "protobuf", &BTreeMap::new())
        .expect("a channel");
    for (sequence, data) in (0..).zip(messages) {
        let header = mcap::records::MessageHeader {
            channel_id: id,
            sequence,
            log_time: 5,
            publish_time: 5,
        };
        writer.write_to_known_channel(&header, data).expect("room");
    }
    writer.finish().expect("room");
}

#[test]
fn renumbered_unknown_missing_and_widened_fields_are_put_where_they_belong() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("old.mcap");
    let fields = vec![
        field("payload", 2, Type::Double),
        field("colour", 3, Type::String), // no longer, or not yet, known
        field("sequence", 1, Type::Uint32), // 32 bits then, 64 bits now
    ];
    let mut data = vec![0x08, 7, 0x1a, 3, b'r', b'e', b'd', 0x11];
    data.extend_from_slice(&288.0_f64.to_le_bytes());
    write(&path, fields, &[&data]);
    let reader = Reader::open(&path).expect("a recording");
    let read: Vec<ExcavatorTruth> = reader.messages("excavator/truth").expect("the channel");
    let mut expected = ExcavatorTruth {
        payload: 288.0,
        ..Default::default()
    };
    expected.stamp.sequence = 7;
    assert_eq!(read, [expected]);
}

#[test]
fn a_message_that_is_not_whole_is_left_out_and_reported() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("broken.mcap");
    let payload = || vec![field("payload", 2, Type::Double)];
    let whole = [&[0x11][..], &288.0_f64.to_le_bytes()].concat();
    write(&path, payload(), &[&whole, &[0x11, 0, 0]]);
    let reader = Reader::open(&path).expect("a recording");
    let read: Vec<ExcavatorTruth> = reader.messages("excavator/truth").expect("the channel");
    assert_eq!(read.len(), 1);
    assert!(reader.damage()[0].contains("a damaged message"));
    let recovered = recording::recover(&path, None).expect("recoverable");
    assert!(
        !recovered.was_complete && recovered.messages == 1,
        "recover agrees with the readers: {recovered}"
    );

    // Without a complete message there is nothing to copy, and no file is created.
    let path = dir.path().join("nothing.mcap");
    write(&path, payload(), &[&[0x11, 0, 0]]);
    let refused = recording::recover(&path, None).expect_err("an empty copy helps nobody");
    assert!(refused.to_string().contains("no message"), "{refused}");
    assert!(!dir.path().join("nothing.recovered.mcap").exists());
}
