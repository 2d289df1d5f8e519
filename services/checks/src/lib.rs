//! Checks whether samples can be of the machine that a machine file describes: units, signs, columns that are exchanged or that no
//! sensor measures, another size. Each is a [`recording::Finding`]: what is wrong, and the remedy. The command line and the Python package say
//! the same.

mod advice;
pub mod excavator;
pub mod loader;
mod look;
mod still;
mod units;

pub use advice::advised;
pub use look::Look;

/// The text of a finding; empty for none.
#[cfg(test)]
fn text(fault: Option<recording::Finding>) -> String {
    fault.map_or_else(String::new, |fault| fault.to_string())
}
