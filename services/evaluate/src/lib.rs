//! Monte-Carlo evaluation: the one place where truth (`sim`) and belief (`estimation`) meet.
//!
//! Every table runs many seeds in parallel, compares the estimates with the truth and says which targets are
//! met. [`Options::table`] selects one table; without it everything is evaluated.

mod error;
pub mod excavator;
pub mod honesty;
pub mod loader;
mod options;
mod parallel;
pub mod text;

pub use error::Error;
pub use options::{Options, Report};
pub use parallel::seeds;

/// Evaluates the excavator's estimators.
///
/// # Errors
/// The table is unknown, or the estimators refuse their settings.
pub fn excavator(options: &Options) -> Result<Report, Error> {
    excavator::evaluate(options)
}

/// Evaluates the loader's estimators.
///
/// # Errors
/// The table is unknown, or the estimators refuse their settings.
pub fn loader(options: &Options) -> Result<Report, Error> {
    loader::evaluate(options)
}
