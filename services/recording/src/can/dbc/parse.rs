//! Reading of DBC files.

use std::collections::HashMap;
use std::path::Path;

use super::super::layout::{Layout, Number};
use super::super::tokens::{Kind, Token, tokens};
use super::{Condition, Dbc, Message, Signal};
use crate::Error;

impl Dbc {
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
}

/// End of the statement that begins at `at`: before the next line that begins with a keyword.
/// The list of new symbols (`NS_`) has keywords at the beginning of lines: it ends at `BS_`.
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

/// The statements read up to now; attributes follow the messages that they belong to.
#[derive(Default)]
struct Parser {
    messages: Vec<Message>,
    /// Index of each message by its identifier in the file.
    index: HashMap<u32, usize>,
    /// Names of the values of the attribute `VFrameFormat`.
    formats: Vec<String>,
    default_format: Option<String>,
    format: HashMap<u32, String>,
    default_protocol: Option<String>,
    protocol: Option<String>,
    /// Names of more than 32 letters, stored beside the file's own: message, signal if it is that of one.
    long_names: Vec<(u32, Option<String>, String)>,
}

impl Parser {
    /// Takes a statement; `None` if it is not valid.
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
                // Attributes that are not understood are ignored.
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
        let length = words.number().unwrap_or(0);
        self.index.insert(id, self.messages.len());
        self.messages.push(Message {
            name,
            id: id & 0x1fff_ffff,
            extended: id & 0x8000_0000 != 0,
            j1939: false,
            length,
            signals: Vec::new(),
        });
        Some(())
    }

    /// The signal that a statement belongs to; none if the file has no such signal.
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
    /// `BA_ "VFrameFormat" BO_ id 3;`, and the same of `ProtocolType`, which belongs to the whole file.
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
