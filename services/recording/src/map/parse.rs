use std::path::Path;

use toml_edit::{Document, Item, TableLike};

use super::{
    Can, CanName, Conversion, Entry, Map, Origin, Rows, Term, Timing, TopicName, TopicTime, Topics,
    hint,
};
use crate::unit::Unit;
use crate::{Error, unit};

/// Largest rate of rows from CAN frames [Hz]: no bus carries a signal more often.
const MAX_RATE: f64 = 1000.0;

/// Reads a map.
pub(super) fn map(text: &str, path: &Path) -> Result<Map, Error> {
    Parser { text, path }.map()
}

struct Parser<'a> {
    text: &'a str,
    path: &'a Path,
}

/// Kind of origins in a table of entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum From {
    Columns,
    Can,
    Topics,
}

const TERM_KEYS: &[&str] = &[
    "column",
    "constant",
    "message",
    "signal",
    "source",
    "interface",
    "topic",
    "field",
    "name",
    "unit",
    "scale",
    "offset",
    "sign",
    "delay",
    "interpolate",
    "max_age",
];

impl Parser<'_> {
    fn map(&self) -> Result<Map, Error> {
        let document = Document::parse(self.text.to_owned()).map_err(|e| {
            let (line, what) = config::toml_error(self.text, &e);
            self.error(
                line.unwrap_or(1),
                what,
                config::toml_remedy(self.text, line),
            )
        })?;
        let mut map = Map {
            file: self.path.to_owned(),
            columns: Vec::new(),
            can: None,
            topics: None,
        };
        for (name, item) in document.iter() {
            let line = self.line(document.as_table(), name);
            match (name, item.as_table_like()) {
                ("columns", Some(table)) => map.columns = self.entries(table, From::Columns)?,
                ("can", Some(table)) => map.can = Some(self.can(table, line)?),
                ("topics", Some(table)) => map.topics = Some(self.topics(table, line)?),
                _ => {
                    let remedy = match name {
                        "machine" | "sensors" | "prior" | "estimator" => {
                            "this is of a machine file: give that with --config".into()
                        }
                        _ => {
                            let tables = ["columns", "can", "topics"].into_iter();
                            hint(name, tables, "the tables are")
                        }
                    };
                    return Err(self.error(line, format!("a map has no table [{name}]"), remedy));
                }
            }
        }
        if map.columns.is_empty() && map.can.is_none() && map.topics.is_none() {
            return Err(self.error(
                1,
                "the map is empty",
                "name signals under [columns], [can.signals] or [topics.signals]",
            ));
        }
        Ok(map)
    }

    fn entries(&self, table: &dyn TableLike, from: From) -> Result<Vec<Entry>, Error> {
        let entries = table.iter().map(|(signal, item)| {
            let line = self.line(table, signal);
            match (item.as_str(), item.as_table_like()) {
                (Some("none"), _) => Ok(Entry::plain(signal, Origin::Nowhere, line)),
                (Some(column), _) if from == From::Columns => {
                    Ok(Entry::plain(signal, Origin::Column(column.into()), line))
                }
                (_, Some(fields)) => self.entry(signal, fields, from, line),
                _ => Err(self.no_entry(signal, from, line)),
            }
        });
        entries.collect()
    }

    fn entry(
        &self,
        signal: &str,
        fields: &dyn TableLike,
        from: From,
        line: usize,
    ) -> Result<Entry, Error> {
        let Some(item) = fields.get("terms") else {
            let terms = vec![self.term(fields, from, line)?];
            return Ok(Entry {
                signal: signal.into(),
                terms,
                conversion: Conversion::NONE,
                line,
            });
        };
        self.known(fields, &["terms", "scale", "offset", "sign"])?;
        let conversion = self.conversion(fields)?;
        let none = || {
            let what = format!("{signal} has no terms");
            self.error(line, what, "write terms = [{ ... }, { ... }]")
        };
        let terms: Vec<Term> = match item {
            Item::ArrayOfTables(tables) => {
                let terms = tables.iter().map(|t| self.term(t, from, line));
                terms.collect::<Result<_, _>>()?
            }
            Item::Value(toml_edit::Value::Array(array)) => {
                let terms = array.iter().map(|value| {
                    let table = value.as_inline_table().ok_or_else(none)?;
                    self.term(table, from, line)
                });
                terms.collect::<Result<_, _>>()?
            }
            _ => Vec::new(),
        };
        if terms.is_empty() {
            return Err(none());
        }
        Ok(Entry {
            signal: signal.into(),
            terms,
            conversion,
            line,
        })
    }

    fn term(&self, fields: &dyn TableLike, from: From, line: usize) -> Result<Term, Error> {
        self.known(fields, TERM_KEYS)?;
        Ok(Term {
            origin: self.origin(fields, from, line)?,
            conversion: self.conversion(fields)?,
            timing: Timing {
                delay: self.within(fields, "delay", 0.0, 10.0)?.unwrap_or(0.0),
                interpolate: self.flag(fields, "interpolate")?,
                max_age: self.within(fields, "max_age", 0.0, 60.0)?,
            },
        })
    }

    fn no_entry(&self, signal: &str, from: From, line: usize) -> Error {
        let example = match from {
            From::Can => "{ message = \"...\", signal = \"...\" }",
            From::Topics => "{ topic = \"...\", field = \"...\" }",
            From::Columns => "\"name of the column\" or { column = \"...\", unit = \"...\" }",
        };
        let what = format!("{signal} does not say where it comes from");
        self.error(line, what, format!("write {signal} = {example}"))
    }

    fn origin(&self, fields: &dyn TableLike, from: From, line: usize) -> Result<Origin, Error> {
        self.one_origin(fields, from, line)?;
        if let Some(value) = self.number(fields, "constant")? {
            return Ok(Origin::Constant(value));
        }
        if from == From::Columns {
            let column = self.word(fields, "column")?;
            return column
                .map(Origin::Column)
                .ok_or_else(|| self.no_entry("the entry", from, line));
        }
        if from == From::Topics {
            let (topic, field) = (self.word(fields, "topic")?, self.word(fields, "field")?);
            let (topic, field) = topic
                .zip(field)
                .ok_or_else(|| self.no_entry("the entry", from, line))?;
            let name = self.word(fields, "name")?;
            return Ok(Origin::Topic(TopicName { topic, field, name }));
        }
        match (self.word(fields, "message")?, self.word(fields, "signal")?) {
            (Some(message), Some(signal)) => Ok(Origin::Can(CanName {
                message,
                signal,
                source: self.within(fields, "source", 0.0, 255.0)?.map(|x| x as u8),
                interface: self.word(fields, "interface")?,
            })),
            _ => Err(self.no_entry("the entry", from, line)),
        }
    }

    /// Refuses an entry with two origins, or with one of another table.
    fn one_origin(&self, fields: &dyn TableLike, from: From, line: usize) -> Result<(), Error> {
        let all = [
            ("column", From::Columns, "[columns]"),
            ("message", From::Can, "[can.signals]"),
            ("topic", From::Topics, "[topics.signals]"),
        ];
        let mut stated = all.iter().filter(|(key, ..)| fields.contains_key(key));
        let Some((key, its, table)) = stated.next() else {
            return Ok(());
        };
        let second = stated.map(|(key, ..)| *key).next();
        if let Some(second) = second.or(fields.contains_key("constant").then_some("constant")) {
            let what = format!("{key} and {second} both say where the value comes from");
            return Err(self.error(line, what, "leave out one of them"));
        }
        if *its != from {
            let what = format!("{key} is of the table {table}");
            return Err(self.error(line, what, format!("put the line under {table}")));
        }
        Ok(())
    }

    fn conversion(&self, fields: &dyn TableLike) -> Result<Conversion, Error> {
        let unit = match self.word(fields, "unit")? {
            Some(name) => Some(self.unit(fields, &name)?),
            None => None,
        };
        let sign = self.number(fields, "sign")?.unwrap_or(1.0);
        if sign.abs() != 1.0 {
            let line = self.line(fields, "sign");
            return Err(self.error(line, format!("sign is {sign}"), "give 1 or -1"));
        }
        let scale = self.number(fields, "scale")?;
        if scale == Some(0.0) {
            let remedy = "give another number; a signal that is always 0 is { constant = 0.0 }";
            return Err(self.error(self.line(fields, "scale"), "scale is 0", remedy));
        }
        Ok(Conversion {
            unit,
            scale,
            offset: self.number(fields, "offset")?.unwrap_or(0.0),
            sign,
        })
    }

    fn unit(&self, fields: &dyn TableLike, name: &str) -> Result<&'static Unit, Error> {
        unit::find(name).ok_or_else(|| {
            let names = unit::UNITS.iter().map(|u| u.name);
            let remedy = match unit::guess(name) {
                Some(meant) => format!("did you mean {}?", meant.name),
                None => hint(name, names, "the units are"),
            };
            self.error(
                self.line(fields, "unit"),
                format!("unknown unit {name}"),
                remedy,
            )
        })
    }

    fn can(&self, table: &dyn TableLike, line: usize) -> Result<Can, Error> {
        self.known(
            table,
            &["dbc", "j1939", "master", "rate", "hold", "signals"],
        )?;
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let files = match table.get("dbc") {
            Some(Item::Value(toml_edit::Value::String(file))) => vec![folder.join(file.value())],
            Some(Item::Value(toml_edit::Value::Array(files))) => files
                .iter()
                .filter_map(|f| f.as_str())
                .map(|f| folder.join(f))
                .collect(),
            _ => vec![],
        };
        if files.is_empty() {
            return Err(self.error(
                line,
                "[can] names no DBC file",
                "write dbc = [\"name.dbc\"]",
            ));
        }
        let rows = self.rows(table, "[can]", line)?;
        let signals = match table.get("signals").and_then(Item::as_table_like) {
            Some(signals) => self.entries(signals, From::Can)?,
            None => {
                return Err(self.error(
                    line,
                    "[can] names no signals",
                    "add them under [can.signals]",
                ));
            }
        };
        Ok(Can {
            dbc: files,
            j1939: match table.get("j1939") {
                Some(_) => Some(self.flag(table, "j1939")?),
                None => None,
            },
            rows,
            hold: self.within(table, "hold", 0.0, 60.0)?.unwrap_or(1.0),
            signals,
        })
    }

    /// Times of the rows.
    fn rows(&self, table: &dyn TableLike, name: &str, line: usize) -> Result<Rows, Error> {
        let rate = self.within(table, "rate", 0.1, MAX_RATE)?;
        match (self.word(table, "master")?, rate) {
            (Some(master), None) => Ok(Rows::Master(master)),
            (None, Some(rate)) => Ok(Rows::Rate(rate)),
            (master, _) => {
                let what = match master {
                    Some(_) => format!("{name} says twice when there is a row: master and rate"),
                    None => format!("{name} does not say when there is a row"),
                };
                let remedy =
                    "write master = \"a signal\" (a row for each of its values) or rate = 100 (Hz)";
                Err(self.error(line, what, remedy))
            }
        }
    }

    fn topics(&self, table: &dyn TableLike, line: usize) -> Result<Topics, Error> {
        self.known(table, &["master", "rate", "hold", "time", "signals"])?;
        let signals = table.get("signals").and_then(Item::as_table_like);
        let signals = signals.ok_or_else(|| {
            let remedy = "add them under [topics.signals]";
            self.error(line, "[topics] names no signals", remedy)
        })?;
        let time = match self.word(table, "time")?.as_deref() {
            None | Some("log") => TopicTime::Log,
            Some("publish") => TopicTime::Publish,
            Some("header") => TopicTime::Header,
            Some(other) => {
                let remedy = "write \"log\", \"publish\" or \"header\"";
                let line = self.line(table, "time");
                return Err(self.error(line, format!("no message has a time {other}"), remedy));
            }
        };
        Ok(Topics {
            rows: self.rows(table, "[topics]", line)?,
            time,
            hold: self.within(table, "hold", 0.0, 60.0)?.unwrap_or(1.0),
            signals: self.entries(signals, From::Topics)?,
        })
    }

    fn known(&self, table: &dyn TableLike, keys: &[&str]) -> Result<(), Error> {
        for (name, _) in table.iter() {
            if !keys.contains(&name) {
                let remedy = hint(name, keys.iter().copied(), "the keys are");
                let line = self.line(table, name);
                return Err(self.error(line, format!("a map has no key {name} there"), remedy));
            }
        }
        Ok(())
    }

    fn word(&self, table: &dyn TableLike, name: &str) -> Result<Option<String>, Error> {
        match table.get(name) {
            None => Ok(None),
            Some(item) => item.as_str().map(|s| Some(s.to_owned())).ok_or_else(|| {
                self.error(
                    self.line(table, name),
                    format!("{name} is no text"),
                    "put it in quotes",
                )
            }),
        }
    }

    fn number(&self, table: &dyn TableLike, name: &str) -> Result<Option<f64>, Error> {
        let Some(item) = table.get(name) else {
            return Ok(None);
        };
        let number = item.as_float().or(item.as_integer().map(|i| i as f64));
        number.filter(|x| x.is_finite()).map(Some).ok_or_else(|| {
            self.error(
                self.line(table, name),
                format!("{name} is no number"),
                "write a number",
            )
        })
    }

    /// A number within a range.
    fn within(
        &self,
        table: &dyn TableLike,
        name: &str,
        low: f64,
        high: f64,
    ) -> Result<Option<f64>, Error> {
        let number = self.number(table, name)?;
        if let Some(x) = number
            && !(low..=high).contains(&x)
        {
            let what = format!("{name} is {x}");
            let remedy = format!("give a number from {low} to {high}");
            return Err(self.error(self.line(table, name), what, remedy));
        }
        Ok(number)
    }

    fn flag(&self, table: &dyn TableLike, name: &str) -> Result<bool, Error> {
        match table.get(name) {
            None => Ok(false),
            Some(item) => item.as_bool().ok_or_else(|| {
                let what = format!("{name} is neither true nor false");
                self.error(self.line(table, name), what, "write true or false")
            }),
        }
    }

    /// Line of a key.
    fn line(&self, table: &dyn TableLike, name: &str) -> usize {
        let entry = table.get_key_value(name);
        let span = entry.and_then(|(key, item)| key.span().or_else(|| item.span()));
        span.map_or(1, |s| self.line_at(s.start))
    }

    fn line_at(&self, offset: usize) -> usize {
        self.text
            .get(..offset)
            .unwrap_or(self.text)
            .matches('\n')
            .count()
            + 1
    }

    fn error(&self, line: usize, what: impl Into<String>, remedy: impl Into<String>) -> Error {
        Error::new(what, format!("{}:{line}", self.path.display()), remedy)
    }
}
