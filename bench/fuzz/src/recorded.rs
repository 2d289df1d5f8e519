//! Targets: recordings of arbitrary bytes, and complete recordings of extreme numbers with their report.

use std::fs;
use std::path::Path;

use messages::channels::{self, Channel, Visitor};
use messages::{HEAD, Machine, Message, NumberType, Value};
use recording::{Metadata, Reader, Writer};

use crate::write;

/// Reads a file of these bytes, and the file that `recover` writes from it.
pub fn mcap(input: &[u8]) {
    write("x.mcap", input);
    let _ = fs::remove_file("x.recovered.mcap");
    let _ = page_of("x.mcap");
    let copy = Path::new("x.recovered.mcap");
    if recording::recover("x.mcap", Some(copy)).is_ok() && copy.exists() {
        let _ = page_of("x.recovered.mcap");
    }
}

/// Writes a complete recording of the numbers in the input, and its report.
pub fn report(input: &[u8]) {
    record("x.mcap", &Wild::new(input));
    let page = page_of("x.mcap").expect("a whole recording");
    assert!(!page.contains("NaN"), "a number that is none in the report");
}

/// Reads everything, up to the report.
fn page_of(file: &str) -> Result<String, recording::Error> {
    let reader = Reader::open(file)?;
    for channel in reader.channels() {
        let _ = reader.for_each_value(channel, |_, _| ());
    }
    let _ = reader.counts();
    view::Run::from_recording(&reader).map(|run| view::report(&run))
}

/// Plausible messages with changed fields. The input has a byte for the machine, one for the number
/// of rows, then twelve for each change.
pub struct Wild {
    /// The machine.
    pub machine: Machine,
    /// Number of messages on each channel.
    pub rows: u64,
    changes: Vec<Change>,
}

/// Row (from 128 on: all rows), channel, field, kind, and the value in eight bytes.
#[derive(Clone, Copy)]
struct Change([u8; 4], [u8; 8]);

impl Wild {
    pub fn new(input: &[u8]) -> Self {
        let (head, rest) = input.split_first_chunk().unwrap_or((&[0, 0], &[]));
        let change = |[row, channel, field, kind, value @ ..]: &[u8; 12]| {
            Change([*row, *channel, *field, *kind], *value)
        };
        Self {
            machine: Machine::ALL[usize::from(head[0]) % Machine::ALL.len()],
            rows: u64::from(head[1]),
            changes: rest.as_chunks().0.iter().map(change).collect(),
        }
    }

    /// Message number `row` of the channel with index `channel`.
    pub fn message<M: Message>(&self, channel: usize, row: u64) -> M {
        let mut message = M::default();
        for (index, field) in M::FIELDS.iter().enumerate() {
            message.set(index, plausible(field.kind, index, row));
        }
        message.stamp_mut().machine = 0;
        message.stamp_mut().sequence = row;
        message.stamp_mut().time = 0.02 * row as f64;
        for Change([at, of, field, kind], value) in &self.changes {
            let field = usize::from(*field) % M::FIELDS.len();
            if usize::from(*of) == channel && (*at >= 128 || u64::from(*at) == row) {
                message.set(field, wild(M::FIELDS[field].kind, *kind, *value));
            }
        }
        message
    }
}

/// Numbers of a moving machine; all bits are set.
fn plausible(kind: NumberType, index: usize, row: u64) -> Value {
    match kind {
        NumberType::U32 => Value::U32(if index < HEAD { 0 } else { u32::MAX }),
        NumberType::U64 => Value::U64(1_000_000_000 + 20_000_000 * row),
        NumberType::F64 => Value::F64(1.5 + (0.1 * row as f64 + index as f64).sin()),
    }
}

/// The bits of `value`, or one of the numbers that often cause errors.
fn wild(kind: NumberType, choice: u8, value: [u8; 8]) -> Value {
    const NUMBERS: [f64; 8] = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN_POSITIVE,
        -0.0,
        -1.0,
        1e9,
    ];
    let bits = u64::from_le_bytes(value);
    match kind {
        NumberType::U32 => Value::U32(bits as u32),
        NumberType::U64 => Value::U64(bits),
        NumberType::F64 if choice < 128 => Value::F64(NUMBERS[usize::from(choice) % NUMBERS.len()]),
        NumberType::F64 => Value::F64(f64::from_bits(bits)),
    }
}

/// Writes the messages into a recording.
fn record(file: &str, wild: &Wild) {
    let _ = fs::remove_file(file);
    let metadata: Metadata = [
        ("machine", wild.machine.name()),
        ("processes", "sensor,kalman,rls,ukf,logger"),
    ]
    .map(|(k, v)| (k.to_owned(), v.to_owned()))
    .into();
    let mut writer = Writer::create(file, &metadata).expect("room for a recording");
    for row in 0..wild.rows {
        for (number, channel) in channels::of_machine(wild.machine).enumerate() {
            channel.payload.visit(Write {
                row,
                number,
                channel,
                wild,
                writer: &mut writer,
            });
        }
        if row % 16 == 15 {
            writer.flush().expect("room for a recording");
        }
    }
    writer.finish().expect("room for a recording");
}

struct Write<'a> {
    row: u64,
    number: usize,
    channel: &'a Channel,
    wild: &'a Wild,
    writer: &'a mut Writer,
}

impl Visitor for Write<'_> {
    type Output = ();

    fn visit<M: Message>(self) {
        let message: M = self.wild.message(self.number, self.row);
        let written = self.writer.write(self.channel, &message);
        written.expect("room for a message");
    }
}

/// A complete recording of each machine.
pub fn recordings() -> Vec<Vec<u8>> {
    let recording = |machine: u8| {
        let file = std::env::temp_dir().join(format!("fuzz-{}.mcap", std::process::id()));
        record(&file.to_string_lossy(), &Wild::new(&[machine, 39]));
        let bytes = fs::read(&file).expect("just written");
        let _ = fs::remove_file(&file);
        bytes
    };
    [0, 1].map(recording).into()
}

/// Asserts that every number is finite. The stamp and the hops before them come from the source, and are not checked.
pub fn assert_finite<M: Message>(message: &M) {
    for (index, field) in M::FIELDS.iter().enumerate().skip(HEAD) {
        if let Some(Value::F64(value)) = message.get(index) {
            assert!(value.is_finite(), "{} is {value}", field.name);
        }
    }
}
