//! Monte-Carlo evaluation: the one place where truth (`sim`) and belief (`estimation`) meet.
//!
//! Every table runs many seeds in parallel, compares the estimates with the truth and says which targets are
//! met. [`Options::table`] selects one table; without it everything is evaluated.
//!
//! | module | what |
//! |---|---|
//! | [`excavator`], [`loader`] | the tables of a machine, a file each |
//! | [`honesty`] | of what is called trusted, how much is wrong: sums and lines for both |
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
