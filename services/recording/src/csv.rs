//! CSV in and out.

mod absent;
mod cells;
mod columns;
mod dialect;
mod estimate;
mod export;
mod exported;
mod front;
mod header;
mod marks;
mod no_number;
mod read;
mod several;

pub(crate) use absent::{listed, misread};
pub(crate) use cells::Cells;
pub(crate) use columns::Columns;
pub use columns::label;
pub(crate) use dialect::Dialect;
pub(crate) use dialect::name;
pub use estimate::{Cell, Codes, Column, Estimate, EstimateRows, EstimateWriter, is_estimates};
pub(crate) use estimate::{Values as EstimateValues, columns, count, estimate_of};
pub use export::{export, is_export};
pub(crate) use front::{Front, Line, Lines, MOST_ABOVE, comment, is_by_blanks};
pub(crate) use header::{check_units, header};
pub(crate) use no_number::ZEROS;
pub(crate) use read::several;
pub(crate) use read::{Look, TableRows, look};
pub use read::{misspelt, read, read_weighings};
pub(crate) use several::By;

/// A cell of a CSV, in quotes where it must be.
pub fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}
