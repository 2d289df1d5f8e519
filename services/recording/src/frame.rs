//! Tables in memory for the bindings: rows of samples from columns, and columns from estimates.

mod estimates;
mod recorded;
mod samples;

pub use crate::csv::Cell;
pub use estimates::{Cells, Kind, NamedColumn, Table, Values, header};
pub use recorded::{NamedWords, RecordedColumn, channel, verdict};
pub use samples::{Feed, rows, signals_of};
