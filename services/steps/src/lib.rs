//! Conversion between messages and algorithms, and the steps of the processes.
//!
//! The only crate that depends on both the messages and the algorithms. Per machine:
//!
//! | file | what |
//! |---|---|
//! | `sample` | sensor message to sample |
//! | `motion` | swing motion to message and back (excavator) |
//! | `estimate` | estimate to message |
//! | `filter`, `regression`, `estimator` | the steps of the processes |
//! | [`loads`] | estimates to loads, for every machine |
//! | `pipeline` | the machine's processes: its rows of the table in [`stages`] |

mod bits;
pub mod chain;
mod error;
pub mod excavator;
mod idle;
mod kept;
pub mod loader;
pub mod loads;
mod rows;
mod source;
pub mod stages;

pub use error::{Error, described};
pub use idle::{Idle, idle_keys};
