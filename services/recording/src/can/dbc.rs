//! CAN databases: which signals a frame carries.

use std::collections::HashMap;
use std::path::Path;

use super::layout::{Layout, Number};
use super::tokens::{Kind, Token, tokens};
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
    /// A parameter group of SAE J1939: frames match by their group, whatever their priority, source
    /// and destination, and the topmost values of a signal mean that there is none.
    pub j1939: bool,
    pub signals: Vec<Signal>,
}

/// A signal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Signal {
    pub name: String,
    pub layout: Layout,
    /// Unit as the file writes it.
    pub unit: String,
    /// Range as the file writes it; 0, 0 where it says nothing.
    pub range: (f64, f64),
    /// Whether other signals depend on the value of this one.
    multiplexor: bool,
    /// The frame carries the signal only if this one has a value within one of the ranges.
    only_if: Option<Condition>,
}

#[derive(Debug, Clone, PartialEq)]
struct Condition {
    /// Name of the multiplexor; none: the one that the message has.
    multiplexor: Option<String>,
    values: Vec<(u64, u64)>,
}

/// What a frame says of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Reading {
    /// The frame does not carry it.
    Absent,
    /// The frame says that there is no value.
    Missing,
    /// The value in the DBC's unit.
    Value(f64),
}

/// A signal together with what decides whether a frame carries it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Place {
    layout: Layout,
    conditions: Vec<(Layout, Vec<(u64, u64)>)>,
    j1939: bool,
}

impl Dbc {
    /// Reads the messages of a file; text that is not UTF-8 is taken as Latin-1.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let bytes =
            std::fs::read(path).map_err(|e| Error::system("read the DBC file", path, &e))?;
        let text = String::from_utf8(bytes)
            .unwrap_or_else(|e| e.as_bytes().iter().map(|b| char::from(*b)).collect());
        Self::parse(&text, path)
    }

    /// Reads the messages of a text.
    pub(crate) fn parse(text: &str, path: &Path) -> Result<Self, Error> {
        let mut parser = Parser::default();
        let tokens: Vec<Token> = tokens(text).collect();
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            let end = statement_end(&tokens, at);
            let statement = &tokens[at..end];
            parser.statement(statement).ok_or_else(|| {
                let line = text.lines().nth(token.line - 1).unwrap_or_default();
                let line: String = line.trim().chars().take(120).collect();
                Error::new(
                    format!("cannot read \"{line}\""),
                    format!("{}:{}", path.display(), token.line),
                    "correct the line (SG_ name : start|length@order sign (scale,offset) ...)",
                )
            })?;
            at = end;
        }
        Ok(parser.finish())
    }

    /// The message called `name`.
    pub(crate) fn find(&self, name: &str) -> Option<&Message> {
        self.messages.iter().find(|m| m.name == name)
    }
}

/// Where the statement that begins at `at` ends: before the next line that begins with a keyword.
/// The list of new symbols (`NS_`) names keywords at the beginning of lines: it ends at `BS_`.
fn statement_end(tokens: &[Token], at: usize) -> usize {
    let in_list = tokens[at].text == "NS_";
    let is_end = |t: &Token| {
        let plain = matches!(t.text, "BS_" | "BU_" | "BO_" | "SG_" | "VERSION");
        t.first && t.kind == Kind::Word && (plain || (!in_list && t.text.ends_with('_')))
    };
    let rest = &tokens[at + 1..];
    rest.iter()
        .position(is_end)
        .map_or(tokens.len(), |n| at + 1 + n)
}

/// What has been read so far; attributes stand behind the messages that they are about.
#[derive(Default)]
struct Parser {
    messages: Vec<Message>,
    /// Where each message stands, by its identifier in the file.
    index: HashMap<u32, usize>,
    /// Names of the values of the attribute `VFrameFormat`.
    formats: Vec<String>,
    default_format: Option<String>,
    format: HashMap<u32, String>,
    default_protocol: Option<String>,
    protocol: Option<String>,
    /// Names of more than 32 letters, kept beside the file's own: message, signal if it is one's.
    long_names: Vec<(u32, Option<String>, String)>,
}

impl Parser {
    /// Takes a statement; `None` if it says something that cannot be.
    fn statement(&mut self, tokens: &[Token]) -> Option<()> {
        let mut words = Words(tokens);
        match words.word()? {
            "BO_" => self.message(words),
            "SG_" => {
                let signal = signal(words)?;
                self.messages.last_mut()?.signals.push(signal);
                Some(())
            }
            "SIG_VALTYPE_" => self.value_type(words),
            "SG_MUL_VAL_" => self.extended_multiplexing(words),
            "BA_DEF_" | "BA_DEF_DEF_" | "BA_" => {
                // What is not understood of an attribute is of no concern here.
                let _ = self.attribute(tokens[0].text, words);
                Some(())
            }
            _ => Some(()),
        }
    }

    /// `BO_ id name: length sender`
    fn message(&mut self, mut words: Words) -> Option<()> {
        let id: u32 = words.number()?;
        let name = words.word()?.to_owned();
        words.sign(":")?;
        self.index.insert(id, self.messages.len());
        self.messages.push(Message {
            name,
            id: id & 0x1fff_ffff,
            extended: id & 0x8000_0000 != 0,
            j1939: false,
            signals: Vec::new(),
        });
        Some(())
    }

    /// The signal that a statement is about; none where the file has no such signal.
    fn signal_of(&mut self, words: &mut Words) -> Option<&mut Signal> {
        let id: u32 = words.number()?;
        let name = words.word()?;
        let message = self.messages.get_mut(*self.index.get(&id)?)?;
        message.signals.iter_mut().find(|s| s.name == name)
    }

    /// `SIG_VALTYPE_ id name : 1;` (1: 32-bit float, 2: 64-bit float)
    fn value_type(&mut self, mut words: Words) -> Option<()> {
        let Some(signal) = self.signal_of(&mut words) else {
            return Some(());
        };
        let _ = words.sign(":");
        signal.layout.number = match (words.number::<u32>()?, signal.layout.length) {
            (0, _) => signal.layout.number,
            (1, 32) => Number::Float,
            (2, 64) => Number::Double,
            _ => return None,
        };
        Some(())
    }

    /// `SG_MUL_VAL_ id name multiplexor 1-3, 7-7;`
    fn extended_multiplexing(&mut self, mut words: Words) -> Option<()> {
        let Some(signal) = self.signal_of(&mut words) else {
            return Some(());
        };
        let multiplexor = words.word()?.to_owned();
        let mut values = Vec::new();
        while let Some(range) = words.word() {
            let (low, high) = range.split_once('-')?;
            values.push((low.parse().ok()?, high.parse().ok()?));
            let _ = words.sign(",");
        }
        signal.only_if = Some(Condition {
            multiplexor: Some(multiplexor),
            values,
        });
        Some(())
    }

    /// `BA_DEF_ BO_ "VFrameFormat" ENUM "a","b";`, `BA_DEF_DEF_ "VFrameFormat" "a";`,
    /// `BA_ "VFrameFormat" BO_ id 3;`, and the same of `ProtocolType`, which is one of the file.
    fn attribute(&mut self, keyword: &str, mut words: Words) -> Option<()> {
        let name = words.0.iter().find(|t| t.kind == Kind::Text)?.text;
        let behind = words.0.iter().position(|t| t.kind == Kind::Text)? + 1;
        words = Words(&words.0[behind..]);
        match (name, keyword) {
            ("VFrameFormat", "BA_DEF_") => {
                let names = words.0.iter().filter(|t| t.kind == Kind::Text);
                self.formats = names.map(|t| t.text.to_owned()).collect();
            }
            ("VFrameFormat", "BA_DEF_DEF_") => self.default_format = Some(words.value()?),
            ("VFrameFormat", _) => {
                (words.word()? == "BO_").then_some(())?;
                let (id, value) = (words.number()?, words.value()?);
                self.format.insert(id, value);
            }
            ("SystemMessageLongSymbol", "BA_") => {
                (words.word()? == "BO_").then_some(())?;
                self.long_names
                    .push((words.number()?, None, words.value()?));
            }
            ("SystemSignalLongSymbol", "BA_") => {
                (words.word()? == "SG_").then_some(())?;
                let (id, short) = (words.number()?, words.word()?.to_owned());
                self.long_names.push((id, Some(short), words.value()?));
            }
            ("ProtocolType", "BA_DEF_DEF_") => self.default_protocol = Some(words.value()?),
            ("ProtocolType", "BA_") => self.protocol = Some(words.value()?),
            _ => {}
        }
        Some(())
    }

    fn finish(mut self) -> Dbc {
        let protocol = self.protocol.as_ref().or(self.default_protocol.as_ref());
        let all = protocol.is_some_and(|p| p.eq_ignore_ascii_case("J1939"));
        let default = self
            .default_format
            .as_ref()
            .is_some_and(|f| self.is_j1939(f));
        let mut messages = std::mem::take(&mut self.messages);
        for (id, at) in &self.index {
            let own = self.format.get(id).map(|f| self.is_j1939(f));
            messages[*at].j1939 = messages[*at].extended && own.unwrap_or(all || default);
        }
        for (id, short, long) in self.long_names {
            let Some(message) = self.index.get(&id).and_then(|at| messages.get_mut(*at)) else {
                continue;
            };
            match short {
                None => message.name = long,
                Some(short) => {
                    let mut found = message.signals.iter_mut().filter(|s| s.name == short);
                    found.by_ref().for_each(|s| s.name.clone_from(&long));
                }
            }
        }
        Dbc { messages }
    }

    /// A format by its name, or by its number in the definition (3 where there is none).
    fn is_j1939(&self, format: &str) -> bool {
        let number = format.parse::<usize>().ok();
        let named = number.and_then(|n| self.formats.get(n));
        let name = named.map_or(format, String::as_str);
        name.eq_ignore_ascii_case("J1939PG") || (self.formats.is_empty() && number == Some(3))
    }
}

/// `name [M|m3|m3M] : start|length@order sign (scale,offset) [min|max] "unit" receivers`
fn signal(mut words: Words) -> Option<Signal> {
    let name = words.word()?.to_owned();
    let mark = words.word().unwrap_or_default();
    words.sign(":")?;
    let start = words.number()?;
    words.sign("|")?;
    let length = words.number()?;
    words.sign("@")?;
    let order = words.word()?;
    words.sign("(")?;
    let scale = words.number()?;
    words.sign(",")?;
    let offset = words.number()?;
    words.sign(")")?;
    let range = range(&mut words).unwrap_or_default();
    let unit = words.0.iter().find(|t| t.kind == Kind::Text);
    let (little_endian, number) = match order {
        "1+" => (true, Number::Unsigned),
        "1-" => (true, Number::Signed),
        "0+" => (false, Number::Unsigned),
        "0-" => (false, Number::Signed),
        _ => return None,
    };
    let value = mark.strip_prefix('m').map(|m| m.trim_end_matches('M'));
    let value: Option<u64> = match value {
        Some(value) => Some(value.parse().ok()?),
        None => None,
    };
    let layout = Layout {
        start,
        length,
        little_endian,
        number,
        scale,
        offset,
    };
    let sane = (1..=64).contains(&length) && start < 512 && (scale + offset).is_finite();
    sane.then(|| Signal {
        name,
        layout,
        unit: unit.map_or(String::new(), |t| t.text.trim().to_owned()),
        range,
        multiplexor: mark.ends_with('M'),
        only_if: value.map(|value| Condition {
            multiplexor: None,
            values: vec![(value, value)],
        }),
    })
}

/// `[min|max]`
fn range(words: &mut Words) -> Option<(f64, f64)> {
    words.sign("[")?;
    let low = words.number()?;
    words.sign("|")?;
    let high = words.number()?;
    words.sign("]")?;
    Some((low, high))
}

/// The rest of a statement.
struct Words<'a>(&'a [Token<'a>]);

impl<'a> Words<'a> {
    fn take(&mut self, kind: Kind) -> Option<&'a str> {
        let (first, rest) = self.0.split_first()?;
        (first.kind == kind).then(|| {
            self.0 = rest;
            first.text
        })
    }

    fn word(&mut self) -> Option<&'a str> {
        self.take(Kind::Word)
    }

    fn number<T: std::str::FromStr>(&mut self) -> Option<T> {
        self.word()?.parse().ok()
    }

    fn sign(&mut self, sign: &str) -> Option<()> {
        let is = self
            .0
            .first()
            .is_some_and(|t| t.kind == Kind::Sign && t.text == sign);
        is.then(|| self.0 = &self.0[1..])
    }

    /// A word or a text.
    fn value(&mut self) -> Option<String> {
        let value = self.word().or_else(|| self.take(Kind::Text))?;
        Some(value.to_owned())
    }
}

impl Message {
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

    /// Where a signal lies. A multiplexor may itself be multiplexed; one that is not there, or
    /// depends on itself, is nowhere.
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
    /// What a frame says of the signal.
    pub(crate) fn read(&self, data: &[u8]) -> Reading {
        let carried = self.conditions.iter().all(|(multiplexor, values)| {
            let selected = multiplexor.raw(data);
            selected.is_some_and(|s| values.iter().any(|(low, high)| (*low..=*high).contains(&s)))
        });
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

    /// What a frame says of the last signal of the first message.
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
