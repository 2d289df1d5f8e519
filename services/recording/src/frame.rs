//! Tables in memory, as other languages have them: rows from columns, and columns from estimates.

use messages::channels::{self, Visitor};
use messages::{Machine, Message, Value};

use crate::csv::{Column, Estimate};
use crate::schema::RecordedField;
use crate::signal::{self, Builder, Row, Sensors, Signal};
use crate::{Error, Reader, machines};

/// The samples of a machine from columns of the names of its CSV; columns of other names are left out, a value that
/// is not finite is a missing sample.
///
/// # Errors
/// A column that is needed is missing, or the columns differ in length.
pub fn rows<S: Sensors>(columns: &[(&str, Vec<f64>)]) -> Result<Vec<Row<S>>, Error> {
    let place = "the table";
    let there = |name: &str| columns.iter().any(|(n, _)| *n == name);
    let time: &[&str] = &["t"];
    for group in [time].iter().chain(S::REQUIRED) {
        if !group.iter().any(|name| there(name)) {
            let what = format!("there is no column {} ({})", group.join(" or "), S::MACHINE);
            let found: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
            let remedy = format!("rename a column; the table has {}", found.join(", "));
            return Err(Error::new(what, place, remedy));
        }
    }
    let length = columns.first().map_or(0, |(_, values)| values.len());
    if let Some((name, values)) = columns.iter().find(|(_, v)| v.len() != length) {
        let what = format!("column {name} has {} values, not {length}", values.len());
        return Err(Error::new(what, place, "give columns of the same length"));
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
    let mut row = vec![0.0; known.len()];
    for i in 0..length {
        for (value, (_, values)) in row.iter_mut().zip(&known) {
            *value = values[i];
        }
        builder.push(&row, 0);
    }
    builder.finish();
    Ok(std::iter::from_fn(|| builder.next()).collect())
}

/// One column of estimates.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers; NaN where the method does not estimate the quantity.
    Numbers(Vec<f64>),
    /// Flags.
    Flags(Vec<bool>),
    /// Words.
    Words(Vec<&'static str>),
}

/// A column: name, SI unit, values.
pub type NamedColumn = (&'static str, &'static str, Values);

/// The columns that `heft estimate` writes, without the rows that were refused.
#[must_use]
pub fn columns_of<E: Estimate>(estimates: &[E]) -> Vec<NamedColumn> {
    let accepted: Vec<&E> = estimates
        .iter()
        .filter(|e| e.bits().0 & E::REFUSED == 0)
        .collect();
    let estimated = accepted.first().map_or(0, |e| e.bits().1);
    let extra: &[Column] = if estimated & E::EXTRA.1 == 0 {
        &[]
    } else {
        E::EXTRA.0
    };
    let times = accepted.iter().map(|e| e.stamp().time).collect();
    let mut columns = vec![("t", "s", Values::Numbers(times))];
    columns.extend(
        E::COLUMNS
            .iter()
            .chain(extra)
            .map(|c| column(*c, &accepted)),
    );
    let method = |e: &&E| {
        E::METHODS
            .get(e.bits().2 as usize)
            .copied()
            .unwrap_or_default()
    };
    columns.push((
        "method",
        "",
        Values::Words(accepted.iter().map(method).collect()),
    ));
    if !E::REASONS.is_empty() {
        let reason = |e: &&E| {
            let known = E::REASONS.get(e.reason() as usize);
            known.map_or("", |(name, _)| *name)
        };
        let reasons = accepted.iter().map(reason).collect();
        columns.push(("reason", "", Values::Words(reasons)));
    }
    columns
}

fn column<E: Estimate>(column: Column, estimates: &[&E]) -> NamedColumn {
    match column {
        Column::Flag(name, bit) => {
            let flags = estimates.iter().map(|e| e.bits().0 & bit != 0).collect();
            (name, "", Values::Flags(flags))
        }
        Column::Value(name, bits) => {
            let index = E::index(name);
            let number = |e: &&E| match index.and_then(|i| e.get(i)) {
                Some(Value::F64(x)) if e.bits().1 & bits == bits => x,
                _ => f64::NAN,
            };
            let unit = index.map_or("", |i| E::FIELDS[i].unit);
            (
                name,
                unit,
                Values::Numbers(estimates.iter().map(number).collect()),
            )
        }
    }
}

/// Names of the columns that samples of the machine can have; nothing for another machine.
#[must_use]
pub fn signals_of(machine: Machine) -> Vec<String> {
    (machines::of(machine).signals)()
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

/// What the field of this name means.
struct Meaning<'a>(&'a str);

impl Visitor for Meaning<'_> {
    type Output = &'static str;
    fn visit<M: Message>(self) -> &'static str {
        M::index(self.0).map_or("", |i| M::FIELDS[i].doc.trim())
    }
}
