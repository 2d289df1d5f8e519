//! CAN databases: which signals a frame carries.

mod parse;

use std::path::Path;

use super::layout::Layout;
use crate::map::hint;
use crate::{Error, whole};

/// The messages of a DBC file.
#[derive(Debug, Default)]
pub(crate) struct Dbc {
    pub messages: Vec<Message>,
}

/// A message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Message {
    pub name: String,
    pub id: u32,
    pub extended: bool,
    /// A parameter group of SAE J1939: frames match by their group, whatever their priority, source
    /// and destination, and the largest values of a signal mean "not available".
    pub j1939: bool,
    /// Bytes, as the file states them.
    pub length: u32,
    pub signals: Vec<Signal>,
}

/// A signal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Signal {
    pub name: String,
    pub layout: Layout,
    /// Unit as the file writes it.
    pub unit: String,
    /// Range as the file writes it; 0, 0 if it states none.
    pub range: (f64, f64),
    /// Whether other signals depend on the value of this one.
    multiplexor: bool,
    /// The frame contains the signal only if this multiplexor has a value within one of the ranges.
    only_if: Option<Condition>,
}

#[derive(Debug, Clone, PartialEq)]
struct Condition {
    /// Name of the multiplexor; none: the only one of the message.
    multiplexor: Option<String>,
    values: Vec<(u64, u64)>,
}

/// Content of a frame for a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Reading {
    /// The frame does not contain it.
    Absent,
    /// The frame contains "not available".
    Missing,
    /// The value in the DBC's unit.
    Value(f64),
}

/// A signal with the conditions on which a frame contains it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Place {
    layout: Layout,
    conditions: Vec<(Layout, Vec<(u64, u64)>)>,
    j1939: bool,
}

impl Dbc {
    /// Reads the messages of a file; text that is not UTF-8 is taken as Latin-1.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let bytes = whole::read(path, "DBC file")?;
        let text = String::from_utf8(bytes)
            .unwrap_or_else(|e| e.as_bytes().iter().map(|b| char::from(*b)).collect());
        let dbc = Self::parse(&text, path)?;
        if dbc.messages.is_empty() {
            return Err(Error::new(
                "there is no message in the DBC file",
                path.display().to_string(),
                "give a DBC file: a text in UTF-8 or Latin-1 with lines BO_ and SG_",
            ));
        }
        Ok(dbc)
    }

    /// The message called `name`.
    pub(crate) fn find(&self, name: &str) -> Option<&Message> {
        self.messages.iter().find(|m| m.name == name)
    }
}

impl Message {
    /// Whether a classic frame cannot hold it.
    pub(crate) fn is_long(&self) -> bool {
        // A frame that is too short gives no value.
        self.length > 8 || self.signals.iter().any(|s| s.layout.raw(&[0; 8]).is_none())
    }

    /// Whether a frame of this identifier is this message.
    pub(crate) fn matches(&self, id: u32, extended: bool) -> bool {
        if self.extended != extended {
            return false;
        }
        self.id == id || (self.j1939 && group(self.id) == group(id))
    }

    /// The signal called `name`, or a suggestion.
    pub(crate) fn find(&self, name: &str) -> Result<&Signal, String> {
        let found = self.signals.iter().find(|s| s.name == name);
        found.ok_or_else(|| {
            let names = self.signals.iter().map(|s| s.name.as_str());
            hint(name, names, "its signals are")
        })
    }

    /// Place of a signal. A multiplexor may itself be multiplexed; without its multiplexor, or with one that
    /// depends on itself, a signal has no place.
    pub(crate) fn place(&self, signal: &Signal) -> Option<Place> {
        let mut conditions = Vec::new();
        let mut dependent = signal;
        while let Some(condition) = &dependent.only_if {
            let mut all = self.signals.iter();
            let found = match &condition.multiplexor {
                Some(name) => all.find(|s| s.name == *name),
                None => all.find(|s| s.multiplexor && s.name != dependent.name),
            };
            let multiplexor = found.filter(|_| conditions.len() < self.signals.len())?;
            conditions.push((multiplexor.layout.clone(), condition.values.clone()));
            dependent = multiplexor;
        }
        Some(Place {
            layout: signal.layout.clone(),
            conditions,
            j1939: self.j1939,
        })
    }
}

impl Place {
    /// Whether a frame of this content has the signal, by its multiplexors.
    fn is_carried(&self, data: &[u8]) -> bool {
        self.conditions.iter().all(|(multiplexor, values)| {
            let selected = multiplexor.raw(data);
            selected.is_some_and(|s| values.iter().any(|(low, high)| (*low..=*high).contains(&s)))
        })
    }

    /// Whether a frame should have the signal and ends before it.
    pub(crate) fn is_behind(&self, data: &[u8]) -> bool {
        !data.is_empty() && self.layout.raw(data).is_none() && self.is_carried(data)
    }

    /// The reading of the signal in a frame.
    pub(crate) fn read(&self, data: &[u8]) -> Reading {
        let carried = self.is_carried(data);
        let Some(raw) = self.layout.raw(data).filter(|_| carried) else {
            return Reading::Absent;
        };
        let value = self.layout.physical(raw);
        if value.is_finite() && !(self.j1939 && self.layout.is_unavailable(raw)) {
            Reading::Value(value)
        } else {
            Reading::Missing
        }
    }
}

/// Parameter group of a J1939 identifier: without priority and source, and without the destination
/// where there is one.
pub(crate) fn group(id: u32) -> u32 {
    let group = id >> 8 & 0x3_ffff;
    if group >> 8 & 0xff < 240 {
        group & 0x3_ff00
    } else {
        group
    }
}

/// Source address of a J1939 identifier.
pub(crate) fn source(id: u32) -> u8 {
    id as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Dbc {
        Dbc::parse(text, Path::new("x.dbc")).expect("a DBC")
    }

    /// The reading of the last signal of the first message in a frame.
    fn last(text: &str, data: &[u8]) -> Reading {
        let dbc = parse(text);
        let message = &dbc.messages[0];
        let signal = message.signals.last().expect("a signal");
        message.place(signal).expect("a place").read(data)
    }

    fn decode(description: &str, data: &[u8]) -> Reading {
        let text = format!("BO_ 100 Frame: 8 X\n SG_ {description} [0|0] \"\" X\n");
        last(&text, data)
    }

    use Reading::{Absent, Missing, Value};

    #[test]
    fn both_byte_orders_are_those_done_by_hand() {
        let data = [0x12, 0x34, 0x56, 0x78];
        assert_eq!(decode("a : 0|16@1+ (1,0)", &data), Value(f64::from(0x3412)));
        assert_eq!(decode("a : 7|16@0+ (1,0)", &data), Value(f64::from(0x1234)));
        assert_eq!(decode("a : 3|8@0+ (1,0)", &data), Value(f64::from(0x23)));
        assert_eq!(decode("a:4|8@1+(1,0)", &data), Value(f64::from(0x41)));
    }

    #[test]
    fn sign_scale_and_offset_apply_in_this_order() {
        assert_eq!(decode("a : 0|8@1- (0.5,10)", &[0xfe]), Value(9.0));
        assert_eq!(decode("a : 0|64@1- (1,0)", &[0xff; 8]), Value(-1.0));
        assert_eq!(decode("a : 0|12@1- (1,0)", &[0x00, 0x08]), Value(-2048.0));
    }

    #[test]
    fn a_float_is_no_integer() {
        let text = "BO_ 1 F: 8 X\n SG_ a : 0|32@1- (1,0) [0|0] \"N m\" X\nSIG_VALTYPE_ 1 a : 1;\n";
        assert_eq!(last(text, &1500.0_f32.to_le_bytes()), Value(1500.0));
        assert_eq!(last(text, &f32::NAN.to_le_bytes()), Missing);
        let text = "BO_ 1 F: 8 X\n SG_ a : 7|64@0- (2,0) [0|0] \"\" X\nSIG_VALTYPE_ 1 a : 2;\n";
        assert_eq!(last(text, &(-0.25_f64).to_be_bytes()), Value(-0.5));
        let wrong = "BO_ 1 F: 8 X\n SG_ a : 0|16@1- (1,0) [0|0] \"\" X\nSIG_VALTYPE_ 1 a : 1;\n";
        assert!(
            Dbc::parse(wrong, Path::new("x.dbc")).is_err(),
            "a float of 16 bits"
        );
    }

    #[test]
    fn a_short_frame_has_no_value() {
        assert_eq!(decode("a : 8|16@1+ (1,0)", &[0, 0]), Absent);
    }

    #[test]
    fn a_multiplexed_signal_is_there_only_with_its_multiplexor() {
        let text = "BO_ 1 F: 8 X\n SG_ sel M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ a m2 : 8|8@1+ (1,0) [0|0] \"\" X\n";
        assert_eq!(last(text, &[2, 7]), Value(7.0));
        assert_eq!(last(text, &[1, 7]), Absent);
    }

    #[test]
    fn an_extended_multiplexor_has_ranges_and_may_be_multiplexed_itself() {
        let text = "BO_ 1 F: 8 X\n SG_ top M : 0|8@1+ (1,0) [0|0] \"\" X\n\
             SG_ sub m1M : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ a m0 : 16|8@1+ (1,0) [0|0] \"\" X\n\
             SG_MUL_VAL_ 1 sub top 1-1;\nSG_MUL_VAL_ 1 a sub 3-5, 9-9;\n";
        assert_eq!(last(text, &[1, 4, 7]), Value(7.0));
        assert_eq!(last(text, &[1, 9, 7]), Value(7.0));
        assert_eq!(last(text, &[1, 6, 7]), Absent);
        assert_eq!(
            last(text, &[0, 4, 7]),
            Absent,
            "the multiplexor is not there"
        );
        let circle = text.replace("sub top 1-1", "sub sub 1-1");
        let dbc = parse(&circle);
        assert_eq!(dbc.messages[0].place(&dbc.messages[0].signals[2]), None);
    }

    const EEC1: &str =
        "BO_ 2364540158 EEC1: 8 X\n SG_ speed : 24|16@1+ (0.125,0) [0|8031] \"rpm\" X\n";

    #[test]
    fn j1939_frames_match_by_group_and_say_when_there_is_no_value() {
        let dbc = parse(&format!("{EEC1}BA_ \"ProtocolType\" \"J1939\";"));
        let eec1 = &dbc.messages[0];
        assert!(eec1.matches(0x0cf0_0400, true), "another source");
        assert!(!eec1.matches(0x0cf0_0300, true), "another group");
        assert!(!eec1.matches(0x0cf0_0400, false));
        assert_eq!(group(0x0c01_0305), 0x0100, "the destination does not count");
        let place = eec1.place(&eec1.signals[0]).expect("a place");
        let value = |high| place.read(&[0, 0, 0, 0x50, high, 0, 0, 0]);
        assert_eq!(value(0x20), Value(1034.0));
        assert_eq!(value(0xff), Missing);
        assert_eq!(value(0xfe), Missing);
    }

    #[test]
    fn what_is_j1939_is_said_by_attributes_and_not_by_a_comment() {
        let j1939 = |attributes: &str| parse(&format!("{EEC1}{attributes}")).messages[0].j1939;
        assert!(!j1939("CM_ \"ported from J1939;\nBA_ 1\";"));
        let define = "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\";\n";
        let of = |format: &str| j1939(&format!("{define}{format}"));
        assert!(of("BA_ \"VFrameFormat\" BO_ 2364540158 3;"));
        assert!(!of("BA_ \"VFrameFormat\" BO_ 2364540158 1;"));
        assert!(of("BA_DEF_DEF_ \"VFrameFormat\" \"J1939PG\";"));
        assert!(!of("BA_DEF_DEF_ \"VFrameFormat\" \"ExtendedCAN\";"));
        assert!(
            !of("BA_ \"ProtocolType\" \"J1939\";\nBA_ \"VFrameFormat\" BO_ 2364540158 1;"),
            "the message's own word counts"
        );
    }

    #[test]
    fn the_list_of_new_symbols_and_comments_over_lines_are_passed_over() {
        let text = "VERSION \"a;b\"\nNS_ :\n\tBA_\n\tSIG_VALTYPE_\n\tSG_MUL_VAL_\nBS_:\nBU_: A B\n\
             BO_ 1 F: 8 X\n SG_ a : 0|8@1+ (1,0) [0|0] \"\\\"q\\\"\" X\nCM_ SG_ 1 a \"said\nBO_ nonsense\n\";\n";
        let dbc = parse(text);
        assert_eq!(dbc.messages.len(), 1);
        assert_eq!(dbc.messages[0].signals.len(), 1);
    }

    #[test]
    fn a_broken_line_is_named() {
        for (text, line) in [
            ("BO_ 1 F: 8 X\n SG_ a : x|8@1+ (1,0)\n", 2),
            ("BO_ 1 F: 8 X\n\n SG_ a : 0|65@1+ (1,0) [0|0] \"\" X\n", 3),
            ("BO_ 1 F: 8 X\n SG_ a : 0|8@2+ (1,0) [0|0] \"\" X\n", 2),
            ("BO_ 1 F: 8 X\n SG_ a : 0|8@1+ (1e999,0) [0|0] \"\" X\n", 2),
            ("SG_ a : 0|8@1+ (1,0) [0|0] \"\" X\n", 1),
            ("BO_ -1 F: 8 X\n", 1),
        ] {
            let error = Dbc::parse(text, Path::new("x.dbc"));
            assert_eq!(
                error.err().map(|e| e.place),
                Some(format!("x.dbc:{line}")),
                "{text}"
            );
        }
    }
}
