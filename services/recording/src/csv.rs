//! CSV in and out.

mod columns;
mod dialect;
mod estimate;
mod export;
mod read;

pub(crate) use columns::Columns;
pub(crate) use dialect::{Dialect, separator_line};
pub use estimate::{Column, Estimate, EstimateWriter, is_estimates};
pub use export::export;
pub(crate) use read::{TableRows, names, numbers};
pub use read::{read_excavator, read_loader, read_weighings};
