//! Checks whether samples can be of the machine that a machine file describes: units, signs, columns that are exchanged or that no
//! sensor measures, another size. Each finding is a text with its remedy. The command line and the Python package say the same.

mod advice;
pub mod excavator;
pub mod loader;
mod look;
mod still;
mod units;

pub use advice::advised;
pub use look::Look;
