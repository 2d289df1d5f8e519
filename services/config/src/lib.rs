//! Descriptions of a machine, its sensors and its estimator as TOML files, with units,
//! ranges and defaults. Errors name the line and the remedy.
//!
//! Every key has one row in a table of `estimation`, beside the algorithm that it sets. The
//! structures, their defaults, the parser, `--set`, the range checks, the suggestions and the
//! printed form all come from it. A description is
//! complete: keys that a file does not state have the default of the specification. [`Tables::to_toml`] prints
//! all of it, so that a recording can contain the settings of its run.

mod class;
mod description;
mod entries;
mod error;
mod excavator;
mod keyed;
mod known;
mod loader;
mod nearest;
mod parse;
mod print;
mod remembered;
mod renamed;
mod stated;
mod tables;
mod toml_error;

pub use class::{mass_key, reference_mass};

pub use description::*;
pub use error::{Error, Errors};
pub use estimation::excavator::keys::Variant;
pub use estimation::keys::{Form, Key, Numbers, Range, Setting, Table, Value};
pub use estimation::loader::keys::{Inputs, LoadTransfer, Tuning};
pub use keyed::Keyed;
pub use known::keys;
pub use nearest::nearest;
pub use remembered::{CORRELATION, recalled, serves};
pub use renamed::{is_retired, old_names, renamed};
pub use tables::Tables;
pub use toml_error::{toml_error, toml_remedy};
