//! Tables in memory, as other languages have them: rows from columns, and columns from estimates.

use std::marker::PhantomData;

use messages::channels::{self, Visitor};
use messages::{Machine, Message, Value, Words};

use crate::csv::{Column, Estimate};
use crate::map::hint;
use crate::schema::RecordedField;
use crate::signal::{self, Builder, Row, Sensors, Signal};
use crate::{Error, Reader};

/// The samples of a machine from columns of the names of its CSV, one after the other; columns of other names are
/// left out, a value that is not finite is a missing sample.
///
/// # Errors
/// A column that is needed is missing, or the columns differ in length.
pub fn rows<'a, S: Sensors>(
    columns: &'a [(&str, Vec<f64>)],
) -> Result<impl Iterator<Item = Row<S>> + 'a, Error> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    check_required::<S>(&names)?;
    let length = columns.first().map_or(0, |(_, values)| values.len());
    if let Some((name, values)) = columns.iter().find(|(_, v)| v.len() != length) {
        let what = format!("column {name} has {} values, not {length}", values.len());
        return Err(Error::new(what, TABLE, "give columns of the same length"));
    }
    let signals = signal::signals::<S>();
    let known: Vec<(&Signal, &[f64])> = signals
        .iter()
        .filter_map(|signal| {
            let column = columns.iter().find(|(name, _)| *name == signal.name)?;
            Some((signal, column.1.as_slice()))
        })
        .collect();
    let mut builder = Builder::<S>::new(known.iter().map(|(signal, _)| *signal));
    let values: Vec<&[f64]> = known.into_iter().map(|(_, values)| values).collect();
    let mut row = vec![0.0; values.len()];
    let mut at = 0;
    Ok(std::iter::from_fn(move || {
        loop {
            if let Some(next) = builder.next() {
                return Some(next);
            }
            if at == length {
                builder.finish();
                return builder.next();
            }
            for (value, values) in row.iter_mut().zip(&values) {
                *value = values[at];
            }
            builder.push(&row, 0);
            at += 1;
        }
    }))
}

const TABLE: &str = "the table";

/// Refuses signals among which one that the machine needs is missing.
fn check_required<S: Sensors>(names: &[&str]) -> Result<(), Error> {
    let time: &[&str] = &["t"];
    let mut groups = [time].into_iter().chain(S::REQUIRED.iter().copied());
    let missing = groups.find(|group| !group.iter().any(|name| names.contains(name)));
    missing.map_or(Ok(()), |group| {
        let what = format!("there is no column {} ({})", group.join(" or "), S::MACHINE);
        let remedy = format!("rename a column; the table has {}", names.join(", "));
        Err(Error::new(what, TABLE, remedy))
    })
}

/// Makes samples one by one, as they come; the source has all signals that were named, be they silent at first.
#[derive(Debug)]
pub struct Feed<S: Sensors> {
    builder: Builder<S>,
}

impl<S: Sensors> Feed<S> {
    /// Rows will have the values of these signals, in this order; the time is one of them.
    ///
    /// # Errors
    /// A signal is not known or named twice, or one that is needed is missing.
    pub fn new(names: &[&str]) -> Result<Self, Error> {
        let all = signal::signals::<S>();
        let known = |name: &str| all.iter().find(|s| s.name == name);
        for (i, name) in names.iter().enumerate() {
            if known(name).is_none() {
                let known = all.iter().map(|s| s.name.as_str());
                let what = format!("a {} has no signal {name}", S::MACHINE);
                let remedy = hint(name, known, "the signals are");
                return Err(Error::new(what, "the signals", remedy));
            }
            if names[..i].contains(name) {
                let what = format!("{name} is named twice");
                return Err(Error::new(what, "the signals", "name each signal once"));
            }
        }
        check_required::<S>(names)?;
        let signals = names.iter().filter_map(|name| known(name));
        Ok(Self {
            builder: Builder::with_all(signals),
        })
    }

    /// The next sample; a value that is not finite is missing.
    pub fn sample(&mut self, values: &[f64]) -> S {
        self.builder.push(values, 0);
        self.builder
            .next()
            .map_or_else(S::default, |(sample, _)| sample)
    }

    /// How many samples were made.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.builder.count()
    }

    /// Goes on counting from here.
    pub fn go_on_from(&mut self, count: u64) {
        self.builder.go_on_from(count);
    }
}

/// One column of estimates.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers; NaN where the method does not estimate the quantity.
    Numbers(Vec<f64>),
    /// Flags.
    Flags(Vec<bool>),
    /// Words by their code, which is their place in the list.
    Words(Vec<u8>, Vec<&'static str>),
}

/// A column: name, SI unit, values.
pub type NamedColumn = (&'static str, &'static str, Values);

/// Estimates in columns, as `heft estimate` writes them, without the rows that were refused.
#[derive(Debug)]
pub struct Table<E: Estimate> {
    times: Vec<f64>,
    columns: Vec<(Column, Option<usize>, Filled)>,
    /// Whether the method has the quantities that few methods have.
    has_extra: Option<bool>,
    methods: Vec<u8>,
    reasons: Vec<u8>,
    rows: u32,
    /// Places of the rows that were refused.
    refused: Vec<u32>,
    estimates: PhantomData<E>,
}

#[derive(Debug)]
enum Filled {
    Numbers(Vec<f64>),
    Flags(Vec<bool>),
}

impl<E: Estimate> Table<E> {
    /// An empty table with room for so many rows.
    #[must_use]
    pub fn with_capacity(rows: usize) -> Self {
        let column = |c: &Column| match *c {
            Column::Flag(..) => (*c, None, Filled::Flags(Vec::with_capacity(rows))),
            Column::Value(name, _) => (
                *c,
                E::index(name),
                Filled::Numbers(Vec::with_capacity(rows)),
            ),
        };
        Self {
            times: Vec::with_capacity(rows),
            has_extra: None,
            columns: E::COLUMNS.iter().chain(E::EXTRA.0).map(column).collect(),
            methods: Vec::with_capacity(rows),
            reasons: Vec::with_capacity(rows),
            rows: 0,
            refused: Vec::new(),
            estimates: PhantomData,
        }
    }

    /// Adds a row; one that was refused is noted as such.
    pub fn push(&mut self, estimate: &E) {
        let (flags, estimated, method) = estimate.bits();
        self.rows += 1;
        if flags & E::REFUSED != 0 {
            self.refused.push(self.rows - 1);
            return;
        }
        self.has_extra.get_or_insert(estimated & E::EXTRA.1 != 0);
        self.times.push(estimate.stamp().time);
        for (column, index, cells) in &mut self.columns {
            match (cells, *column) {
                (Filled::Flags(cells), Column::Flag(_, bit)) => cells.push(flags & bit != 0),
                (Filled::Numbers(cells), Column::Value(_, bits)) => {
                    cells.push(number(estimate, *index, estimated & bits == bits));
                }
                _ => {}
            }
        }
        self.methods.push(u8::try_from(method).unwrap_or(u8::MAX));
        self.reasons
            .push(u8::try_from(estimate.reason()).unwrap_or(u8::MAX));
    }

    /// Places of the rows that were refused.
    #[must_use]
    pub fn refused(&self) -> &[u32] {
        &self.refused
    }

    /// The columns; those of quantities that few methods have, only where this one has them.
    #[must_use]
    pub fn finish(self) -> Vec<NamedColumn> {
        let mut columns = vec![("t", "s", Values::Numbers(self.times))];
        for (i, (column, index, cells)) in self.columns.into_iter().enumerate() {
            let (Column::Flag(name, _) | Column::Value(name, _)) = column;
            let unit = index.map_or("", |i| E::FIELDS[i].unit);
            if i >= E::COLUMNS.len() && self.has_extra != Some(true) {
                break;
            }
            let values = match cells {
                Filled::Numbers(cells) => Values::Numbers(cells),
                Filled::Flags(cells) => Values::Flags(cells),
            };
            columns.push((name, unit, values));
        }
        columns.push((
            "method",
            "",
            Values::Words(self.methods, E::METHODS.to_vec()),
        ));
        if !E::REASONS.is_empty() {
            let names = E::REASONS.iter().map(|(name, _)| *name);
            columns.push(("reason", "", Values::Words(self.reasons, names.collect())));
        }
        columns
    }
}

/// A field of an estimate; NaN where it is not estimated.
fn number<E: Estimate>(estimate: &E, index: Option<usize>, is_estimated: bool) -> f64 {
    match index.and_then(|i| estimate.get(i)) {
        Some(Value::F64(x)) if is_estimated => x,
        _ => f64::NAN,
    }
}

/// A cell of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell {
    /// A number; NaN where the method does not estimate the quantity.
    Number(f64),
    /// A flag.
    Flag(bool),
    /// A word.
    Word(&'static str),
}

/// Name, unit and meaning of every column that an estimate of this kind can have: time, quantities, flags, whether
/// the row was refused, method and reason.
#[must_use]
pub fn header<E: Estimate>() -> Vec<(&'static str, &'static str, Kind)> {
    let column = |c: &Column| match *c {
        Column::Flag(name, _) => (name, "", Kind::Flag),
        Column::Value(name, _) => {
            let unit = E::index(name).map_or("", |i| E::FIELDS[i].unit);
            (name, unit, Kind::Number)
        }
    };
    let mut all = vec![("t", "s", Kind::Number)];
    all.extend(E::COLUMNS.iter().chain(E::EXTRA.0).map(column));
    all.extend([("refused", "", Kind::Flag), ("method", "", Kind::Method)]);
    all.push(("reason", "", Kind::Reason));
    all
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Numbers.
    Number,
    /// Flags.
    Flag,
    /// Names of methods.
    Method,
    /// Names of reasons.
    Reason,
}

/// Takes estimates apart into the cells of [`header`].
#[derive(Debug)]
pub struct Cells<E: Estimate> {
    columns: Vec<(Column, Option<usize>)>,
    estimates: PhantomData<E>,
}

impl<E: Estimate> Default for Cells<E> {
    fn default() -> Self {
        let column = |c: &Column| match *c {
            Column::Flag(..) => (*c, None),
            Column::Value(name, _) => (*c, E::index(name)),
        };
        Self {
            columns: E::COLUMNS.iter().chain(E::EXTRA.0).map(column).collect(),
            estimates: PhantomData,
        }
    }
}

impl<E: Estimate> Cells<E> {
    /// Calls `put` with the cells of an estimate in the order of [`header`].
    pub fn of(&self, estimate: &E, put: &mut dyn FnMut(Cell)) {
        let (flags, estimated, method) = estimate.bits();
        put(Cell::Number(estimate.stamp().time));
        for (column, index) in &self.columns {
            put(match *column {
                Column::Flag(_, bit) => Cell::Flag(flags & bit != 0),
                Column::Value(_, bits) => {
                    Cell::Number(number(estimate, *index, estimated & bits == bits))
                }
            });
        }
        put(Cell::Flag(flags & E::REFUSED != 0));
        let method = E::METHODS.get(method as usize);
        put(Cell::Word(method.copied().unwrap_or_default()));
        let reason = E::REASONS.get(estimate.reason() as usize);
        put(Cell::Word(reason.map_or("", |(name, _)| *name)));
    }
}

/// Names of the columns that samples of the machine can have; nothing for another machine.
#[must_use]
pub fn signals_of(machine: Machine) -> Vec<String> {
    signal::signals_of(machine)
        .into_iter()
        .map(|s| s.name)
        .collect()
}

/// A recorded field over all messages of its channel.
#[derive(Debug, Clone)]
pub struct RecordedColumn {
    /// Name, unit, type.
    pub field: RecordedField,
    /// What it means, as this version knows it; "" for a field of another.
    pub meaning: &'static str,
    /// One value per message; NaN for a signal that a sample lacks.
    pub values: Vec<Value>,
}

/// The columns of a recorded channel.
///
/// # Errors
/// The recording is damaged.
pub fn channel(reader: &Reader, channel: &str) -> Result<Vec<RecordedColumn>, Error> {
    let fields = reader.fields(channel);
    let at = |name: &str| fields.iter().position(|f| f.name == name);
    // Only messages of sensors have columns.
    let valid = at("columns").and_then(|_| at("valid"));
    let bits: Vec<u32> = fields
        .iter()
        .map(|f| valid.map_or(0, |_| signal::sensor_bit(channel, &f.name)))
        .collect();
    let mut columns: Vec<Vec<Value>> = vec![Vec::new(); fields.len()];
    reader.for_each_value(channel, |_, values| {
        let valid = valid.map_or(u32::MAX, |at| values[at].as_f64() as u32);
        for ((column, value), bit) in columns.iter_mut().zip(values).zip(&bits) {
            let there = bit & valid == *bit;
            column.push(if there { *value } else { Value::F64(f64::NAN) });
        }
    })?;
    let meaning = |name: &str| {
        let known = channels::all().find(|c| c.name == channel);
        known.map_or("", |c| c.payload.visit(Meaning(name)))
    };
    let columns = fields.iter().cloned().zip(columns);
    Ok(columns
        .map(|(field, values)| RecordedColumn {
            meaning: meaning(&field.name),
            field,
            values,
        })
        .collect())
}

/// A column of words or flags that is no field of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedWords {
    /// Name; where it is that of a field, it stands in its place.
    pub name: String,
    /// What it means.
    pub meaning: &'static str,
    /// Flags or words.
    pub values: Values,
}

/// The codes of a recorded channel by their names, and its flags.
#[must_use]
pub fn verdict(channel: &str, columns: &[RecordedColumn]) -> Vec<NamedWords> {
    let known = channels::all().find(|c| c.name == channel);
    known.map_or_else(Vec::new, |c| c.payload.visit(Verdict(columns)))
}

struct Verdict<'a>(&'a [RecordedColumn]);

impl Visitor for Verdict<'_> {
    type Output = Vec<NamedWords>;
    fn visit<M: Message>(self) -> Vec<NamedWords> {
        let column = |name: &str| self.0.iter().find(|c| c.field.name == name);
        let number = |value: &Value| value.as_f64() as u32;
        let codes = M::WORDS.iter().filter_map(|(field, words)| {
            let (column, Words::Codes(entries)) = (column(field)?, words) else {
                return None;
            };
            // Codes are places in the list; one that is not known is the place behind them.
            let mut names: Vec<&'static str> = entries.iter().map(|e| e.name).collect();
            names.push(messages::words::UNKNOWN);
            let last = u32::try_from(entries.len()).unwrap_or_default();
            let place = |v: &Value| u8::try_from(number(v).min(last)).unwrap_or(u8::MAX);
            Some(NamedWords {
                name: (*field).into(),
                meaning: column.meaning,
                values: Values::Words(column.values.iter().map(place).collect(), names),
            })
        });
        let flags = column("flags").into_iter().flat_map(|column| {
            messages::words::flags::<M>().map(|(name, entry)| {
                let set = |v: &Value| number(v) & entry.number != 0;
                NamedWords {
                    name: name.into_owned(),
                    meaning: entry.doc,
                    values: Values::Flags(column.values.iter().map(set).collect()),
                }
            })
        });
        codes.chain(flags).collect()
    }
}

/// What the field of this name means.
struct Meaning<'a>(&'a str);

impl Visitor for Meaning<'_> {
    type Output = &'static str;
    fn visit<M: Message>(self) -> &'static str {
        M::index(self.0).map_or("", |i| M::FIELDS[i].doc.trim())
    }
}
