//! Columns of a recording.

use messages::{Value, Words, channels, words};

use super::Values;
use crate::presence::Recorded;
use crate::schema::RecordedField;
use crate::{Error, Reader};

/// A recorded field over all messages of its channel.
#[derive(Debug, Clone)]
pub struct RecordedColumn {
    /// Name, unit, type.
    pub field: RecordedField,
    /// Its meaning in this version; "" for an unknown field.
    pub meaning: &'static str,
    /// One value per message; NaN for a number that was not measured, or is not estimated.
    pub values: Vec<Value>,
}

/// The columns of a recorded channel.
///
/// # Errors
/// The recording is damaged.
pub fn channel(reader: &Reader, channel: &str) -> Result<Vec<RecordedColumn>, Error> {
    let fields = reader.fields(channel);
    let numbers = Recorded::of(channel, &fields);
    let mut columns: Vec<Vec<Value>> = vec![Vec::new(); fields.len()];
    reader.for_each_value(channel, |_, values| {
        let lacks = numbers.lacks(values);
        for (i, (column, value)) in columns.iter_mut().zip(values).enumerate() {
            column.push(if lacks(i) {
                Value::F64(f64::NAN)
            } else {
                *value
            });
        }
    })?;
    let known = channels::find(channel).map(|c| c.payload.shape());
    let meaning = |name: &str| {
        let fields = known.into_iter().flat_map(|shape| shape.fields);
        let field = fields.into_iter().find(|f| f.name == name);
        field.map_or("", |f| f.doc.trim())
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

/// A column of words or flags derived from a field.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedWords {
    /// Name; it replaces a field of the same name.
    pub name: String,
    /// Its meaning.
    pub meaning: &'static str,
    /// Flags or words.
    pub values: Values,
}

/// The codes of a recorded channel by their names, and its flags.
pub fn verdict(channel: &str, columns: &[RecordedColumn]) -> Vec<NamedWords> {
    let Some(known) = channels::find(channel).map(|c| c.payload.shape()) else {
        return Vec::new();
    };
    let column = |name: &str| columns.iter().find(|c| c.field.name == name);
    let number = |value: &Value| value.as_f64() as u32;
    let codes = known.words.iter().filter_map(|(field, words)| {
        let (column, Words::Codes(entries)) = (column(field)?, words) else {
            return None;
        };
        // Codes are indices into the list; an unknown code is the index after the last.
        let mut names: Vec<&'static str> = entries.iter().map(|e| e.name).collect();
        names.push(words::UNKNOWN);
        let last = u32::try_from(entries.len()).unwrap_or_default();
        let place = |v: &Value| u8::try_from(number(v).min(last)).unwrap_or(u8::MAX);
        Some(NamedWords {
            name: (*field).into(),
            meaning: column.meaning,
            values: Values::Words(column.values.iter().map(place).collect(), names),
        })
    });
    let flags = column("flags").into_iter().flat_map(|column| {
        words::flags(known).map(|(name, entry)| {
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
