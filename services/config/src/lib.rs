//! Descriptions of a machine, its sensors and its estimator: what a TOML file may say, with units,
//! ranges and defaults, and errors that name the line and what to do.
//!
//! Every key stands in one table ([`Key`]); the structures, their defaults, the parser, `--set`,
//! the range checks, the suggestions and the printed form all come from it. A description is
//! complete: what a file does not say has the default of the specification, and
//! [`Excavator::to_toml`] prints all of it, so that a recording can carry the settings of its run.

mod description;
mod error;
mod excavator;
mod loader;
mod nearest;
mod parse;
mod print;
mod setting;

pub use description::Description;
pub use error::{Error, Errors};
pub use excavator::{
    Excavator, ExcavatorEstimator, ExcavatorGeometry, ExcavatorMachine, ExcavatorPaper,
    ExcavatorPrior, ExcavatorSensors, Variant,
};
pub use loader::{
    Inputs, LoadTransfer, Loader, LoaderEstimator, LoaderMachine, LoaderPrior, LoaderSensors,
    Tuning,
};
pub use nearest::nearest;
pub use setting::{Form, Key, Range, Setting, Table, Tables, Value};
