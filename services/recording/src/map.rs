//! Signal maps: assignment of foreign columns or CAN signals to heft's signals, with their units.
//!
//! ```toml
//! [columns]
//! t = "t_s"                                             # renamed
//! swing_angle = { column = "swing_deg", unit = "deg" }  # with a unit
//! boom_angle = { column = "boom", unit = "deg", offset = 0.12 }
//! swing_velocity = { constant = 0.0 }                   # the same in every row
//! slope = "none"                                        # a column of that name is not used
//!
//! [columns.swing_torque]                                # a difference of two pressures [bar],
//! terms = [                                             # times the displacement [m^3/rad]
//!   { column = "pa", unit = "bar" },
//!   { column = "pb", unit = "bar", sign = -1 },
//! ]
//! scale = 2.1e-3
//!
//! [can]
//! dbc = ["j1939.dbc"]                                   # beside the map
//! master = "speed"                                      # a row for each of its frames, or rate = 100
//! hold = 0.5                                            # older values are missing [s]
//! j1939 = true                                          # if the DBC file should say so, and does not
//! [can.signals]
//! speed = { message = "CCVS1", signal = "WheelBasedVehicleSpeed", source = 0x00, delay = 0.02 }
//! ```
//!
//! A foreign MCAP file is read by topic and field:
//!
//! ```toml
//! [topics]
//! rate = 100                                            # or master = "a signal"
//! time = "header"                                       # or "log" (by default), "publish"
//! [topics.signals]
//! swing_velocity = { topic = "/joint_states", field = "velocity", name = "swing_joint" }
//! swing_torque = { topic = "/drive", field = "wrench.torque.z" }
//! ```
//!
//! A value becomes `sign * scale * (value in SI units) + offset`; terms are added before that. The
//! unit of a CAN signal is the DBC's; another one in the map is an
//! error. A unit of another dimension than the signal's needs a `scale`, the value of one SI unit of it in
//! the signal.
//!
//! `delay` is the time from the measurement of a value to its arrival [s]; `interpolate = true` interpolates
//! linearly between two values instead of holding the first. A value older than `max_age` [s] is missing, and so is an
//! interpolation over a longer time.

mod parse;

use std::path::{Path, PathBuf};

use config::nearest;

use crate::signal::Signal;
use crate::unit::Unit;
use crate::{Error, unit, whole};

/// A signal map.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    file: PathBuf,
    pub(crate) columns: Vec<Entry>,
    pub(crate) can: Option<Can>,
    pub(crate) topics: Option<Topics>,
}

/// A signal of heft in a map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    /// heft's name.
    pub signal: String,
    /// The terms of its sum.
    pub terms: Vec<Term>,
    /// Conversion of the sum to the signal.
    pub conversion: Conversion,
    line: usize,
}

/// A term of a signal, usually the only one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Term {
    /// Its origin.
    pub origin: Origin,
    /// Conversion to SI units.
    pub conversion: Conversion,
    pub timing: Timing,
}

/// Origin of a term.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Origin {
    /// The column of this name.
    Column(String),
    /// This value in every row.
    Constant(f64),
    /// No origin: the signal is absent, and a column of its name is not used.
    Nowhere,
    /// A CAN signal.
    Can(CanName),
    /// A number in the messages of a topic.
    Topic(TopicName),
}

/// Name of a number in a foreign MCAP file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TopicName {
    pub topic: String,
    /// Path of its field.
    pub field: String,
    /// Name of the entry in a list.
    pub name: Option<String>,
}

/// The time of a message that is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TopicTime {
    /// When it was recorded.
    Log,
    /// When it was published.
    Publish,
    /// The time in its own header.
    Header,
}

/// The part of a map for a foreign MCAP file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Topics {
    pub rows: Rows,
    pub time: TopicTime,
    /// Age at which a held value becomes missing [s].
    pub hold: f64,
    pub signals: Vec<Entry>,
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

/// Time of measurement of a value, and interpolation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Timing {
    /// Time from the measurement to the arrival [s].
    pub delay: f64,
    /// Linear interpolation between two values, instead of holding the first.
    pub interpolate: bool,
    /// Age at which a value becomes missing [s]; none: that of the whole map.
    pub max_age: Option<f64>,
}

/// Conversion of a foreign value to the signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Conversion {
    pub unit: Option<&'static Unit>,
    pub scale: Option<f64>,
    offset: f64,
    sign: f64,
}

impl Conversion {
    /// No conversion.
    pub(crate) const NONE: Self = Self {
        unit: None,
        scale: None,
        offset: 0.0,
        sign: 1.0,
    };

    fn factor(&self) -> f64 {
        let factor = self.unit.map_or(1.0, |u| u.factor);
        self.sign * self.scale.unwrap_or(1.0) * factor
    }

    /// A whole turn before a conversion that results in `turn`.
    pub(crate) fn turn(&self, turn: f64) -> f64 {
        turn / self.factor().abs()
    }

    /// The signal's value. One that needs no conversion keeps its bits.
    pub(crate) fn apply(&self, value: f64) -> f64 {
        let factor = self.factor();
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
    /// Whether messages with 29-bit identifiers are J1939's, if the DBC file does not state it.
    pub j1939: Option<bool>,
    pub rows: Rows,
    /// Age at which a held value becomes missing [s].
    pub hold: f64,
    pub signals: Vec<Entry>,
}

/// Times of the rows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Rows {
    /// At each frame with this signal.
    Master(String),
    /// At this rate [Hz].
    Rate(f64),
}

impl Entry {
    /// An entry with one value without conversion.
    fn plain(signal: &str, origin: Origin, line: usize) -> Self {
        Self {
            signal: signal.into(),
            terms: vec![Term {
                origin,
                conversion: Conversion::NONE,
                timing: Timing::default(),
            }],
            conversion: Conversion::NONE,
            line,
        }
    }

    /// Whether the signal is absent by the map.
    pub(crate) fn is_nowhere(&self) -> bool {
        self.terms.iter().any(|t| t.origin == Origin::Nowhere)
    }

    /// The signal's value: the sum of its terms' values. One term alone keeps its bits.
    pub(crate) fn combine(&self, values: impl Iterator<Item = f64>) -> f64 {
        let sum = values.reduce(|a, b| a + b).unwrap_or(f64::NAN);
        self.conversion.apply(sum)
    }

    /// A whole turn of a value before the conversion to one of its terms.
    pub(crate) fn turn(&self, conversion: &Conversion, signal: &Signal) -> f64 {
        conversion.turn(self.conversion.turn(signal.turn()))
    }
}

impl Map {
    /// Reads a map from a file.
    ///
    /// # Errors
    /// The file cannot be read or is no map.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = String::from_utf8(whole::read(path, "signal map")?);
        let text = text.map_err(|_| {
            Error::new(
                "the signal map is no text in UTF-8",
                path.display().to_string(),
                "save it as UTF-8; `heft map` writes a first one",
            )
        })?;
        Self::parse(&text, path)
    }

    /// Reads a map from a text; `path` is the name for errors, and its folder that of the DBC files.
    ///
    /// # Errors
    /// The text is no map.
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, Error> {
        parse::map(text, path.as_ref())
    }

    /// Sign and unit of a signal with a single term, as lines of a map.
    #[must_use]
    pub fn said(&self, signal: &str) -> Vec<String> {
        let can = self.can.iter().flat_map(|can| &can.signals);
        let topics = self.topics.iter().flat_map(|topics| &topics.signals);
        let mut all = self.columns.iter().chain(can).chain(topics);
        let Some([term]) = all.find(|e| e.signal == signal).map(|e| &e.terms[..]) else {
            return Vec::new();
        };
        let Conversion { unit, sign, .. } = term.conversion;
        let unit = unit.map(|unit| format!("unit = \"{}\"", unit.name));
        let sign = (sign < 0.0).then(|| "sign = -1".to_owned());
        unit.into_iter().chain(sign).collect()
    }

    /// Whether the map names CAN signals.
    #[must_use]
    pub fn has_can(&self) -> bool {
        self.can.is_some()
    }

    /// Whether the map names topics of a foreign MCAP file.
    #[must_use]
    pub fn has_topics(&self) -> bool {
        self.topics.is_some()
    }

    /// Requires one entry of each group of signals that a machine needs.
    pub(crate) fn require<S: crate::Sensors>(
        &self,
        entries: &[Entry],
        table: &str,
    ) -> Result<(), Error> {
        let has = |name: &str| entries.iter().any(|e| e.signal == name && !e.is_nowhere());
        let mut groups = S::REQUIRED.iter();
        let missing =
            groups.find(|group| !group.iter().any(|name| has(name)) && !are_absent(entries, group));
        missing.map_or(Ok(()), |group| {
            let names = group.join(" or ");
            Err(Error::new(
                format!("the map names no signal for {names} ({})", S::MACHINE),
                self.file(),
                format!(
                    "add it under {table}, or say {{ constant = ... }}, or \"none\" if there is no such sensor"
                ),
            ))
        })
    }

    /// Place of an entry.
    pub(crate) fn place(&self, entry: &Entry) -> String {
        format!("{}:{}", self.file.display(), entry.line)
    }

    /// The map's file, as it was named.
    pub(crate) fn file(&self) -> String {
        self.file.display().to_string()
    }

    /// Checks names and units of entries against the signals of a machine.
    pub(crate) fn check(&self, entries: &[Entry], signals: &[Signal]) -> Result<(), Error> {
        for entry in entries {
            let signal = self.signal(entry, signals)?;
            for term in &entry.terms {
                self.check_unit(entry, term.conversion, signal)?;
            }
        }
        Ok(())
    }

    /// The signal of an entry.
    pub(crate) fn signal<'a>(
        &self,
        entry: &Entry,
        signals: &'a [Signal],
    ) -> Result<&'a Signal, Error> {
        let found = signals.iter().find(|s| s.name == entry.signal);
        found.ok_or_else(|| {
            let names = signals.iter().map(|s| s.name.as_str());
            Error::new(
                format!("heft has no signal {}", entry.signal),
                self.place(entry),
                hint(&entry.signal, names, "the signals are"),
            )
        })
    }

    /// Requires the signal's dimension of a term, or a scale that converts it.
    pub(crate) fn check_unit(
        &self,
        entry: &Entry,
        conversion: Conversion,
        signal: &Signal,
    ) -> Result<(), Error> {
        let scaled = conversion.scale.or(entry.conversion.scale).is_some();
        match conversion.unit {
            Some(u) if u.si != signal.unit && !scaled => Err(Error::new(
                match signal.unit {
                    "" => format!(
                        "{} is a number without a unit, not in {}",
                        signal.name, u.name
                    ),
                    unit => format!("{} is measured in {unit}, not in {}", signal.name, u.name),
                },
                self.place(entry),
                format!(
                    "name a unit of it ({}), or add scale = how many {} one {} is",
                    unit::of(signal.unit),
                    signal.unit,
                    u.si
                ),
            )),
            _ => Ok(()),
        }
    }

    /// A term's conversion with the unit of the DBC file.
    pub(crate) fn with_dbc_unit(
        &self,
        entry: &Entry,
        conversion: Conversion,
        dbc: &str,
        signal: &Signal,
    ) -> Result<Conversion, Error> {
        let scaled = conversion.scale.or(entry.conversion.scale).is_some();
        match (conversion.unit, unit::guess(dbc)) {
            (Some(own), Some(theirs)) if !unit::same(own, theirs) => Err(Error::new(
                format!(
                    "{} is in {} by the map and in {dbc} by the DBC",
                    entry.signal, own.name
                ),
                self.place(entry),
                "leave out unit = where the DBC is right; where it is wrong, correct it there",
            )),
            (None, Some(theirs)) => {
                let conversion = Conversion {
                    unit: Some(theirs),
                    ..conversion
                };
                self.check_unit(entry, conversion, signal)?;
                Ok(conversion)
            }
            (None, None) if !dbc.is_empty() && !scaled && !signal.unit.is_empty() => {
                Err(Error::new(
                    format!("the DBC's unit \"{dbc}\" of {} is not known", entry.signal),
                    self.place(entry),
                    format!(
                        "say unit = ..., or scale = how many {} one of it is",
                        signal.unit
                    ),
                ))
            }
            _ => Ok(conversion),
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
/// Whether the map states each of these signals as absent (`"none"`).
pub(crate) fn are_absent(entries: &[Entry], names: &[&str]) -> bool {
    let is_absent = |name: &&str| entries.iter().any(|e| e.signal == *name && e.is_nowhere());
    names.iter().all(is_absent)
}
