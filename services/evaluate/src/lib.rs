//! Monte-Carlo evaluation: the only crate that uses both the truth (`sim`) and the estimators (`estimation`).
//!
//! Every table runs many seeds in parallel, compares the estimates with the truth and reports which targets are met.
//! [`Options::table`] selects one table; without it everything is evaluated.
//!
//! | module | what |
//! |---|---|
//! | [`excavator`], [`loader`] | the tables of a machine, a file each |
//! | [`honesty`] | share of wrong values among the trusted: sums and lines for both |
//! | [`text`] | tables as text |

mod error;
pub mod excavator;
pub mod honesty;
pub mod loader;
mod loads;
mod options;
mod parallel;
mod tables;
pub mod text;
mod weighing;

pub use error::Error;
pub use options::{Options, Report};
pub use parallel::seeds;
