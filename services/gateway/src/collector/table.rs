//! Messages as lines of CSV or JSON: codes by their names, and each flag as a column of its own.

use std::borrow::Cow;
use std::io::{self, Write};

use messages::words::{Said, said};
use messages::{Envelope, Message, Receiver, Value};
use serde_json::{Map, json};

/// How a table is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// A header and rows.
    Csv,
    /// An object a line.
    Json,
}

/// A table under construction.
pub struct Table {
    format: Format,
    /// Columns of the last row.
    columns: Vec<Cow<'static, str>>,
}

impl Table {
    /// An empty table.
    pub fn new(format: Format) -> Self {
        Self {
            format,
            columns: Vec::new(),
        }
    }

    /// Writes a message after the columns `said`. A message with other columns than the last starts with a new header.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn row(
        &mut self,
        out: &mut impl Write,
        said: &[(&str, serde_json::Value)],
        message: &Envelope,
    ) -> io::Result<()> {
        let cells = message.open(Cells);
        if self.format == Format::Json {
            let own = said.iter().map(|(n, v)| ((*n).to_owned(), v.clone()));
            let all = cells.into_iter().map(|(name, v)| (name.into_owned(), v));
            let object: Map<_, _> = own.chain(all).collect();
            return writeln!(out, "{}", serde_json::Value::from(object));
        }
        let (columns, values): (Vec<_>, Vec<_>) = cells.into_iter().unzip();
        if columns != self.columns {
            let own: Vec<&str> = said.iter().map(|(n, _)| *n).collect();
            writeln!(out, "{},{}", own.join(","), columns.join(","))?;
            self.columns = columns;
        }
        // Names of sites and machines contain no comma, see `MachineId`; nor do the names of codes.
        let all = said.iter().map(|(_, v)| v).chain(&values);
        let all: Vec<String> = all.map(plain).collect();
        writeln!(out, "{}", all.join(","))
    }
}

/// A flag is 1 or 0, and a missing number an empty cell, as in the tables of `heft estimate`.
fn plain(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::String(text) => text.clone(),
        serde_json::Value::Bool(flag) => u8::from(*flag).to_string(),
        serde_json::Value::Null => String::new(),
        other => other.to_string(),
    }
}

/// Names and values of a message, without the machine's number within its host.
struct Cells;

impl Receiver for Cells {
    type Output = Vec<(Cow<'static, str>, serde_json::Value)>;

    fn receive<M: Message>(self, message: &M) -> Self::Output {
        let value = |value| match value {
            Said::Number(number) => self::number(number),
            Said::Flag(flag) => json!(flag),
            Said::Word(word) => json!(word),
            Said::Missing => serde_json::Value::Null,
        };
        let all = said(message).skip(1);
        all.map(|(name, said)| (name, value(said))).collect()
    }
}

fn number(value: Value) -> serde_json::Value {
    match value {
        Value::U32(v) => json!(v),
        Value::U64(v) => json!(v),
        Value::F64(v) => json!(v),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorEstimate, excavator_bits};

    #[test]
    fn the_verdict_is_a_column_and_codes_are_names() {
        let message = Envelope::ExcavatorEstimate(ExcavatorEstimate {
            flags: excavator_bits::TRUSTED,
            method: 3,
            reason: 11,
            ..ExcavatorEstimate::default()
        });
        let mut out = Vec::new();
        let said = [("site", json!("north"))];
        let mut table = Table::new(Format::Csv);
        table.row(&mut out, &said, &message).expect("written");
        let text = String::from_utf8(out).expect("text");
        let (header, row) = text.split_once('\n').expect("a header");
        let cells: std::collections::BTreeMap<&str, &str> =
            header.split(',').zip(row.trim_end().split(',')).collect();
        assert_eq!(
            (cells["site"], cells["trusted"], cells["excited"]),
            ("north", "1", "0")
        );
        assert_eq!(
            (cells["method"], cells["reason"]),
            ("posture-torque", "content")
        );
        assert!(!cells.contains_key("machine"), "{header}");
    }
}
