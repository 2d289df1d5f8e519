//! The signals of each machine: what a column, a map entry or a CAN signal can become.

use messages::{
    ExcavatorSensors, ExcavatorTruth, Kind, LoaderSensors, LoaderTruth, Message, Value,
    excavator_bits, loader_bits,
};

/// A machine whose samples can be read.
pub(crate) trait Machine {
    /// What its sensors measure.
    type Sensors: Message;
    /// The truth behind it.
    type Truth: Message;
    /// Name on the command line.
    const NAME: &'static str;
    /// Of each group, the source must have one.
    const REQUIRED: &'static [&'static [&'static str]];
    /// Signals that are only a bit of `valid`.
    const FLAGS: &'static [(&'static str, u32)];
    /// Signals that count as present only if a value comes within the first second.
    const OPTIONAL: u32;
    /// Of these, those of the header count as present where none has an early value.
    const ONE_OF: u32;
}

/// The excavator.
pub(crate) struct Excavator;

impl Machine for Excavator {
    type Sensors = ExcavatorSensors;
    type Truth = ExcavatorTruth;
    const NAME: &'static str = "excavator";
    const REQUIRED: &'static [&'static [&'static str]] = &[&["swing_velocity", "swing_angle"]];
    const FLAGS: &'static [(&'static str, u32)] = &[];
    const ONE_OF: u32 = excavator_bits::SWING_VELOCITY | excavator_bits::SWING_ANGLE;
    const OPTIONAL: u32 = Self::ONE_OF
        | excavator_bits::SWING_TORQUE
        | excavator_bits::BOOM_ANGLE
        | excavator_bits::ARM_ANGLE
        | excavator_bits::BUCKET_ANGLE;
}

/// The wheel loader.
pub(crate) struct Loader;

impl Machine for Loader {
    type Sensors = LoaderSensors;
    type Truth = LoaderTruth;
    const NAME: &'static str = "loader";
    const REQUIRED: &'static [&'static [&'static str]] = &[
        &["speed"],
        &["front_wheel_speed"],
        &["rear_wheel_speed"],
        &["front_torque"],
        &["rear_torque"],
        &["slope"],
    ];
    const FLAGS: &'static [(&'static str, u32)] = &[
        ("boom_moving", loader_bits::BOOM_MOVING),
        ("brake", loader_bits::BRAKE),
    ];
    const ONE_OF: u32 = 0;
    const OPTIONAL: u32 = 0;
}

/// Where a signal goes.
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

/// All signals of a machine, the time first.
pub(crate) fn signals<M: Machine>() -> Vec<Signal> {
    let time = Signal {
        name: "t".into(),
        unit: "s",
        slot: Slot::Time,
    };
    let sensors = own::<M::Sensors>(M::FLAGS).map(|(index, bit)| Signal {
        name: M::Sensors::FIELDS[index].name.into(),
        unit: M::Sensors::FIELDS[index].unit,
        slot: Slot::Sensor(index, bit),
    });
    let flags = M::FLAGS.iter().map(|(name, bit)| Signal {
        name: (*name).into(),
        unit: "",
        slot: Slot::Flag(*bit),
    });
    let truth = own::<M::Truth>(&[]).map(|(index, bit)| Signal {
        name: format!("true_{}", M::Truth::FIELDS[index].name),
        unit: M::Truth::FIELDS[index].unit,
        slot: Slot::Truth(index, bit),
    });
    core::iter::once(time)
        .chain(sensors)
        .chain(flags)
        .chain(truth)
        .collect()
}

/// Index and bit of each measured field of a message; a bit that is a flag's is passed over.
fn own<M: Message>(flags: &[(&str, u32)]) -> impl Iterator<Item = (usize, u32)> {
    let taken = flags.iter().fold(0, |bits, (_, bit)| bits | bit);
    let free = (0..u32::BITS)
        .map(|i| 1u32 << i)
        .filter(move |bit| bit & taken == 0);
    let numbers = M::FIELDS.iter().enumerate().skip(messages::HEAD);
    let measured = numbers.filter(|(_, field)| field.kind == Kind::F64);
    measured.zip(free).map(|((index, _), bit)| (index, bit))
}

/// Bit of the sensor signal called `name`, of whichever machine; 0 if there is none.
pub(crate) fn sensor_bit(name: &str) -> u32 {
    let all = signals::<Excavator>()
        .into_iter()
        .chain(signals::<Loader>());
    let mut found = all.filter(|s| s.name == name).filter_map(|s| match s.slot {
        Slot::Sensor(_, bit) => Some(bit),
        _ => None,
    });
    found.next().unwrap_or(0)
}

/// A row of samples with the truth behind it.
pub(crate) type Row<M> = (<M as Machine>::Sensors, <M as Machine>::Truth);

/// Makes messages of rows of values.
pub(crate) struct Builder<M: Machine> {
    slots: Vec<Slot>,
    rows: Vec<Row<M>>,
}

impl<M: Machine> Builder<M> {
    /// Rows will have the values of these signals, in this order.
    pub(crate) fn new<'a>(signals: impl IntoIterator<Item = &'a Signal>) -> Self {
        Self {
            slots: signals.into_iter().map(|s| s.slot).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row; a value that is not finite is missing.
    pub(crate) fn push(&mut self, values: &[f64]) {
        let (mut sensors, mut truth) = (M::Sensors::default(), M::Truth::default());
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
        sensors.stamp_mut().sequence = self.rows.len() as u64;
        *truth.stamp_mut() = *sensors.stamp();
        set(&mut sensors, "valid", valid);
        set(&mut truth, "known", known);
        self.rows.push((sensors, truth));
    }

    /// All rows, with the bits of the signals that the source has.
    pub(crate) fn finish(mut self) -> Vec<Row<M>> {
        let header = self.slots.iter().fold(0, |bits, slot| match slot {
            Slot::Sensor(_, bit) | Slot::Flag(bit) => bits | bit,
            _ => bits,
        });
        let mut columns = header & (!M::OPTIONAL | self.seen_early());
        if columns & M::ONE_OF == 0 {
            columns |= header & M::ONE_OF;
        }
        for (sensors, _) in &mut self.rows {
            set(sensors, "columns", columns);
        }
        self.rows
    }

    /// Bits of the signals that have a value within the first second.
    fn seen_early(&self) -> u32 {
        let times = || self.rows.iter().map(|(s, _)| s.stamp().time);
        let end = times().find(|t| t.is_finite()).unwrap_or(0.0) + 1.0;
        let early = self
            .rows
            .iter()
            .take_while(|(s, _)| s.stamp().time.is_nan() || s.stamp().time < end);
        early.fold(0, |bits, (sensors, _)| bits | valid(sensors))
    }
}

fn valid<M: Message>(message: &M) -> u32 {
    match M::index("valid").and_then(|i| message.get(i)) {
        Some(Value::U32(bits)) => bits,
        _ => 0,
    }
}

fn set<M: Message>(message: &mut M, name: &str, bits: u32) {
    if let Some(index) = M::index(name) {
        message.set(index, Value::U32(bits));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bits_are_those_of_the_messages() {
        let bit = |signals: &[Signal], name: &str| {
            signals.iter().find(|s| s.name == name).map(|s| s.slot)
        };
        let excavator = signals::<Excavator>();
        let is = |slot: Option<Slot>, bit: u32| matches!(slot, Some(Slot::Sensor(_, b) | Slot::Flag(b)) if b == bit);
        assert!(is(
            bit(&excavator, "swing_velocity"),
            excavator_bits::SWING_VELOCITY
        ));
        assert!(is(
            bit(&excavator, "bucket_angle"),
            excavator_bits::BUCKET_ANGLE
        ));
        let loader = signals::<Loader>();
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
