//! CSV in and out.

mod columns;
mod dialect;
mod estimate;
mod export;
mod read;

pub use estimate::{Column, Estimate, EstimateWriter, is_estimates};
pub use export::export;
pub(crate) use read::read;
pub use read::{read_excavator, read_loader, read_weighings};
