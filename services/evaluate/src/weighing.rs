//! Columns and lines common to the `weighing` tables of both machines, and their formatting.

use serde_json::{Value, json};

use crate::text::{Table, plain};

/// A number of each line: its key in the JSON, its heading, and its format.
pub struct Column {
    key: &'static str,
    heading: &'static str,
    factor: f64,
    decimals: usize,
}

impl Column {
    /// A share, with this many decimals.
    pub const fn share(key: &'static str, heading: &'static str, decimals: usize) -> Self {
        Self {
            key,
            heading,
            factor: 1.0,
            decimals,
        }
    }

    /// A relative error, in percent.
    pub const fn error(key: &'static str, heading: &'static str) -> Self {
        Self {
            key,
            heading,
            factor: 100.0,
            decimals: 1,
        }
    }

    fn cell(&self, value: Option<f64>) -> String {
        value.map_or("-".into(), |v| plain(self.factor * v, self.decimals))
    }
}

/// A machine with the statements about it.
pub struct Line<const N: usize> {
    /// The machine.
    pub machine: &'static str,
    /// Statements and measurements.
    pub stated: &'static str,
    /// True loads.
    pub loads: usize,
    /// The number of each column, `None` if there is nothing to count.
    pub numbers: [Option<f64>; N],
    /// Whether the targets are met.
    pub met: bool,
}

impl<const N: usize> Line<N> {
    /// `machine`, `stated`, `seeds`, `loads`, `met`, and the number of each column; null where there is nothing to count.
    pub fn json(&self, columns: &[Column; N], seeds: usize) -> Value {
        let mut line = json!({
            "machine": self.machine, "stated": self.stated, "seeds": seeds, "loads": self.loads, "met": self.met,
        });
        for (column, value) in columns.iter().zip(self.numbers) {
            line[column.key] = json!(value);
        }
        line
    }
}

/// The lines as text.
pub fn text<const N: usize>(columns: &[Column; N], lines: &[Line<N>]) -> String {
    let mut header = vec!["machine", "stated"];
    header.extend(columns.iter().map(|column| column.heading));
    header.push("");
    let mut table = Table::new(&header);
    for line in lines {
        let mut cells = vec![line.machine.to_owned(), line.stated.to_owned()];
        cells.extend(columns.iter().zip(line.numbers).map(|(c, v)| c.cell(v)));
        cells.push(if line.met { "met" } else { "missed" }.into());
        table.row(cells);
    }
    table.to_string()
}

/// Whether a number is absent, or at most `limit`.
pub fn at_most(value: Option<f64>, limit: f64) -> bool {
    value.is_none_or(|v| v <= limit)
}

/// Whether a number is present and at least `limit`.
pub fn at_least(value: Option<f64>, limit: f64) -> bool {
    value.is_some_and(|v| v >= limit)
}
