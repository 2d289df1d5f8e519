//! Description of a field for readers without knowledge of heft: name, unit, type, value; and the fields that every message
//! begins with.

use crate::{Hops, Stamp};

/// Type of a field of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberType {
    /// Unsigned 32-bit number; bits or an index.
    U32,
    /// Unsigned 64-bit number; a count or a time in nanoseconds.
    U64,
    /// Double-precision number in the field's unit.
    F64,
}

/// Value of a field of a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// See [`NumberType::U32`].
    U32(u32),
    /// See [`NumberType::U64`].
    U64(u64),
    /// See [`NumberType::F64`].
    F64(f64),
}

impl Value {
    /// The value as a double, for plots. Counts above 2^53 lose their last bits.
    pub fn as_f64(self) -> f64 {
        match self {
            Self::U32(v) => f64::from(v),
            Self::U64(v) => v as f64,
            Self::F64(v) => v,
        }
    }

    /// Whether both have the same type and the same bits (NaN equals itself, 0 differs from -0).
    pub fn same_bits(self, other: Self) -> bool {
        match (self, other) {
            (Self::F64(a), Self::F64(b)) => a.to_bits() == b.to_bits(),
            (a, b) => a == b,
        }
    }
}

/// Description of a field for a reader without knowledge of heft.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    /// Name, as in the CSV and in the recording.
    pub name: &'static str,
    /// SI unit, "" for bits and pure numbers.
    pub unit: &'static str,
    /// Its meaning in one sentence.
    pub doc: &'static str,
    /// Type.
    pub kind: NumberType,
}

/// Number of fields that [`Stamp`] and [`Hops`] put before those of the message itself.
pub const HEAD: usize = 10;

pub(crate) const HEAD_FIELDS: [Field; HEAD] = [
    field("machine", "", "Which machine.", NumberType::U32),
    field(
        "epoch",
        "",
        "Restarts of the source before this sample.",
        NumberType::U32,
    ),
    field(
        "sequence",
        "",
        "Number of the sample, from 0.",
        NumberType::U64,
    ),
    field(
        "t",
        "s",
        "Time of the measurement, by the clock of the data.",
        NumberType::F64,
    ),
    field(
        "measured_ns",
        "ns",
        "Time of the measurement, host monotonic clock.",
        NumberType::U64,
    ),
    field(
        "sensor_ns",
        "ns",
        "Published by the sensor process.",
        NumberType::U64,
    ),
    field(
        "filter_ns",
        "ns",
        "Published by the filter stage, 0 if none.",
        NumberType::U64,
    ),
    field(
        "estimate_ns",
        "ns",
        "Published by the estimator, 0 if none.",
        NumberType::U64,
    ),
    field(
        "filter_restarts",
        "",
        "Restarts of the filter stage before this.",
        NumberType::U32,
    ),
    field(
        "estimate_restarts",
        "",
        "Restarts of the estimator before this.",
        NumberType::U32,
    ),
];

const fn field(
    name: &'static str,
    unit: &'static str,
    doc: &'static str,
    kind: NumberType,
) -> Field {
    Field {
        name,
        unit,
        doc,
        kind,
    }
}

pub(crate) fn get_head(stamp: &Stamp, hops: &Hops, index: usize) -> Value {
    match index {
        0 => Value::U32(stamp.machine),
        1 => Value::U32(stamp.epoch),
        2 => Value::U64(stamp.sequence),
        3 => Value::F64(stamp.time),
        4 => Value::U64(stamp.measured_ns),
        5 => Value::U64(hops.sensor_ns),
        6 => Value::U64(hops.filter_ns),
        7 => Value::U64(hops.estimate_ns),
        8 => Value::U32(hops.filter_restarts),
        _ => Value::U32(hops.estimate_restarts),
    }
}

pub(crate) fn set_head(stamp: &mut Stamp, hops: &mut Hops, index: usize, value: Value) -> bool {
    match (index, value) {
        (0, Value::U32(v)) => stamp.machine = v,
        (1, Value::U32(v)) => stamp.epoch = v,
        (2, Value::U64(v)) => stamp.sequence = v,
        (3, Value::F64(v)) => stamp.time = v,
        (4, Value::U64(v)) => stamp.measured_ns = v,
        (5, Value::U64(v)) => hops.sensor_ns = v,
        (6, Value::U64(v)) => hops.filter_ns = v,
        (7, Value::U64(v)) => hops.estimate_ns = v,
        (8, Value::U32(v)) => hops.filter_restarts = v,
        (9, Value::U32(v)) => hops.estimate_restarts = v,
        _ => return false,
    }
    true
}

/// Type of a field, from its Rust type.
pub(crate) trait FieldType: Copy {
    const KIND: NumberType;
    fn wrap(self) -> Value;
    fn unwrap(value: Value) -> Option<Self>;
}

macro_rules! field_type {
    ($($type:ty => $kind:ident),*) => {$(
        impl FieldType for $type {
            const KIND: NumberType = NumberType::$kind;
            fn wrap(self) -> Value { Value::$kind(self) }
            fn unwrap(value: Value) -> Option<Self> {
                match value { Value::$kind(v) => Some(v), _ => None }
            }
        }
    )*};
}
field_type!(u32 => U32, u64 => U64, f64 => F64);

/// The fields of the head followed by those of one message.
pub(crate) const fn join<const N: usize>(own: &[Field]) -> [Field; N] {
    let mut all = [HEAD_FIELDS[0]; N];
    let mut i = 0;
    while i < N {
        all[i] = if i < HEAD {
            HEAD_FIELDS[i]
        } else {
            own[i - HEAD]
        };
        i += 1;
    }
    all
}
