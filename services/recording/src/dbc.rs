//! CAN databases: where a signal lies in a frame.

use std::path::Path;

use crate::Error;
use crate::map::hint;

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
    /// Of a J1939 database: frames match by their parameter group, and the topmost values of a
    /// signal mean that there is none.
    pub j1939: bool,
    pub signals: Vec<Signal>,
}

/// A signal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Signal {
    pub name: String,
    start: usize,
    length: usize,
    little_endian: bool,
    signed: bool,
    scale: f64,
    offset: f64,
    /// Value of the multiplexor with which the frame carries this signal.
    multiplexed: Option<u64>,
    multiplexor: bool,
}

impl Dbc {
    /// Reads the messages of a file.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let bytes =
            std::fs::read(path).map_err(|e| Error::system("read the DBC file", path, &e))?;
        Self::parse(&String::from_utf8_lossy(&bytes), path)
    }

    /// Reads the messages of a text.
    pub(crate) fn parse(text: &str, path: &Path) -> Result<Self, Error> {
        let mut dbc = Self::default();
        let j1939 = text.to_ascii_uppercase().contains("J1939");
        for (number, line) in text.lines().enumerate() {
            let line = line.trim();
            let read = if let Some(rest) = line.strip_prefix("BO_ ") {
                message(rest, j1939).map(|m| dbc.messages.push(m))
            } else if let Some(rest) = line.strip_prefix("SG_ ") {
                let owner = dbc.messages.last_mut();
                signal(rest).and_then(|s| owner.map(|m| m.signals.push(s)))
            } else {
                Some(())
            };
            read.ok_or_else(|| {
                Error::new(
                    format!("cannot read \"{line}\""),
                    format!("{}:{}", path.display(), number + 1),
                    "correct the line (SG_ name : start|length@order sign (scale,offset) ...)",
                )
            })?;
        }
        Ok(dbc)
    }

    /// The message called `name`.
    pub(crate) fn find(&self, name: &str) -> Option<&Message> {
        self.messages.iter().find(|m| m.name == name)
    }
}

impl Message {
    /// Whether a frame of this identifier is this message.
    pub(crate) fn matches(&self, id: u32, extended: bool) -> bool {
        if self.extended != extended {
            return false;
        }
        self.id == id || (self.j1939 && extended && group(self.id) == group(id))
    }

    /// The signal called `name`, or a suggestion.
    pub(crate) fn find(&self, name: &str) -> Result<&Signal, String> {
        let found = self.signals.iter().find(|s| s.name == name);
        found.ok_or_else(|| {
            let names = self.signals.iter().map(|s| s.name.as_str());
            hint(name, names, "its signals are")
        })
    }

    /// Value of a signal in a frame; `None` if the frame does not carry it.
    pub(crate) fn value(&self, signal: &Signal, data: &[u8]) -> Option<f64> {
        if let Some(wanted) = signal.multiplexed {
            let multiplexor = self.signals.iter().find(|s| s.multiplexor)?;
            if multiplexor.raw(data)? != wanted {
                return None;
            }
        }
        let raw = signal.raw(data)?;
        (!(self.j1939 && signal.is_unavailable(raw))).then(|| signal.physical(raw))
    }
}

/// Parameter group of a J1939 identifier: without priority and source, and without the destination
/// where there is one.
fn group(id: u32) -> u32 {
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

impl Signal {
    /// The bits of the signal; `None` if the frame is too short.
    fn raw(&self, data: &[u8]) -> Option<u64> {
        let mut raw = 0;
        let mut bit = self.start;
        for i in 0..self.length {
            let value = u64::from(*data.get(bit / 8)? >> (bit % 8) & 1);
            if self.little_endian {
                raw |= value << i;
                bit += 1;
            } else {
                // The start is the most significant bit; bits fall within a byte, then go on at
                // the top of the next.
                raw = raw << 1 | value;
                bit = if bit.is_multiple_of(8) {
                    bit + 15
                } else {
                    bit - 1
                };
            }
        }
        Some(raw)
    }

    fn physical(&self, raw: u64) -> f64 {
        let unused = 64 - self.length as u32;
        let number = if self.signed {
            ((raw << unused) as i64 >> unused) as f64
        } else {
            raw as f64
        };
        number * self.scale + self.offset
    }

    /// J1939-71: all ones is "not available", of whole bytes everything from 0xFB.. is no value.
    fn is_unavailable(&self, raw: u64) -> bool {
        let ones = u64::MAX >> (64 - self.length);
        let indicator = self.length.is_multiple_of(8) && raw >> (self.length - 8) >= 0xfb;
        !self.signed && self.length > 1 && (raw == ones || indicator)
    }
}

/// `id name: dlc sender`
fn message(text: &str, j1939: bool) -> Option<Message> {
    let (id, rest) = text.split_once(' ')?;
    let id: u32 = id.parse().ok()?;
    let (name, _) = rest.split_once(':')?;
    Some(Message {
        name: name.trim().to_owned(),
        id: id & 0x1fff_ffff,
        extended: id & 0x8000_0000 != 0,
        j1939,
        signals: Vec::new(),
    })
}

/// `name [M|m3] : start|length@order sign (scale,offset) [min|max] "unit" receivers`
fn signal(text: &str) -> Option<Signal> {
    let (head, rest) = text.split_once(':')?;
    let mut head = head.split_whitespace();
    let name = head.next()?.to_owned();
    let mark = head.next().unwrap_or_default();
    let mut rest = rest.split_whitespace();
    let (start, shape) = rest.next()?.split_once('|')?;
    let (length, order) = shape.split_once('@')?;
    let (scale, offset) = text.split_once('(')?.1.split_once(')')?.0.split_once(',')?;
    let signal = Signal {
        name,
        start: start.parse().ok()?,
        length: length.parse().ok()?,
        little_endian: order.starts_with('1'),
        signed: order.ends_with('-'),
        scale: scale.trim().parse().ok()?,
        offset: offset.trim().parse().ok()?,
        multiplexed: mark
            .strip_prefix('m')
            .and_then(|m| m.trim_end_matches('M').parse().ok()),
        multiplexor: mark.ends_with('M'),
    };
    let fits = (1..=64).contains(&signal.length) && signal.start < 512;
    fits.then_some(signal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(description: &str, data: &[u8]) -> Option<f64> {
        let text = format!("BO_ 100 Frame: 8 X\n SG_ {description} [0|0] \"\" X\n");
        let dbc = Dbc::parse(&text, Path::new("x.dbc")).expect("a DBC");
        let message = &dbc.messages[0];
        message.value(&message.signals[0], data)
    }

    #[test]
    fn both_byte_orders_are_those_done_by_hand() {
        let data = [0x12, 0x34, 0x56, 0x78];
        assert_eq!(decode("a : 0|16@1+ (1,0)", &data), Some(f64::from(0x3412)));
        assert_eq!(decode("a : 7|16@0+ (1,0)", &data), Some(f64::from(0x1234)));
        assert_eq!(decode("a : 3|8@0+ (1,0)", &data), Some(f64::from(0x23)));
        assert_eq!(decode("a : 4|8@1+ (1,0)", &data), Some(f64::from(0x41)));
    }

    #[test]
    fn sign_scale_and_offset_apply_in_this_order() {
        assert_eq!(decode("a : 0|8@1- (0.5,10)", &[0xfe]), Some(9.0));
        assert_eq!(decode("a : 0|64@1- (1,0)", &[0xff; 8]), Some(-1.0));
        assert_eq!(decode("a : 0|12@1- (1,0)", &[0x00, 0x08]), Some(-2048.0));
    }

    #[test]
    fn a_short_frame_has_no_value() {
        assert_eq!(decode("a : 8|16@1+ (1,0)", &[0, 0]), None);
    }

    #[test]
    fn a_multiplexed_signal_is_there_only_with_its_multiplexor() {
        let text = "BO_ 1 F: 8 X\n SG_ sel M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ a m2 : 8|8@1+ (1,0) [0|0] \"\" X\n";
        let dbc = Dbc::parse(text, Path::new("x.dbc")).expect("a DBC");
        let (message, signal) = (&dbc.messages[0], &dbc.messages[0].signals[1]);
        assert_eq!(message.value(signal, &[2, 7]), Some(7.0));
        assert_eq!(message.value(signal, &[1, 7]), None);
    }

    #[test]
    fn j1939_frames_match_by_group_and_say_when_there_is_no_value() {
        let text = "BO_ 2364540158 EEC1: 8 X\n SG_ speed : 24|16@1+ (0.125,0) [0|8031] \"rpm\" X\nBA_ \"ProtocolType\" \"J1939\";";
        let dbc = Dbc::parse(text, Path::new("x.dbc")).expect("a DBC");
        let eec1 = &dbc.messages[0];
        assert!(eec1.matches(0x0cf0_0400, true), "another source");
        assert!(!eec1.matches(0x0cf0_0300, true), "another group");
        assert!(!eec1.matches(0x0cf0_0400, false));
        assert_eq!(group(0x0c01_0305), 0x0100, "the destination does not count");
        let value = |high| eec1.value(&eec1.signals[0], &[0, 0, 0, 0x50, high, 0, 0, 0]);
        assert_eq!(value(0x20), Some(1034.0));
        assert_eq!(value(0xff), None);
        assert_eq!(value(0xfe), None);
    }

    #[test]
    fn a_broken_line_is_named() {
        let error = Dbc::parse("BO_ 1 F: 8 X\n SG_ a : x|8@1+ (1,0)\n", Path::new("x.dbc"));
        assert_eq!(error.err().map(|e| e.place), Some("x.dbc:2".into()));
    }
}
