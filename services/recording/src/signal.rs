//! The signals of each machine: the targets of columns, map entries and CAN signals.

use std::collections::VecDeque;

use messages::channels::ChannelOf;
use messages::{Machine, Message, NumberType, Value};

use sheet::Presence;

/// The sensors of a machine whose samples can be read.
pub trait Sensors: Message {
    /// Their truth.
    type Truth: Message;
    /// Which machine.
    const MACHINE: Machine;
    /// Channel of the samples.
    const SENSORS: &'static ChannelOf<Self>;
    /// Channel of the truth.
    const TRUTH: &'static ChannelOf<Self::Truth>;
    /// The source must have one signal of each group.
    const REQUIRED: &'static [&'static [&'static str]];
    /// Its signals.
    const SIGNALS: &'static [sheet::Signal];
    /// Sensors that count as present only if a value comes within the first second.
    const OPTIONAL: u32 = sheet::bits(Self::SIGNALS, Presence::Observed) | Self::ONE_OF;
    /// Of these, those of the header count as present if none has an early value.
    const ONE_OF: u32 = sheet::bits(Self::SIGNALS, Presence::OneOf);
}

/// Destination of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Slot {
    /// Time of the sample.
    Time,
    /// Field of the sensors, and its bit.
    Sensor(usize, u32),
    /// Bit of the sensors alone.
    Flag(u32),
    /// Field of the truth, and its bit.
    Truth(usize, u32),
}

/// A signal.
#[derive(Debug, Clone)]
pub(crate) struct Signal {
    /// Name, as in the CSV.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    slot: Slot,
}

impl Signal {
    /// A whole turn of an angle, after which it is the same; infinite for other signals.
    pub(crate) fn turn(&self) -> f64 {
        match self.unit {
            "rad" => core::f64::consts::TAU,
            _ => f64::INFINITY,
        }
    }

    /// Whether it is a switch, on or off.
    pub(crate) fn is_switch(&self) -> bool {
        matches!(self.slot, Slot::Flag(_))
    }

    /// Whether it is a number measured by a sensor.
    pub(crate) fn is_measured(&self) -> bool {
        matches!(self.slot, Slot::Sensor(..))
    }
}

/// All signals of a machine, the time first.
pub(crate) fn signals<S: Sensors>() -> Vec<Signal> {
    let time = Signal {
        name: "t".into(),
        unit: "s",
        slot: Slot::Time,
    };
    let sensors = measured::<S>().map(|(index, bit)| Signal {
        name: S::FIELDS[index].name.into(),
        unit: S::FIELDS[index].unit,
        slot: Slot::Sensor(index, bit),
    });
    let switches = S::SIGNALS.iter().filter(|s| s.is_switch);
    let flags = switches.map(|s| Signal {
        name: s.name.into(),
        unit: s.unit,
        slot: Slot::Flag(s.bit),
    });
    let truth = truths::<S::Truth>().map(|(index, bit)| Signal {
        name: format!("true_{}", S::Truth::FIELDS[index].name),
        unit: S::Truth::FIELDS[index].unit,
        slot: Slot::Truth(index, bit),
    });
    core::iter::once(time)
        .chain(sensors)
        .chain(flags)
        .chain(truth)
        .collect()
}

macro_rules! signals_of {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The same for a machine that is known at run time only.
        pub(crate) fn signals_of(machine: Machine) -> Vec<Signal> {
            match machine {
                $( Machine::$machine => signals::<messages::$sensors>(), )*
            }
        }
    };
}

messages::machines!(signals_of);

/// Index and bit of each true value: bit i is field i.
fn truths<M: Message>() -> impl Iterator<Item = (usize, u32)> {
    let numbers = M::FIELDS.iter().enumerate().skip(messages::HEAD);
    let known = numbers.filter(|(_, field)| field.kind == NumberType::F64);
    known.zip(0..).map(|((index, _), bit)| (index, 1 << bit))
}

/// Index and bit of each measured field of a sensor message.
pub fn measured<S: Sensors>() -> impl Iterator<Item = (usize, u32)> {
    let numbers = S::SIGNALS.iter().filter(|s| !s.is_switch);
    numbers.filter_map(|s| Some((S::index(s.name)?, s.bit)))
}

/// A row of samples with its truth.
pub type Row<S> = (S, <S as Sensors>::Truth);

/// Number of rows after which the columns are settled even if the time never advances.
const MOST_UNSETTLED: usize = 100_000;

/// Makes messages of rows of values.
#[derive(Debug)]
pub(crate) struct Builder<S: Sensors> {
    slots: Vec<Slot>,
    /// Fields of the bits that are set in every row.
    valid: Option<usize>,
    known: Option<usize>,
    has: Option<usize>,
    /// Rows that were not taken yet.
    rows: VecDeque<Row<S>>,
    count: u64,
    /// Bits of the signals of the source, once they are settled; until then, those that had a value.
    columns: Option<u32>,
    seen: u32,
    /// Time of the first row that has one.
    start: Option<f64>,
}

impl<S: Sensors> Builder<S> {
    /// For rows with the values of these signals, in this order. The signals that the source really has are
    /// settled by the first second, or as soon as each had a value.
    pub(crate) fn new<'a>(signals: impl IntoIterator<Item = &'a Signal>) -> Self {
        Self {
            slots: signals.into_iter().map(|s| s.slot).collect(),
            valid: S::index("valid"),
            known: S::Truth::index("known"),
            has: S::index("columns"),
            rows: VecDeque::new(),
            count: 0,
            columns: None,
            seen: 0,
            start: None,
        }
    }

    /// As [`Builder::new`]; all of these signals count as present, even if they have no values at first.
    pub(crate) fn with_all<'a>(signals: impl IntoIterator<Item = &'a Signal>) -> Self {
        let mut builder = Self::new(signals);
        builder.columns = Some(builder.header());
        builder
    }

    /// Number of rows up to now.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// Continues to count rows from this number.
    pub(crate) fn go_on_from(&mut self, count: u64) {
        self.count = count;
    }

    fn header(&self) -> u32 {
        self.slots.iter().fold(0, |bits, slot| match slot {
            Slot::Sensor(_, bit) | Slot::Flag(bit) => bits | bit,
            _ => bits,
        })
    }

    /// Adds a row; a value that is not finite is missing.
    pub(crate) fn push(&mut self, values: &[f64], measured_ns: u64) {
        let (mut sensors, mut truth) = (S::default(), S::Truth::default());
        let (mut valid, mut known) = (0, 0);
        sensors.stamp_mut().time = f64::NAN;
        for (slot, value) in self.slots.iter().zip(values) {
            match slot {
                Slot::Time => sensors.stamp_mut().time = *value,
                _ if !value.is_finite() => {}
                Slot::Sensor(index, bit) => {
                    sensors.set(*index, Value::F64(*value));
                    valid |= bit;
                }
                Slot::Flag(bit) => valid |= if *value != 0.0 { *bit } else { 0 },
                Slot::Truth(index, bit) => {
                    truth.set(*index, Value::F64(*value));
                    known |= bit;
                }
            }
        }
        sensors.stamp_mut().sequence = self.count;
        sensors.stamp_mut().measured_ns = measured_ns;
        self.count += 1;
        *truth.stamp_mut() = *sensors.stamp();
        set(&mut sensors, self.valid, valid);
        set(&mut truth, self.known, known);
        self.settle(sensors.stamp().time, valid);
        if let Some(columns) = self.columns {
            set(&mut sensors, self.has, columns);
        }
        self.rows.push_back((sensors, truth));
    }

    /// The next row, as soon as its columns are settled.
    pub(crate) fn next(&mut self) -> Option<Row<S>> {
        self.columns?;
        self.rows.pop_front()
    }

    /// No more rows will come: the waiting ones can be taken.
    pub(crate) fn finish(&mut self) {
        if self.columns.is_none() {
            self.settle_now();
        }
    }

    /// Settles the columns at the first row after a second, and before if no later row can change them.
    fn settle(&mut self, time: f64, valid: u32) {
        if self.columns.is_some() {
            return;
        }
        if time.is_finite() && time >= *self.start.get_or_insert(time) + 1.0
            || self.rows.len() >= MOST_UNSETTLED
        {
            self.settle_now();
            return;
        }
        self.seen |= valid;
        if self.header() & S::OPTIONAL & !self.seen == 0 {
            self.settle_now();
        }
    }

    /// The columns with a value up to now, and those that need none.
    fn settle_now(&mut self) {
        let header = self.header();
        let mut columns = header & (!S::OPTIONAL | self.seen);
        if columns & S::ONE_OF == 0 {
            columns |= header & S::ONE_OF;
        }
        self.columns = Some(columns);
        for (sensors, _) in &mut self.rows {
            set(sensors, self.has, columns);
        }
    }
}

fn set<M: Message>(message: &mut M, field: Option<usize>, bits: u32) {
    if let Some(index) = field {
        message.set(index, Value::U32(bits));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorSensors, LoaderSensors, excavator_bits, loader_bits};

    #[test]
    fn rows_wait_for_a_second_only_if_a_column_has_no_value_yet() {
        let all = signals::<ExcavatorSensors>();
        let named = |name: &str| all.iter().find(|s| s.name == name).expect("a signal");
        let names = ["t", "swing_velocity", "boom_angle"];
        let mut rows = Builder::<ExcavatorSensors>::new(names.map(named));
        rows.push(&[0.0, 0.1, f64::NAN], 0);
        assert!(rows.next().is_none(), "the boom may have an angle yet");
        rows.push(&[0.01, 0.1, 0.5], 0);
        let first = rows.next().expect("a row").0;
        assert_ne!(first.columns & excavator_bits::BOOM_ANGLE, 0);
        let mut rows = Builder::<ExcavatorSensors>::new(names.map(named));
        rows.push(&[0.0, 0.1, f64::NAN], 0);
        rows.push(&[1.0, 0.1, 0.5], 0);
        let first = rows.next().expect("a row").0;
        assert_eq!(first.columns & excavator_bits::BOOM_ANGLE, 0);
    }

    #[test]
    fn the_bits_are_those_of_the_messages() {
        let bit = |signals: &[Signal], name: &str| {
            signals.iter().find(|s| s.name == name).map(|s| s.slot)
        };
        let excavator = signals::<ExcavatorSensors>();
        let is = |slot: Option<Slot>, bit: u32| matches!(slot, Some(Slot::Sensor(_, b) | Slot::Flag(b)) if b == bit);
        assert!(is(
            bit(&excavator, "swing_velocity"),
            excavator_bits::SWING_VELOCITY
        ));
        assert!(is(
            bit(&excavator, "bucket_angle"),
            excavator_bits::BUCKET_ANGLE
        ));
        let loader = signals::<LoaderSensors>();
        assert!(is(bit(&loader, "slope"), loader_bits::SLOPE));
        assert!(is(
            bit(&loader, "spade_force_z"),
            loader_bits::SPADE_FORCE_Z
        ));
        assert!(is(bit(&loader, "boom_moving"), loader_bits::BOOM_MOVING));
        assert!(is(bit(&loader, "articulation"), loader_bits::ARTICULATION));
        assert!(is(bit(&loader, "yaw_rate"), loader_bits::YAW_RATE));
        assert!(is(bit(&loader, "brake"), loader_bits::BRAKE));
        assert!(matches!(
            bit(&loader, "true_slope"),
            Some(Slot::Truth(_, 0x80))
        ));
        assert!(bit(&loader, "true_known").is_none());
    }
}
