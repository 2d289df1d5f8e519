//! Estimates and loads as CAN frames: one frame per quantity with its standard deviation, and a frame of flags for
//! estimates and for loads. A quantity that is not trusted is sent as "not available", so that a receiver cannot use it by mistake. The
//! content of the bucket is always sent: its standard deviation covers all uncertainty.
//!
//! | bytes of a quantity | meaning |
//! |---|---|
//! | 0-3 | value, 32 bits, least significant byte first, in the resolution of the table |
//! | 4-7 | its standard deviation, in the same form, without an offset |
//!
//! A flag has two bits, as in J1939: 0 no, 1 yes. Whole numbers follow the flags, last the code of the reason.

mod dbc;
mod map;
mod page;
mod table;

use std::path::Path;

use messages::channels::Channel;
use messages::{Envelope, Machine, fnv32};

use self::map::Parser;
pub(crate) use self::table::{FrameTable, flags, quantities};
use self::table::{Number, Quantity};
use super::Frame;
use super::node::{Name, Node};
use crate::{Error, machines};

/// "Not available" (J1939-71) in every byte.
const NOT_AVAILABLE: u32 = u32::MAX;
/// Largest valid value: the larger ones mean "error" and "not available".
const LARGEST: f64 = 0xfaff_ffff_u32 as f64;

/// The frames of a machine's estimates, by an output map.
///
/// ```toml
/// [can]
/// rate = 10         # of each frame a second, at most
/// source = 0x80     # J1939 source address that is claimed
/// priority = 6
/// channel = "excavator/inertia_ukf"
/// [can.frames]      # those to send, each with its parameter group (proprietary B) ...
/// inertia = 0xff10
/// verdict = { id = 0x321 }   # ... or with an identifier of 11 bits
/// [can.name]        # the NAME with which the address is claimed
/// identity = 1234
/// ```
#[derive(Debug, Clone)]
pub struct Outgoing {
    machine: Machine,
    /// The channel that is sent.
    pub channel: &'static Channel,
    /// Least time between two frames of one kind \[s\].
    pub period: f64,
    /// The address that is claimed.
    source: u8,
    /// The NAME; without an identity if the map gives none.
    name: (Name, Option<u32>),
    kinds: Vec<Kind>,
}

/// A kind of frame.
#[derive(Debug, Clone)]
struct Kind {
    name: &'static str,
    /// The channel of its content.
    channel: &'static Channel,
    id: u32,
    extended: bool,
    content: Content,
}

#[derive(Debug, Clone)]
enum Content {
    /// Positions of value and standard deviation among the fields, and the row of the table.
    Quantity([usize; 2], &'static Quantity),
    /// Flags, and numbers with their positions among the fields.
    Flags(
        &'static [(&'static str, u32)],
        Vec<(usize, &'static Number)>,
    ),
}

/// Position of a field in the messages of a channel.
fn position(channel: &Channel, field: &str) -> usize {
    // A missing field reads as "not available".
    channel.payload.shape().index(field).unwrap_or(usize::MAX)
}

impl Outgoing {
    /// The frames of `machine`, all of them in proprietary B ten times a second without a map.
    ///
    /// # Errors
    /// The map cannot be read, or names a frame or channel that does not exist.
    pub fn new(machine: Machine, map: Option<&Path>) -> Result<Self, Error> {
        let table = machines::of(machine).frames;
        let Some(path) = map else {
            return Parser::new(table, "", Path::new("")).outgoing();
        };
        let text = std::fs::read_to_string(path)
            .map_err(|e| Error::system("read the output map", path, &e))?;
        Parser::new(table, &text, path).outgoing()
    }

    /// The channels of the frames' contents.
    pub fn channels(&self) -> Vec<&'static Channel> {
        let mut all: Vec<&'static Channel> = Vec::new();
        for channel in self.kinds.iter().map(|k| k.channel) {
            if all.iter().all(|c| c.name != channel.name) {
                all.push(channel);
            }
        }
        all
    }

    /// The frames of a message of one of its channels, at `time_ns` on `interface`.
    pub fn frames<'a>(
        &self,
        message: &Envelope,
        time_ns: i64,
        interface: &'a str,
    ) -> impl Iterator<Item = Frame<'a>> {
        let kinds = self.kinds.iter();
        let its = kinds.filter(|kind| kind.channel.payload == message.payload());
        its.filter_map(move |kind| {
            let data = kind.content.data(kind.channel, message);
            let (id, extended) = (kind.id, kind.extended);
            Frame::new(time_ns, interface, id, extended, &data.to_le_bytes())
        })
    }

    /// The node of J1939 that sends these frames; none if all have identifiers of 11 bits. If the map gives no
    /// identity, it is derived from the name of the `computer` and the machine.
    pub fn node(&self, computer: &[u8]) -> Option<Node> {
        let (name, own) = self.name;
        let identity = own.unwrap_or_else(|| identity(computer, self.machine));
        let groups: Vec<u32> = self.kinds.iter().filter_map(Kind::group).collect();
        let is_node = !groups.is_empty();
        is_node.then(|| Node::new(Name { identity, ..name }, self.source, groups))
    }

    /// The same frames from another source address.
    pub fn from(&self, source: u8) -> Self {
        let mut other = self.clone();
        for kind in other.kinds.iter_mut().filter(|k| k.extended) {
            kind.id = kind.id & !0xff | u32::from(source);
        }
        other
    }
}

/// A number of 21 bits that no other node is likely to have (FNV-1a).
fn identity(computer: &[u8], machine: Machine) -> u32 {
    let hash = fnv32(&[computer, machine.name().as_bytes()].concat());
    (hash ^ hash >> 21) & 0x1f_ffff
}

impl Content {
    /// The eight bytes, the first one lowest.
    fn data(&self, channel: &Channel, message: &Envelope) -> u64 {
        let bits = |name: &'static str| {
            let value = message.get(position(channel, name));
            value.map_or(0, |v| v.as_f64() as u32)
        };
        let flags = bits("flags");
        match self {
            Self::Quantity(at, row) => {
                let has = |bits: u32, all: u32| all == 0 || bits & all == all;
                let estimated = row.estimated == 0 || bits("estimated") & row.estimated != 0;
                let transmitted = has(flags, row.trusted) && estimated;
                let [value, std] = at.map(|i| message.get(i).map(messages::Value::as_f64));
                let value = value.and_then(|v| raw((v - row.offset) / row.scale));
                let std = std.and_then(|s| raw(s / row.scale));
                let both = value.zip(std).filter(|_| transmitted);
                let (value, std) = both.unwrap_or((NOT_AVAILABLE, NOT_AVAILABLE));
                u64::from(value) | u64::from(std) << 32
            }
            Self::Flags(all, numbers) => {
                let mut data = u64::MAX;
                for (i, (_, flag)) in all.iter().enumerate() {
                    data &= !(0b11 << (2 * i)) | u64::from(flags & flag != 0) << (2 * i);
                }
                for (at, number) in numbers {
                    let value = message.get(*at).map(|v| v.as_f64() as u64);
                    if let Some(value) = value.filter(|v| *v <= number.largest()) {
                        let mask = (1_u64 << number.bits) - 1;
                        data &= !(mask << number.at) | value << number.at;
                    }
                }
                data
            }
        }
    }
}

impl Kind {
    /// Identifier in a DBC, which marks 29 bits by the topmost bit.
    fn dbc_id(&self) -> u32 {
        self.id | if self.extended { 1 << 31 } else { 0 }
    }

    /// Its parameter group, if it has one.
    fn group(&self) -> Option<u32> {
        self.extended.then_some(self.id >> 8 & 0x3_ffff)
    }
}

/// The nearest number of 32 bits; `None` if that is no valid value.
fn raw(value: f64) -> Option<u32> {
    (0.0..=LARGEST)
        .contains(&value.round())
        .then(|| value.round() as u32)
}

#[cfg(test)]
mod tests {
    use super::super::dbc::{Dbc, Reading};
    use super::table::{LOADS, LOADS_NUMBERS};
    use super::*;
    use messages::{
        ExcavatorEstimate, ExcavatorLoads, LoaderEstimate, Message, SIMULATED, excavator_bits as e,
        loader_bits as l, loads_bits as b,
    };

    #[test]
    fn every_quantity_names_fields_of_its_messages() {
        for table in Machine::ALL.map(|m| machines::of(m).frames) {
            for (channel, row) in table
                .channels
                .iter()
                .flat_map(|c| table.quantities.iter().map(move |q| (c, q)))
            {
                for field in [row.field, row.std_field, "flags", "estimated"] {
                    assert_ne!(
                        position(channel, field),
                        usize::MAX,
                        "{field} of {}",
                        channel.name
                    );
                }
            }
            let fields = LOADS.iter().flat_map(|row| [row.field, row.std_field]);
            for field in fields.chain(LOADS_NUMBERS.iter().map(|n| n.field)) {
                assert_ne!(position(table.loads, field), usize::MAX, "{field}");
            }
        }
    }

    /// The frames of an estimate as our own reader of DBC files decodes them.
    fn read_back(outgoing: &Outgoing, estimate: &Envelope) -> Vec<(String, Reading, f64)> {
        let dbc = Dbc::parse(
            &Outgoing::dbc(std::slice::from_ref(outgoing)),
            Path::new("out.dbc"),
        )
        .expect("a DBC");
        let mut found = Vec::new();
        for frame in outgoing.frames(estimate, 0, "can0") {
            let is_its = |m: &&super::super::dbc::Message| m.matches(frame.id, frame.extended);
            let message = dbc.messages.iter().find(is_its).expect("its message");
            for signal in &message.signals {
                let place = message.place(signal).expect("a place");
                let half = 0.5 * signal.layout.scale;
                found.push((signal.name.clone(), place.read(frame.data()), half));
            }
        }
        found
    }

    fn value<'a>(found: &'a [(String, Reading, f64)], name: &str) -> (&'a Reading, f64) {
        let row = found.iter().find(|(n, _, _)| n == name);
        row.map(|(_, r, half)| (r, *half)).expect("the signal")
    }

    #[test]
    fn a_trusted_estimate_is_read_back_within_half_a_bit() {
        let outgoing = Outgoing::new(Machine::Excavator, None).expect("the usual frames");
        for n in 0..200 {
            let x = f64::from(n);
            let estimate = ExcavatorEstimate {
                inertia: 1234.5678 * x,
                inertia_std: 0.777 * x,
                payload: 31.4159 * x - 500.0,
                payload_std: 12.3456 + x,
                flags: e::TRUSTED | e::FRESH | SIMULATED,
                estimated: e::INERTIA | e::PAYLOAD,
                ..ExcavatorEstimate::default()
            };
            let found = read_back(&outgoing, &estimate.envelope());
            for (name, wanted) in [
                ("inertia", estimate.inertia),
                ("inertia_std", estimate.inertia_std),
                ("payload", estimate.payload),
                ("payload_std", estimate.payload_std),
                ("trusted", 1.0),
                ("fresh", 1.0),
                ("simulated", 1.0),
                ("excited", 0.0),
            ] {
                let (Reading::Value(got), half) = value(&found, name) else {
                    panic!("{name} is not there");
                };
                // With the rounding of a double near the offset.
                assert!(
                    (got - wanted).abs() <= half * 1.000_001,
                    "{name}: {got} for {wanted}"
                );
            }
            let damping = value(&found, "damping").0;
            assert!(matches!(damping, Reading::Missing), "not estimated");
        }
    }

    #[test]
    fn what_is_not_trusted_or_has_no_place_is_not_available() {
        let outgoing = Outgoing::new(Machine::Loader, None).expect("the usual frames");
        let mut estimate = LoaderEstimate {
            cg_height: 1.2,
            cg_height_std: 0.1,
            cg_ratio: 0.4,
            cg_ratio_std: 0.01,
            flags: l::TRUSTED_RATIO,
            estimated: l::STATE,
            ..LoaderEstimate::default()
        };
        let found = read_back(&outgoing, &estimate.envelope());
        assert!(matches!(value(&found, "cg_height").0, Reading::Missing));
        assert!(matches!(value(&found, "cg_height_std").0, Reading::Missing));
        assert!(matches!(value(&found, "cg_ratio").0, Reading::Value(r) if (r - 0.4).abs() < 1e-6));
        for wrong in [f64::NAN, f64::INFINITY, -1.0, 1e9] {
            estimate.cg_ratio = wrong;
            let found = read_back(&outgoing, &estimate.envelope());
            assert!(
                matches!(value(&found, "cg_ratio").0, Reading::Missing),
                "{wrong}"
            );
        }
    }

    #[test]
    fn a_bucket_is_reported_always_a_load_and_its_truck_where_they_are_trusted() {
        let outgoing = Outgoing::new(Machine::Excavator, None).expect("the usual frames");
        let mut loads = ExcavatorLoads {
            payload: 812.5,
            payload_std: 90.25,
            payload_age: 3.2,
            mass: 800.0,
            mass_std: 40.0,
            truck_mass: 9_100.0,
            truck_mass_std: 300.0,
            target: 9_000.0,
            remaining: -100.0,
            load: 12,
            truck: 2,
            ..ExcavatorLoads::default()
        };
        let transmitted = |loads: &ExcavatorLoads, name| match value(
            &read_back(&outgoing, &loads.envelope()),
            name,
        )
        .0
        {
            Reading::Value(value) => Some((value * 100.0).round() / 100.0),
            _ => None,
        };
        assert_eq!(transmitted(&loads, "payload"), Some(812.5));
        assert_eq!(transmitted(&loads, "payload_std"), Some(90.25));
        assert_eq!(
            (transmitted(&loads, "load"), transmitted(&loads, "truck")),
            (Some(12.0), Some(2.0))
        );
        assert_eq!(transmitted(&loads, "payload_age"), Some(3.0));
        for name in ["mass", "truck_mass", "remaining"] {
            assert_eq!(transmitted(&loads, name), None, "{name} is not trusted");
        }
        loads.flags = b::TRUSTED | b::TRUCK_TRUSTED;
        assert_eq!(transmitted(&loads, "mass"), Some(800.0));
        assert_eq!(transmitted(&loads, "truck_mass"), Some(9_100.0));
        assert_eq!(
            transmitted(&loads, "remaining"),
            None,
            "nobody said a target"
        );
        loads.flags |= b::HAS_TARGET;
        assert_eq!(transmitted(&loads, "remaining"), Some(-100.0));
        loads.payload_age = sheet::loads::NEVER;
        assert_eq!(transmitted(&loads, "payload_age"), None, "never weighed");
        assert_eq!(outgoing.frames(&loads.envelope(), 0, "can0").count(), 5);
    }

    fn with_map(text: &str) -> Result<Outgoing, Error> {
        Parser::new(
            machines::of(Machine::Excavator).frames,
            text,
            Path::new("out.toml"),
        )
        .outgoing()
    }

    #[test]
    fn a_map_chooses_frames_and_identifiers_and_its_mistakes_are_reported() {
        let text = "[can]\nrate = 5\nsource = 0x21\npriority = 3\n[can.frames]\ninertia = 0xff55\nverdict = { id = 0x321 }\n";
        let outgoing = with_map(text).expect("a map");
        let ids: Vec<(u32, bool)> = outgoing.kinds.iter().map(|k| (k.id, k.extended)).collect();
        assert_eq!(ids, [(0x0cff_5521, true), (0x321, false)]);
        assert!((outgoing.period - 0.2).abs() < 1e-12);
        for (wrong, word) in [
            ("[can]\nrate = 0\n", "rate"),
            ("[can]\nsource = 300\n", "source"),
            ("[cam]\n", "cam"),
            ("[can]\nchannel = \"loader/cg_ukf\"\n", "channel"),
            ("[can.frames]\ninertja = 0xff10\n", "inertja"),
            ("[can.frames]\ninertia = 0xfe10\n", "identifier"),
            (
                "[can.frames]\ninertia = 0xff10\nverdict = 0xff10\n",
                "one identifier",
            ),
            ("[can\n", "TOML"),
        ] {
            let error = with_map(wrong).expect_err(wrong);
            assert!(error.to_string().contains(word), "{wrong}: {error}");
        }
    }
}
