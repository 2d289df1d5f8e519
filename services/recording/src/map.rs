//! Signal maps: which foreign column or CAN signal is which of heft's signals, in which unit.
//!
//! ```toml
//! [columns]
//! t = "t_s"                                             # renamed
//! swing_angle = { column = "swing_deg", unit = "deg" }  # with a unit
//! swing_torque = { column = "dp_bar", unit = "bar", scale = 2.1e-3, sign = -1 }
//! boom_angle = { column = "boom", unit = "deg", offset = 0.12 }
//! swing_velocity = { constant = 0.0 }                   # the same in every row
//! slope = "none"                                        # a column of that name is not used
//!
//! [can]
//! dbc = ["j1939.dbc"]                                   # beside the map
//! master = "speed"                                      # a row for each of its frames, or rate = 100
//! hold = 0.5                                            # older values are missing
//! [can.signals]
//! speed = { message = "CCVS1", signal = "WheelBasedVehicleSpeed", unit = "km/h", source = 0x00 }
//! ```
//!
//! A value becomes `sign * scale * (value in SI units) + offset`. A unit of another dimension than
//! the signal's needs a `scale`, which then says how much of the signal one SI unit is.

use std::path::{Path, PathBuf};

use config::nearest;
use toml_edit::{Document, Item, TableLike};

use crate::signal::Signal;
use crate::{Error, unit};

/// A signal map.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    file: PathBuf,
    pub(crate) columns: Vec<Entry>,
    pub(crate) can: Option<Can>,
}

/// One line of a map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    /// heft's name.
    pub signal: String,
    /// Where it comes from.
    pub origin: Origin,
    /// How it becomes a value in SI units.
    pub conversion: Conversion,
    line: usize,
}

/// Where a signal comes from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Origin {
    /// The column of this name.
    Column(String),
    /// This value in every row.
    Constant(f64),
    /// Nowhere; a column of its own name is not used.
    Nowhere,
    /// A CAN signal.
    Can(CanName),
}

/// Name of a CAN signal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CanName {
    pub message: String,
    pub signal: String,
    /// J1939 source address, if it matters.
    pub source: Option<u8>,
    /// Interface in the log, if it matters.
    pub interface: Option<String>,
}

/// From the foreign value to the signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Conversion {
    unit: Option<&'static str>,
    scale: Option<f64>,
    offset: f64,
    sign: f64,
}

impl Conversion {
    /// The value as it is.
    pub(crate) const NONE: Self = Self {
        unit: None,
        scale: None,
        offset: 0.0,
        sign: 1.0,
    };

    /// The signal's value. One that needs no conversion keeps its bits.
    pub(crate) fn apply(&self, value: f64) -> f64 {
        let factor = self.unit.and_then(unit::find).map_or(1.0, |u| u.factor);
        let factor = self.sign * self.scale.unwrap_or(1.0) * factor;
        if self.offset == 0.0 {
            value * factor
        } else {
            value * factor + self.offset
        }
    }
}

/// The CAN part of a map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Can {
    pub dbc: Vec<PathBuf>,
    pub rows: Rows,
    /// Age at which a held value becomes missing [s].
    pub hold: f64,
    pub signals: Vec<Entry>,
}

/// When there is a row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Rows {
    /// At each frame with this signal.
    Master(String),
    /// At this rate [Hz].
    Rate(f64),
}

impl Map {
    /// Reads a map from a file.
    ///
    /// # Errors
    /// The file cannot be read or is no map.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path)
            .map_err(|e| Error::system("read the signal map", path, &e))?;
        Self::parse(&text, path)
    }

    /// Reads a map from a text; `path` is the name for errors, and its folder that of the DBC files.
    ///
    /// # Errors
    /// The text is no map.
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, Error> {
        let parser = Parser {
            text,
            path: path.as_ref(),
        };
        parser.map()
    }

    /// Where an entry stands.
    pub(crate) fn place(&self, entry: &Entry) -> String {
        format!("{}:{}", self.file.display(), entry.line)
    }

    /// Checks names and units of entries against the signals of a machine.
    pub(crate) fn check(&self, entries: &[Entry], signals: &[Signal]) -> Result<(), Error> {
        for entry in entries {
            let Some(signal) = signals.iter().find(|s| s.name == entry.signal) else {
                let names = signals.iter().map(|s| s.name.as_str());
                return Err(Error::new(
                    format!("heft has no signal {}", entry.signal),
                    self.place(entry),
                    hint(&entry.signal, names, "the signals are"),
                ));
            };
            self.check_unit(entry, signal)?;
        }
        Ok(())
    }

    fn check_unit(&self, entry: &Entry, signal: &Signal) -> Result<(), Error> {
        let Conversion { unit, scale, .. } = entry.conversion;
        match unit.and_then(unit::find) {
            Some(u) if u.si != signal.unit && scale.is_none() => Err(Error::new(
                format!(
                    "{} is measured in {}, not in {}",
                    signal.name, signal.unit, u.name
                ),
                self.place(entry),
                format!(
                    "add scale = how many {} one {} is, or correct the unit",
                    signal.unit, u.si
                ),
            )),
            _ => Ok(()),
        }
    }
}

/// A suggestion: the nearest name, or all of them.
pub(crate) fn hint<'a>(
    word: &str,
    names: impl Iterator<Item = &'a str> + Clone,
    all: &str,
) -> String {
    match nearest(word, names.clone()) {
        Some(name) => format!("did you mean {name}?"),
        None => format!("{all} {}", names.collect::<Vec<_>>().join(", ")),
    }
}

struct Parser<'a> {
    text: &'a str,
    path: &'a Path,
}

const ENTRY_KEYS: &[&str] = &[
    "column",
    "constant",
    "message",
    "signal",
    "source",
    "interface",
    "unit",
    "scale",
    "offset",
    "sign",
];

impl Parser<'_> {
    fn map(&self) -> Result<Map, Error> {
        let document = Document::parse(self.text.to_owned()).map_err(|e| {
            let line = e.span().map_or(1, |s| self.line_at(s.start));
            let what = e.message().trim().replace('\n', "; ");
            self.error(line, what, "correct the TOML there")
        })?;
        let mut map = Map {
            file: self.path.to_owned(),
            columns: Vec::new(),
            can: None,
        };
        for (name, item) in document.iter() {
            let line = self.line(document.as_table(), name);
            match (name, item.as_table_like()) {
                ("columns", Some(table)) => map.columns = self.entries(table, false)?,
                ("can", Some(table)) => map.can = Some(self.can(table, line)?),
                _ => {
                    let remedy = hint(name, ["columns", "can"].into_iter(), "the tables are");
                    return Err(self.error(line, format!("a map has no table [{name}]"), remedy));
                }
            }
        }
        if map.columns.is_empty() && map.can.is_none() {
            return Err(self.error(
                1,
                "the map is empty",
                "name signals under [columns] or [can.signals]",
            ));
        }
        Ok(map)
    }

    fn entries(&self, table: &dyn TableLike, can: bool) -> Result<Vec<Entry>, Error> {
        let entries = table.iter().map(|(signal, item)| {
            let line = self.line(table, signal);
            let (origin, conversion) = match (item.as_str(), item.as_table_like()) {
                (Some("none"), _) => (Origin::Nowhere, Conversion::NONE),
                (Some(column), _) if !can => (Origin::Column(column.into()), Conversion::NONE),
                (_, Some(fields)) => {
                    self.known(fields, ENTRY_KEYS)?;
                    (self.origin(fields, can, line)?, self.conversion(fields)?)
                }
                _ => return Err(self.no_entry(signal, can, line)),
            };
            Ok(Entry {
                signal: signal.into(),
                origin,
                conversion,
                line,
            })
        });
        entries.collect()
    }

    fn no_entry(&self, signal: &str, can: bool, line: usize) -> Error {
        let example = if can {
            "{ message = \"...\", signal = \"...\" }"
        } else {
            "\"name of the column\" or { column = \"...\", unit = \"...\" }"
        };
        let what = format!("{signal} does not say where it comes from");
        self.error(line, what, format!("write {signal} = {example}"))
    }

    fn origin(&self, fields: &dyn TableLike, can: bool, line: usize) -> Result<Origin, Error> {
        if let Some(value) = self.number(fields, "constant")? {
            return Ok(Origin::Constant(value));
        }
        if !can {
            let column = self.word(fields, "column")?;
            return column
                .map(Origin::Column)
                .ok_or_else(|| self.no_entry("the entry", can, line));
        }
        match (self.word(fields, "message")?, self.word(fields, "signal")?) {
            (Some(message), Some(signal)) => Ok(Origin::Can(CanName {
                message,
                signal,
                source: self.number(fields, "source")?.map(|x| x as u8),
                interface: self.word(fields, "interface")?,
            })),
            _ => Err(self.no_entry("the entry", can, line)),
        }
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
        Ok(Conversion {
            unit,
            scale: self.number(fields, "scale")?,
            offset: self.number(fields, "offset")?.unwrap_or(0.0),
            sign,
        })
    }

    fn unit(&self, fields: &dyn TableLike, name: &str) -> Result<&'static str, Error> {
        unit::find(name).map(|u| u.name).ok_or_else(|| {
            let names = unit::UNITS.iter().map(|u| u.name);
            let remedy = hint(name, names, "the units are");
            self.error(
                self.line(fields, "unit"),
                format!("unknown unit {name}"),
                remedy,
            )
        })
    }

    fn can(&self, table: &dyn TableLike, line: usize) -> Result<Can, Error> {
        self.known(table, &["dbc", "master", "rate", "hold", "signals"])?;
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
        let rows = match (self.word(table, "master")?, self.number(table, "rate")?) {
            (Some(master), None) => Rows::Master(master),
            (None, Some(rate)) if rate > 0.0 && rate.is_finite() => Rows::Rate(rate),
            _ => {
                let what = "[can] does not say when there is a row";
                let remedy =
                    "write master = \"a signal\" (a row for each of its frames) or rate = 100 (Hz)";
                return Err(self.error(line, what, remedy));
            }
        };
        let signals = match table.get("signals").and_then(Item::as_table_like) {
            Some(signals) => self.entries(signals, true)?,
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
            rows,
            hold: self.number(table, "hold")?.unwrap_or(1.0),
            signals,
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
