//! Messages as lines of CSV or JSON.

use std::io::{self, Write};

use messages::{Envelope, Field, Value};
use serde_json::{Map, json};

/// How a table is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// A header and rows.
    Csv,
    /// An object a line.
    Json,
}

/// A table in the making.
pub struct Table {
    format: Format,
    /// Columns of the last row.
    columns: Vec<&'static str>,
}

impl Table {
    /// An empty one.
    #[must_use]
    pub fn new(format: Format) -> Self {
        Self {
            format,
            columns: Vec::new(),
        }
    }

    /// Writes a message behind what is to be said of it. One with other fields begins with a header of its own.
    ///
    /// # Errors
    /// Nothing more can be written.
    pub fn row(
        &mut self,
        out: &mut impl Write,
        said: &[(&str, serde_json::Value)],
        message: &Envelope,
    ) -> io::Result<()> {
        if self.format == Format::Json {
            let own = said.iter().map(|(n, v)| ((*n).to_owned(), v.clone()));
            let all = fields(message).map(|(f, v)| (f.name.to_owned(), number(v)));
            let object: Map<_, _> = own.chain(all).collect();
            return writeln!(out, "{}", serde_json::Value::from(object));
        }
        let columns: Vec<&str> = fields(message).map(|(f, _)| f.name).collect();
        if columns != self.columns {
            let own: Vec<&str> = said.iter().map(|(n, _)| *n).collect();
            writeln!(out, "{},{}", own.join(","), columns.join(","))?;
            self.columns = columns;
        }
        // Names of sites and machines have no comma, see `MachineId`.
        let plain = |v: &serde_json::Value| v.as_str().map_or_else(|| v.to_string(), str::to_owned);
        let own = said.iter().map(|(_, v)| plain(v));
        let all: Vec<String> = own
            .chain(fields(message).map(|(_, v)| number(v).to_string()))
            .collect();
        writeln!(out, "{}", all.join(","))
    }
}

/// The fields of a message; the machine's number within its host is not the fleet's.
fn fields(message: &Envelope) -> impl Iterator<Item = (&'static Field, Value)> {
    let all = message.fields().iter().enumerate().skip(1);
    all.filter_map(|(i, field)| Some((field, message.get(i)?)))
}

fn number(value: Value) -> serde_json::Value {
    match value {
        Value::U32(v) => json!(v),
        Value::U64(v) => json!(v),
        Value::F64(v) => json!(v),
    }
}
